"""How long a jump takes: a straight change between two levels about it, fitted to the samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.arrays import Array

#: Seconds of the means that are fitted, and on each side of a jump; lengths that are tried.
BLOCK, REACH = 0.25, 45.0
LENGTHS = (0.0, 1.0, 2.0, 3.0, 4.5, 6.5, 9.0, 12.0, 16.0, 22.0, 30.0)
#: Log-likelihood by which a length has to be better than none.
CLEAR = 12.0


@dataclass(frozen=True)
class Ramp:
    """A change from a level to another between `start` and `stop`, s."""

    start: float
    stop: float

    @property
    def slow(self) -> bool:
        """Whether it takes longer than a jump."""
        return self.stop > self.start

    def meets(self, other: Ramp, apart: float) -> bool:
        """Whether two changes are no more than `apart` s apart."""
        return self.start < other.stop + apart and other.start < self.stop + apart


def ramp_of(x: Array, fs: float, time: float) -> Ramp:
    """The change of `x`, shape (n,), NaN where a sample is missing, about a jump at `time` s."""
    size = max(1, int(BLOCK * fs))
    first = max(0, int((time - REACH) * fs))
    part = x[first : int((time + REACH) * fs) + 1]
    k = len(part) // size
    sudden = Ramp(time, time)
    if k < 40:
        return sudden
    blocks = part[: k * size].reshape(k, size)
    seen = np.isfinite(blocks).sum(axis=1)
    y = np.where(seen, np.nansum(blocks, axis=1) / np.maximum(seen, 1), np.nan)
    at = (first + (np.arange(k) + 0.5) * size) / fs
    at, y = at[seen > 0], y[seen > 0]
    left: dict[float, tuple[float, float]] = {}
    for length in LENGTHS:
        starts = np.arange(time - length - 3.0, time + 3.0, BLOCK)
        left[length] = min((_rest(at, y, s, length), s) for s in starts)
    best = min(left, key=lambda length: left[length][0])
    none, rest = left[0.0][0], left[best][0]
    if 0.5 * len(y) * np.log(none / max(rest, 1e-300)) < CLEAR:
        return sudden
    start = left[best][1]
    return Ramp(float(start), float(start + best))


def _rest(at: Array, y: Array, start: float, length: float) -> float:
    """Sum of squares that a level and a change leave."""
    shape = np.clip((at - start) / max(length, 1e-9), 0.0, 1.0)
    shape, y = shape - shape.mean(), y - y.mean()
    return float(y @ y - (shape @ y) ** 2 / max(shape @ shape, 1e-300))
