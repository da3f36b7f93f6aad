"""White noise whose samples are Student's instead of normal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array
from imu_lib.errors import InputError

from .base import FREE, Parameter
from .stage import Stage


@dataclass(frozen=True)
class HeavyTails(Stage):
    """The white noise has Student's distribution of `freedom` degrees, its variance unchanged.

    A Student's variate is a normal one over a root of chi-square of its own (Student 1908): every
    white sample is given a scale of its own whose mean square is 1, so that spectrum, Allan
    variance and autocovariance stay what they are. They are the tails of a record as they are
    measured, whitened without phase: behind a filter they are given to white noise at the record's
    rate, and the filter's folded spectrum to that (of an oversampled filter each sample would be a
    mean of many steps, and normal again).

    Parameters
    ----------
    freedom : float, above 2 (at or below 2 the variance is infinite)
    """

    freedom: float = FREE
    name: ClassVar[str] = "heavy_tails"
    place: ClassVar[float] = -1
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("freedom", "ratio", "degrees of freedom, above 2"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.freedom is not None and self.freedom <= 2:
            raise InputError(
                f"process heavy_tails: `freedom` must be above 2, not {self.freedom:g}"
            )

    def scales(self, n: int, rng: np.random.Generator) -> Array:
        """Factors on the samples of a normal white noise, mean square 1, shape (n,)."""
        self._require()
        return np.sqrt((self.freedom - 2.0) / rng.chisquare(self.freedom, n))

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """On a bare signal: what deviates from its mean counts as white noise."""
        middle = np.mean(x)
        return middle + (x - middle) * self.scales(len(x), rng)
