"""Output stages: what the electronics do to the sum of the processes, always in this order.

low_pass, noise_level_change, spikes, saturation, resolution, stuck. A stage is a frozen dataclass
like a process; `apply` works on the whole signal, constants included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array

from .base import FREE, Parameter
from .stage import Stage


@dataclass(frozen=True)
class NoiseLevelChange(Stage):
    """From `time` on the fast noise (white, quantization, what forgets within a tenth of a second)
    is `ratio` times as strong, or comes to that along a straight line over a `duration`.

    Parameters
    ----------
    ratio : float
    time : float, s from the first sample
    duration : float, optional, s
    """

    ratio: float = FREE
    time: float = FREE
    duration: float | None = None
    name: ClassVar[str] = "noise_level_change"
    place: ClassVar[int] = 1
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "ratio", "of the standard deviations after and before"),
        Parameter("time", "other", "s from the first sample"),
        Parameter("duration", "time", "s of a change that is not sudden", optional=True),
    )

    @property
    def onset(self) -> float:
        return self.time

    def factor(self, n: int, fs: float, first: int = 0) -> Array:
        """The factor on the fast noise from the sample `first` on, shape (n,)."""
        self._require()
        since = np.arange(first, first + n) / fs - self.time
        if self.duration:
            return np.asarray(1.0 + (self.ratio - 1.0) * np.clip(since / self.duration, 0.0, 1.0))
        return np.where(since >= -1e-9, self.ratio, 1.0)

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """On a bare signal: what deviates from its mean counts as noise."""
        middle = np.mean(x)
        return middle + (x - middle) * self.factor(len(x), fs)


@dataclass(frozen=True)
class Spikes(Stage):
    """Single samples thrown off, `rate` per second, by normal heights of standard deviation
    `scale`.

    Parameters
    ----------
    rate : float, 1/s
    scale : float, signal unit
    differenced : int, optional
        1 where the sensor gives increments of what was thrown off: each is followed by its
        opposite.
    """

    rate: float = FREE
    scale: float = FREE
    differenced: int | None = None
    name: ClassVar[str] = "spikes"
    place: ClassVar[int] = 2
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("rate", "rate", "per second"),
        Parameter("scale", "amplitude", "standard deviation of the heights, signal unit"),
        Parameter("differenced", "count", "1: its opposite follows each", optional=True),
    )

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        self._require()
        hit = np.flatnonzero(rng.random(len(x)) < self.rate / fs)
        x = np.array(x, dtype=float)
        height = self.scale * rng.standard_normal(len(hit))
        x[hit] += height
        if self.differenced:
            after = hit[hit + 1 < len(x)] + 1
            x[after] -= height[: len(after)]
        return x

    def added_variance(self, fs: float) -> float:
        self._require()
        return (2 if self.differenced else 1) * self.rate / fs * self.scale**2


@dataclass(frozen=True)
class Saturation(Stage):
    """Clipping at `limit` above and `low` (where not given, -limit) below.

    Parameters
    ----------
    limit : float, signal unit
    low : float, optional, signal unit
    """

    limit: float = FREE
    low: float = FREE
    name: ClassVar[str] = "saturation"
    place: ClassVar[int] = 3
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("limit", "signed", "upper end, signal unit"),
        Parameter("low", "signed", "lower end, signal unit", optional=True),
    )

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        self._require()
        return np.clip(x, -self.limit if self.low is None else self.low, self.limit)


@dataclass(frozen=True)
class Resolution(Stage):
    """The output rounded to multiples of `lsb`. Its error is white on the output: slope -1/2, not
    -1.

    Parameters
    ----------
    lsb : float, signal unit
    """

    lsb: float = FREE
    name: ClassVar[str] = "resolution"
    place: ClassVar[int] = 4
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("lsb", "amplitude", "step of the output, signal unit"),
    )

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        self._require()
        return np.rint(np.asarray(x) / self.lsb) * self.lsb if self.lsb > 0 else np.array(x)

    def added_variance(self, fs: float) -> float:
        """lsb^2 / 12, which holds while the noise spans a step or more (Widrow 1956)."""
        self._require()
        return self.lsb**2 / 12.0


@dataclass(frozen=True)
class Stuck(Stage):
    """Runs of `length` samples that repeat a frozen value; `fraction` of all samples are repeats.

    Parameters
    ----------
    fraction : float, 0 to 1
    length : int, samples
    """

    fraction: float = FREE
    length: int = FREE
    name: ClassVar[str] = "stuck"
    place: ClassVar[int] = 5
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "fraction", "of the samples that repeat"),
        Parameter("length", "count", "of a run, samples"),
    )

    def runs(self, n: int, rng: np.random.Generator) -> Array:
        """One draw of the samples whose values are frozen, in order, of `n` samples."""
        self._require()
        length = max(int(self.length), 1)
        slots = n // (length + 1)
        runs = min(slots, int(round(self.fraction * n / length)))
        if runs == 0:
            return np.zeros(0, dtype=int)
        # runs never overlap: choose slots of the record, then a place inside the slack
        begin = (
            np.sort(rng.choice(n - runs * length - 1, size=runs, replace=False))
            if n > runs * (length + 1)
            else np.arange(runs)
        )
        return np.asarray(begin + np.arange(runs) * length)

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        x = np.array(x, dtype=float)
        length = max(int(self.length or 1), 1)
        for start in self.runs(len(x), rng):
            x[start + 1 : start + 1 + length] = x[start]
        return x
