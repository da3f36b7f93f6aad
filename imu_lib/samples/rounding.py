"""What lies behind samples that are rounded to a step as wide as their noise, and what the
rounding does to their spectrum.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from imu_lib.arrays import Array
from imu_lib.processes import Quantization
from imu_lib.samples.blocks import statistics
from imu_lib.samples.innovations import Smooth, trend
from imu_lib.samples.uneven import Uneven

#: Steps in standard deviations of the rounded noise from which on rounding is more than white
#: noise of step^2 / 12.
COARSE = 0.9


def moments(sd: float, points: int = 129) -> tuple[Array, Array, Array]:
    """Mean and variance of round(mu + sd z), z standard normal, for mu over half a step either
    side of a level: (mu, mean, variance).
    """
    mu = np.linspace(-0.5, 0.5, points)
    top = int(np.ceil(6 * sd)) + 1
    edge = np.arange(-top, top) + 0.5
    beyond = ndtr((mu[:, None] - edge) / sd)  # share above each edge between two levels
    mean = -top + beyond.sum(axis=1)
    square = top**2 + beyond @ (2 * edge)
    return mu, mean, square - mean**2


#: Share of the variance after the rounding that was there before, at the least.
LEAST = 0.02
#: Parts of the record whose loudness is measured, and samples of one at the least.
PARTS, SHORTEST = 16, 500


class Rounding:
    """Rounded samples `x`, shape (n,), of fast noise `smooth` on a `grid` (step, offset).

    `base` (n,) is the slow part before the rounding and `variance` that of the fast noise before
    it, both in steps; `slope` is how much faster the variance after it grows, `swing` (n,) how the
    noise after it rises and falls as the slow part moves between two levels (1 where that is less
    than a per cent). `steps` are those of a converter where they are not equally wide.
    """

    def __init__(
        self, x: Array, smooth: Smooth, grid: tuple[float, float], steps: Uneven | None = None
    ) -> None:
        self.smooth, (self.step, offset), self.n = smooth, grid, len(x)
        self.steps = steps
        slow = trend(x, smooth.m)
        level, self._noise = (slow - offset) / self.step, (x - slow) / self.step
        after = smooth.sample_variance / self.step**2
        self.coarse = after < 1 / COARSE**2
        added = 1 / 12 if steps is None else steps.variance
        self.base, self.variance, self.slope = level, max(after - added, LEAST * after), 1.0
        self.swing: Array | float = 1.0
        if self.coarse and steps is None:
            self._before(level, after)

    def _before(self, level: Array, variance: float) -> None:
        whole = np.rint(level)
        few = (level - whole)[:: max(1, len(level) // 4000)]

        def after(sd: float, part: Array = few) -> tuple[Array, Array]:
            mu, mean, spread = moments(sd)
            before = np.interp(part, mean, mu)
            return before, np.interp(before, mu, spread)

        low, high = 0.05, max(2.0, 2 * np.sqrt(variance))

        def excess(sd: float) -> float:
            return float(np.mean(after(sd)[1])) - variance

        sd = low if excess(low) >= 0 else brentq(excess, low, high, xtol=1e-5)
        part, spread = after(sd, level - whole)
        self.base, self.variance = whole + part, sd**2
        self.slope = max(
            (excess(1.02 * sd) - excess(0.98 * sd)) / (sd**2 * (1.02**2 - 0.98**2)), 1.0
        )
        swing = np.sqrt(spread / np.mean(spread))
        self.swing = swing if np.std(swing) > 0.01 else 1.0

    @cached_property
    def _before_level(self) -> Array:
        smooth = self.smooth
        return smooth.level * self.variance * self.step**2 / smooth.sample_variance

    @cached_property
    def loudness(self) -> Array:
        """How loud the noise is through the record before the rounding, shape (n,), of mean square
        1, in `PARTS`.
        """
        x, m = self._noise, max(self.n // PARTS, SHORTEST)
        k = max(self.n // m, 1)
        square = np.array([np.mean(part**2) for part in np.array_split(x, k)])
        added = 1 / 12 if self.steps is None else self.steps.variance
        sd = np.sqrt(np.maximum(square - added, LEAST * square))
        centre = (np.arange(k) + 0.5) * self.n / k
        return np.interp(np.arange(self.n), centre, sd / np.sqrt(np.mean(sd**2)))

    def _drawn(
        self, level: Array, rng: np.random.Generator, loud: Array | float = 1.0
    ) -> tuple[Array, Array]:
        """The signal before the rounding with noise of the spectrum `level` in the bins, and after
        it; `loud` (n,) is how loud that is through the record.
        """
        size = self.n + self.n % 2
        noise = np.fft.irfft(
            np.fft.rfft(rng.standard_normal(size))
            * np.sqrt(self.smooth.between(level, size) * self.smooth.fs / 2),
            size,
        )[: self.n]
        before = self.base * self.step + loud * noise
        if self.steps is not None:
            return before, self.steps.rounded(before / self.step)
        return before, np.rint(before / self.step)

    def twin(self, rng: np.random.Generator, of_integral: Quantization | None = None) -> np.ndarray:
        """A simulation of the rounded samples, in steps, shape (n,); increments of a rounded
        integral where its quantization is given.
        """
        level, fs = self.smooth.level, self.smooth.fs
        if of_integral is None:
            before = (
                self._unrounded(rng)[0]
                if self.coarse or self.steps is not None
                else np.maximum(level - self.step**2 / (6 * fs), 0.02 * level)
            )
            return self._drawn(before, rng, self.loudness)[1]
        noise = of_integral.psd(self.smooth.layout.frequency, fs)
        before, _ = self._drawn(np.maximum(level - noise, 0.02 * level), rng, self.loudness)
        return np.rint(of_integral.round(before, fs, rng) / self.step)

    def extra(self, rng: np.random.Generator) -> np.ndarray:
        """Density that the rounding adds in the bins, by simulation: it is neither white nor
        independent of the signal.
        """
        return self._unrounded(rng)[1]

    def _unrounded(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """Spectrum before the rounding and what the rounding adds to it, in the bins."""
        smooth, k = self.smooth, self.smooth.layout.slow
        level, kernel = self._before_level, np.ones(15) / 15
        for draws in (2, 3, 8):  # the last is kept
            extra = np.zeros_like(level)
            for _ in range(draws):
                before, after = self._drawn(level, rng)
                rounded = statistics(after * self.step, smooth.fs)
                extra += (rounded.mean_power - statistics(before, smooth.fs).mean_power) / draws
            # rounding changes a spectrum smoothly: average over neighbours, leave the slow end to
            # its own level
            extra = np.convolve(np.pad(extra, 7, mode="edge"), kernel, "valid")
            extra[:k] = np.mean(extra[k : k + 12])
            level = np.maximum(
                level + (smooth.level - level - extra) / self.slope, 0.02 * smooth.level
            )
        return level, extra
