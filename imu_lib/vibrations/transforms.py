"""Transforms of all channels, and narrow bands of them as complex samples at their own width."""

from __future__ import annotations

import numpy as np
from scipy.fft import ifft, next_fast_len, rfft

from imu_lib.arrays import Array


class Transforms:
    """Transforms of all channels (name -> (n,), fast part), made once."""

    def __init__(self, channels: dict[str, Array], fs: float) -> None:
        self.names, self.fs = list(channels), fs
        self.n = len(next(iter(channels.values())))
        self.z = {name: rfft(x) for name, x in channels.items()}

    @property
    def duration(self) -> float:
        return self.n / self.fs

    def ordinates(self, low: float, high: float) -> tuple[int, int]:
        """First ordinate of a band and the one behind its last."""
        top = self.n // 2
        a = int(np.clip(np.floor(low * self.duration), 1, top - 2))
        b = int(np.clip(np.ceil(high * self.duration) + 1, a + 2, top))
        return a, b

    def density(self, name: str, a: int, b: int) -> float:
        """Level beside the ordinates a to b, one-sided, unit^2/Hz, lines beside it left out."""
        z, reach = self.z[name], int(np.clip(b - a, 60, 20_000))
        sides = []
        for lo, hi in ((max(1, a - reach), a), (b, min(len(z) - 1, b + reach))):
            if hi - lo >= 20:
                sides.append(np.log(np.median(np.abs(z[lo:hi]) ** 2) / np.log(2) + 1e-300))
        if not sides:
            return float(np.mean(np.abs(z[1:-1]) ** 2)) * 2 / (self.n * self.fs)
        return float(np.exp(np.mean(sides))) * 2 / (self.n * self.fs)

    def zoom(self, name: str, a: int, b: int) -> np.ndarray:
        """The band of ordinates a to b as complex samples at its own width, of mean square 1 where
        it is as loud as what is beside it.
        """
        size = next_fast_len(b - a)
        part = np.zeros(size, complex)
        part[: b - a] = self.z[name][a:b]
        signal = ifft(part) * size * (2.0 / self.n)
        return signal / np.sqrt(2 * self.density(name, a, b) * (b - a) * self.fs / self.n)
