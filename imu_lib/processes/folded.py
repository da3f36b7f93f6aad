"""White noise behind a filter, as the record's own samples show it: the spectrum that
is left of it with what the sampling folds in, without the filter's phase.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.fft import irfft, next_fast_len
from scipy.signal import oaconvolve

from imu_lib.arrays import Array

if TYPE_CHECKING:
    from .low_pass import LowPass

#: Share of its energy up to which a response is followed, and samples at the least and at the most
#: on which it is computed.
LEFT_OUT, SHORTEST, LONGEST = 1e-10, 1 << 12, 1 << 18
#: Periods of the cutoff in these samples.
PERIODS = 64


@lru_cache(maxsize=32)
def response(low_pass: LowPass, fs: float) -> Array:
    """Symmetric response, shape (2 m + 1,), at the sampling rate `fs` Hz."""
    ratio = low_pass.ratio(fs)
    cutoff = low_pass.cutoff or 0.443 * ratio * fs / (low_pass.taps or 1)
    size = next_fast_len(int(np.clip(PERIODS * fs / cutoff, SHORTEST, LONGEST)), real=True)
    size += size % 2
    f = np.arange(size // 2 + 1) * fs / size
    power = np.zeros(len(f))
    for k in range(ratio):  # the images that the sampling folds onto f
        image = np.mod(f + k * fs, ratio * fs)
        power += low_pass.gain(np.minimum(image, ratio * fs - image), fs)
    half = irfft(np.sqrt(power), size)[: size // 2]
    left = np.cumsum(half[::-1] ** 2)[::-1]
    half = half[: max(1, np.count_nonzero(left > LEFT_OUT * left[0]))]
    out = np.concatenate([half[:0:-1], half])
    out.setflags(write=False)
    return out


def behind(x: Array, low_pass: LowPass, fs: float) -> Array:
    """White samples `x`, shape (n + 2 m,), behind the filter, shape (n,)."""
    return np.asarray(oaconvolve(x, response(low_pass, fs), mode="valid"))
