"""What block means show of a sensor: its filter, then a moving average that is read once a
block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.arrays import Array, ArrayLike
from imu_lib.processes import LowPass
from imu_lib.processes.low_pass import _half_power


@dataclass(frozen=True)
class Averaged(LowPass):
    """The mean of `size` samples at `sampled` Hz, behind the sensor's own filter `inner`.

    A low-pass filter of the record of block means, which the workflow takes as any other; its
    `rate` is the one at which the inner filter runs.
    """

    size: int = 1
    sampled: float = 1.0
    inner: LowPass | None = None

    @classmethod
    def of(cls, size: int, fs: float, inner: LowPass | None) -> Averaged:
        """The filter of means of `size` samples at `fs` Hz."""
        rate = fs if inner is None or inner.rate is None else inner.rate
        return cls(
            cutoff=_half_power(size, 1) * fs,
            taps=size,
            rate=float(rate),
            size=size,
            sampled=float(fs),
            inner=inner,
        )

    def gain(self, f: ArrayLike, fs: float) -> Array:
        """Power gain at frequencies `f` Hz up to half the rate of the inner filter, same shape."""
        x = np.pi * np.asarray(f, dtype=float) / self.sampled
        with np.errstate(invalid="ignore", divide="ignore"):
            h = np.where(
                np.abs(np.sin(x)) < 1e-12, 1.0, np.sin(self.size * x) / (self.size * np.sin(x))
            )
        return h * h if self.inner is None else h * h * self.inner.gain(f, self.sampled)
