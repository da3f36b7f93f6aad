"""What a low-pass filter adds to the autocovariance of noises."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.fft import irfft

from imu_lib.arrays import Array

#: Share of its largest value to which the autocovariance that a filter adds has to have fallen
#: where it is cut off, and the time constants of the filter, and samples, to which it is followed
#: at the most (flicker never falls so far).
FORGOTTEN, MAX_TIME_CONSTANTS, MAX_MEMORY_SAMPLES = 1e-12, 256, 2**20


@lru_cache(maxsize=32)
def added(filtered: Any, bare: Any, fs: float) -> Array:
    """Autocovariance of a filtered sum of noises less that of the bare one, shape (k,), zero
    beyond.

    It is the transform of a spectrum that vanishes at zero frequency but for what the sampling
    folds there, since gain(0) = 1; the grid of frequencies is made finer until the memory of
    filter and noises ends within it.

    Parameters
    ----------
    filtered, bare : Sum
        With the low-pass filter and without.
    fs : float, Hz
    """
    size, low_pass = 2048, filtered.low_pass
    cutoff = low_pass.cutoff or 0.443 * fs / low_pass.taps
    longest = np.clip(MAX_TIME_CONSTANTS * fs / (2 * np.pi * cutoff), 8192, 2 * MAX_MEMORY_SAMPLES)
    while True:
        size *= 2
        f = np.arange(1, size // 2 + 1) * fs / size
        difference = filtered.psd(f, fs) - bare.psd(f, fs)
        at_zero = difference[0] - (difference[1] - difference[0]) / 3.0  # even in f, so parabolic
        r = irfft(np.concatenate([[at_zero], difference]) * (fs / 2.0), size)[: size // 2]
        end = np.max(np.abs(r[size // 4 :]))
        if end <= FORGOTTEN * np.max(np.abs(r)) or size >= longest:
            r.setflags(write=False)
            return r
