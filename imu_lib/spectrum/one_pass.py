"""The averaged spectrum of a long record from two scales: segments at the full rate for the fast
end, the whole record at a low rate for the slow one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import fft, signal

from imu_lib.spectrum.density import Spectrum, average, from_power, welch
from imu_lib.spectrum.read_off import read_off
from imu_lib.stream import Segments


class Tapered:
    """The one-sided density of a segment, its mean removed, Hann's window; picklable."""

    def __init__(self, size, fs):
        self.window = signal.get_window("hann", size)
        self.scale = np.sqrt(2.0 / (fs * np.sum(self.window**2)))

    def __call__(self, x):
        return fft.rfft((x - x.mean()) * self.window) * self.scale


def segments(size, fs, begin=0) -> Segments:
    """What a pass sums up for the fast end: half-overlapping segments of `size` samples (even)."""
    return Segments(size, size // 2, Tapered(size, fs), begin)


def averaged(made: Segments, slow, fs, seam) -> Spectrum:
    """The averaged spectrum.

    Parameters
    ----------
    made : Segments
        Of the whole record.
    slow : ndarray
        The record behind its low-pass filter.
    fs : (float, float)
        Rates of the record and of `slow`, Hz.
    seam : float, Hz
        Below it the values are of `slow`.
    """
    power = made.power / made.count
    power[-1] /= 2  # the highest frequency has no twin
    fast = average(from_power(power, fs[0], made.span, made.count))
    slow = average(welch(slow, fs[1]))
    parts = [_cut(slow, slow.f < seam), _cut(fast, fast.f >= seam)]
    joined = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("f", "psd", "low", "high", "dof", "start", "stop")
    }
    return replace(fast, **joined)


def _cut(spectrum, keep):
    names = ("f", "psd", "low", "high", "dof", "start", "stop")
    return replace(spectrum, **{name: getattr(spectrum, name)[keep] for name in names})


def characterise(spectrum: Spectrum) -> dict:
    """N, B, K, Q read off an averaged spectrum, dict of str to Estimate."""
    reading = read_off(spectrum)
    return {symbol: reading[symbol] for symbol in ("N", "B", "K", "Q")}
