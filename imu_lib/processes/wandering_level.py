"""A noise level that wanders slowly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array

from .base import FREE, Parameter
from .gauss_markov import GaussMarkov
from .stage import Stage
from .stages import NoiseLevelChange


@dataclass(frozen=True)
class WanderingLevel(Stage):
    """The fast noise is multiplied by exp(g - sd^2), g a Gauss-Markov process.

    `sd` is that of the logarithm of the level (of the standard deviation of the noise). The mean
    square of the factor is 1 (the mean of a lognormal exp(2 g) is exp(2 sd^2)), so that the mean
    spectrum and the mean Allan variance stay those of the noise.

    Parameters
    ----------
    sd : float, of the natural logarithm of the level
    correlation_time : float, s
    """

    sd: float = FREE
    correlation_time: float = FREE
    name: ClassVar[str] = "wandering_level"
    place: ClassVar[float] = NoiseLevelChange.place + 0.5
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sd", "ratio", "of the natural logarithm of the level"),
        Parameter("correlation_time", "time", "s"),
    )

    def draw(self, n: int, fs: float, rng: np.random.Generator) -> Array:
        """A draw of the factor on the fast noise, mean square 1, shape (n,)."""
        self._require()
        g = GaussMarkov(sigma=self.sd, correlation_time=self.correlation_time)
        return np.exp(g.simulate(n, fs, rng) - self.sd**2)

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """On a bare signal: what deviates from its mean counts as noise."""
        middle = np.mean(x)
        return middle + (x - middle) * self.draw(len(x), fs, rng)
