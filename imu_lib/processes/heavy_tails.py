"""White noise whose samples are Student's instead of normal, perhaps longer to one side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import gammaln, log_ndtr, logsumexp, ndtr

from imu_lib.arrays import Array
from imu_lib.errors import InputError

from .base import FREE, Parameter
from .stage import Stage

#: Freedom above which alone the scatter of the scales is finite, which tails that lean need.
LEANS_ABOVE = 4.0
#: Scales that stand for their distribution, and how far out they go, in logarithms.
SCALES, LOWEST, HIGHEST = 90, -2.5, 4.0


@dataclass(frozen=True)
class HeavyTails(Stage):
    """The white noise has Student's distribution of `freedom` degrees, its variance unchanged.

    A Student's variate is a normal one over a root of chi-square of its own (Student 1908): every
    white sample is given a scale of its own whose mean square is 1, so that spectrum, Allan
    variance and autocovariance stay what they are. They are the tails of a record as they are
    measured, whitened without phase: behind a filter they are given to white noise at the record's
    rate, and the filter's folded spectrum to that (of an oversampled filter each sample would be a
    mean of many steps, and normal again).

    With a `lean` b, x = (sqrt(w) z + b (w - 1)) / sqrt(1 + b^2 var w), w the square of the scale:
    where that is large the sample is large to one side (the skew Student's distribution of Aas and
    Haff 2006, Eq. 1, with mean 0 and variance 1).

    Parameters
    ----------
    freedom : float, above 2 (at or below 2 the variance is infinite), with a lean above 4
    lean : float, optional
        Above zero where the long tail is that of large values.
    """

    freedom: float = FREE
    lean: float | None = None
    name: ClassVar[str] = "heavy_tails"
    place: ClassVar[float] = -1
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("freedom", "ratio", "degrees of freedom, above 2"),
        Parameter("lean", "other", "to which side the tail is long", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.freedom is None:
            return
        if self.freedom <= 2:
            raise InputError(
                f"process heavy_tails: `freedom` must be above 2, not {self.freedom:g}"
            )
        if self.lean and self.freedom <= LEANS_ABOVE:
            raise InputError(
                f"process heavy_tails: with a `lean` the `freedom` must be above "
                f"{LEANS_ABOVE:g}, not {self.freedom:g}"
            )

    def scales(self, n: int, rng: np.random.Generator) -> Array:
        """Factors on the samples of a normal white noise, mean square 1, shape (n,)."""
        self._require()
        return np.sqrt((self.freedom - 2.0) / rng.chisquare(self.freedom, n))

    def given(self, x: Array, sd: float, rng: np.random.Generator) -> Array:
        """White noise `x` (n,) of standard deviation `sd` with these tails."""
        scale = self.scales(len(x), rng)
        if not self.lean:
            return x * scale
        return (x * scale + self.lean * sd * (scale**2 - 1.0)) / self.widening

    @property
    def widening(self) -> float:
        """Standard deviation that the lean alone would leave, over that of the noise."""
        if not self.lean:
            return 1.0
        return float(np.sqrt(1.0 + self.lean**2 * 2.0 / (self.freedom - LEANS_ABOVE)))

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """On a bare signal: what deviates from its mean counts as white noise."""
        middle = np.mean(x)
        return middle + self.given(x - middle, float(np.std(x)), rng)

    def log_density(self, u: Array) -> Array:
        """Logarithm of the density of values `u` (n,) of noise with mean 0 and variance 1."""
        log_share, variance, z = self._mixed(u, 1.0)
        return logsumexp(log_share - 0.5 * z**2 - 0.5 * np.log(2 * np.pi * variance), axis=1)

    def below(self, u: Array, part: float = 1.0) -> Array:
        """Probabilities below values `u` (n,) of noise with mean 0 and variance 1, a `part` of
        which has these tails and the rest is normal.
        """
        log_share, _, z = self._mixed(u, part)
        return ndtr(z) @ np.exp(log_share)

    def log_tails(self, u: Array) -> tuple[Array, Array]:
        """Logarithms of the probabilities below and above values `u` (n,) of such noise."""
        log_share, _, z = self._mixed(u, 1.0)
        below, above = log_share + log_ndtr(z), log_share + log_ndtr(-z)
        return logsumexp(below, axis=1), logsumexp(above, axis=1)

    def _mixed(self, u: Array, part: float) -> tuple[Array, Array, Array]:
        """Of the normal distributions that it is a mixture of: logarithm of their shares and their
        variances, shapes (scales,), and `u` in each, shape (n, scales).
        """
        log_w = np.linspace(LOWEST, HIGHEST, SCALES)
        w, half = np.exp(log_w), 0.5 * self.freedom
        # of an inverse gamma variable of mean 1, over its logarithm
        rate = half - 1.0
        log_share = half * np.log(rate) - gammaln(half) - half * log_w - rate / w
        log_share = log_share - logsumexp(log_share)
        mean = np.sqrt(part) * (self.lean or 0.0) * (w - 1.0) / self.widening
        variance = part * w / self.widening**2 + 1.0 - part
        return log_share, variance, (u[:, None] - mean) / np.sqrt(variance)
