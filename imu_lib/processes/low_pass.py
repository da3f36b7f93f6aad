"""The low-pass filter of a sensor: a moving average, a Butterworth filter or exponential
smoothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq
from scipy.signal import butter, lfilter, sosfilt, sosfreqz

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import InputError

from .base import FREE, Parameter
from .stage import Stage


@lru_cache(maxsize=256)
def _half_power(taps: int, times: int) -> float:
    """Frequency, as a share of the rate, at which the power gain of a moving average that is taken
    so many times is one half.
    """
    if taps < 2:
        return 0.5
    return float(
        brentq(
            lambda x: np.sin(taps * x) / (taps * np.sin(x)) - 0.5 ** (0.5 / times),
            1e-9,
            np.pi / taps - 1e-9,
            xtol=1e-15,
        )
        / np.pi
    )


@dataclass(frozen=True)
class LowPass(Stage):
    """Low-pass filter of the sensor, run at `rate` and read out at the sampling rate.

    Give `taps` (a moving average; with an `order` so many of them one behind the other, as in a
    decimator of cascaded integrators and combs, Hogenauer 1981), `order` alone (a Butterworth
    filter with -3 dB at `cutoff`) or `smoothing` = 1 (exponential smoothing
    y_k = y_{k-1} + a (x_k - y_{k-1}), its weight a such that -3 dB lies at `cutoff`). A `rate` that
    is a multiple of the sampling rate is a filter inside the sensor, decimated.

    Parameters
    ----------
    cutoff : float, Hz (-3 dB); with `taps` it follows from them and may be left out
    taps, order, smoothing : int
    rate : float, Hz, optional
        Where it is not given, the sampling rate.
    """

    cutoff: float = FREE
    taps: int = FREE
    order: int = FREE
    rate: float = FREE
    smoothing: int = FREE
    name: ClassVar[str] = "low_pass"
    place: ClassVar[int] = 0
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("cutoff", "frequency", "-3 dB, Hz", optional=True),
        Parameter("taps", "count", "of a moving average", optional=True),
        Parameter("order", "count", "of a Butterworth filter; of moving averages", optional=True),
        Parameter("rate", "frequency", "at which the filter runs, Hz", optional=True),
        Parameter("smoothing", "count", "1: exponential smoothing", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.smoothing is not None and (self.taps is not None or self.order is not None):
            raise InputError("process low_pass: `smoothing` goes with neither `taps` nor `order`")
        if self.taps is not None and self.taps < 1 or self.order is not None and self.order < 1:
            raise InputError("process low_pass: `taps` and `order` must be at least 1")
        if self.smoothing not in (None, 1):
            raise InputError("process low_pass: `smoothing` is 1 or left out")
        if self.taps is not None and self.rate is not None and self.cutoff is None:
            object.__setattr__(self, "cutoff", _half_power(self.taps, self.times) * self.rate)

    @property
    def complete(self) -> bool:
        return self.taps is not None or (self.cutoff is not None and self.tunable)

    @property
    def tunable(self) -> bool:
        """Whether its cutoff may lie anywhere; that of a moving average follows from its taps."""
        return self.taps is None and (self.order is not None or self.smoothing is not None)

    @property
    def times(self) -> int:
        """How often the moving average is taken."""
        return self.order or 1

    def ratio(self, fs: float) -> int:
        """Filter steps per sample at the sampling rate `fs`."""
        ratio = 1.0 if self.rate is None else self.rate / fs
        if abs(ratio - round(ratio)) > 1e-6 or ratio < 0.999:
            raise ValueError(
                f"`rate` of the low-pass filter ({self.rate:g} Hz) must be a multiple "
                f"of the sampling rate ({fs:g} Hz)"
            )
        return round(ratio)

    def gain(self, f: ArrayLike, fs: float) -> Array:
        """Power gain (amplitude gain squared) at frequencies `f` Hz up to half the filter's
        rate, same shape.
        """
        if not self.complete:
            raise ValueError(
                "`low_pass` is a template: give `taps`, or `cutoff` and `order` or `smoothing`, "
                "first"
            )
        f = np.asarray(f, dtype=float)
        rate = fs if self.rate is None else self.rate
        if self.taps is not None:
            x = np.pi * f / rate
            with np.errstate(invalid="ignore", divide="ignore"):
                h = np.where(
                    np.abs(np.sin(x)) < 1e-12, 1.0, np.sin(self.taps * x) / (self.taps * np.sin(x))
                )
            return (h * h) ** self.times
        self._check(rate)
        if self.smoothing:
            b = self._memory(rate)
            return (1 - b) ** 2 / (1 - 2 * b * np.cos(2 * np.pi * f / rate) + b * b)
        # a Butterworth filter through the bilinear transform, its cutoff kept
        with np.errstate(over="ignore"):
            return 1.0 / (
                1.0
                + (np.tan(np.pi * f / rate) / np.tan(np.pi * self.cutoff / rate))
                ** (2 * self.order)
            )

    def phase(self, f: ArrayLike, fs: float) -> Array:
        """Phase of the response, rad, at frequencies `f` Hz up to half the filter's rate, same
        shape; negative where it lags.
        """
        rate = fs if self.rate is None else self.rate
        turn = 2 * np.pi * np.asarray(f, dtype=float) / rate
        if self.taps is not None:
            side_lobe = np.sin(0.5 * self.taps * turn) * np.sin(0.5 * turn) < 0
            return self.times * (-0.5 * (self.taps - 1) * turn + np.pi * side_lobe)
        if self.smoothing:
            return -np.angle(1.0 - self._memory(rate) * np.exp(-1j * turn))
        return np.angle(sosfreqz(self._sos(rate), worN=turn)[1])

    def _check(self, rate: float) -> None:
        if not 0.0 < self.cutoff < rate / 2.0:
            raise ValueError(
                f"`cutoff` of the low-pass filter must lie below {rate / 2:g} Hz, not at "
                f"{self.cutoff:g}"
            )

    def _memory(self, rate: float) -> float:
        """1 - a of exponential smoothing: the root of 2 (1 - b)^2 = 1 - 2 b cos w + b^2, half the
        power at the cutoff.
        """
        half = 2.0 - np.cos(2 * np.pi * self.cutoff / rate)
        return float(half - np.sqrt(half * half - 1.0))

    def _sos(self, rate: float) -> Array:
        self._check(rate)
        return butter(self.order, self.cutoff, fs=rate, output="sos")

    def grid(self, fs: float, fine: bool = False) -> tuple[int, int]:
        """(steps per sample, steps before the first sample) of the grid a simulation runs on.

        The moving average of white noise, and of what hardly moves in a step, is exact on the
        coarsest grid that holds both the sampling and the window (15 taps at 1 kHz, read at 100
        Hz: 2 steps, 3 taps). What moves faster needs the grid of the filter itself: `fine`.
        """
        ratio = self.ratio(fs)
        if self.taps is not None and self.times == 1 and not fine:
            coarse = np.gcd(ratio, self.taps)
            return ratio // coarse, self.taps // coarse - 1
        if self.taps is not None:
            return ratio, self.times * (self.taps - 1)
        rate = ratio * fs
        return ratio, int(np.ceil(3.0 * (self.order or 1) * rate / self.cutoff))

    def window(self, before: int) -> np.ndarray:
        """Weights of the last samples in the moving averages, shape (before + 1,)."""
        one = np.full(before // self.times + 1, 1.0 / (before // self.times + 1))
        out = one
        for _ in range(self.times - 1):
            out = np.convolve(out, one)
        return out

    def run(self, x: Array, fs: float, n: int, fine: bool = False) -> Array:
        """Filter `x` on the grid of `grid(fs, fine)` and read out n samples."""
        steps, before = self.grid(fs, fine)
        if self.taps is not None:
            y = lfilter(self.window(before), [1.0], x)
        elif self.smoothing:
            b = self._memory(steps * fs)
            y = lfilter([1.0 - b], [1.0, -b], x - x[0]) + x[0]
        else:
            y = sosfilt(self._sos(steps * fs), x - x[0]) + x[0]
        return y[before::steps][:n]

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        if self.ratio(fs) != 1:
            raise ValueError(
                "`rate` of the low-pass filter is above the sampling rate: simulate the sum, "
                "a sampled signal can't be filtered before its sampling"
            )
        _, before = self.grid(fs)
        padded = np.concatenate([np.full(before, x[0]), x])
        return self.run(padded, fs, len(x))
