"""The images of a frequency: what a low-pass filter leaves above half the sampling rate, and the
sampling folds onto it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache

import numpy as np

from imu_lib.arrays import Array

from .low_pass import LowPass

#: Of images that are kept for the next question, which is mostly about the same frequencies.
MOST_KEPT = 200_000


def images(low_pass: LowPass, f: Array, fs: float) -> Iterable[tuple[Array, Array]]:
    """(frequency at the filter's rate, power gain there) of every image of the frequencies `f` Hz
    that the sampling at `fs` Hz folds onto them, the first being `f` itself; one at a time where
    they are many: block means of a long record have as many images as a block has samples.
    """
    if f.ndim == 1 and f.size * low_pass.ratio(fs) <= MOST_KEPT:
        return _kept(low_pass, f.tobytes(), fs)
    return _images(low_pass, f, fs)


@lru_cache(maxsize=16)
def _kept(low_pass: LowPass, f: bytes, fs: float) -> tuple[tuple[Array, Array], ...]:
    found = tuple(_images(low_pass, np.frombuffer(f), fs))
    for pair in found:
        for values in pair:
            values.setflags(write=False)
    return found


def _images(low_pass: LowPass, f: Array, fs: float) -> Iterator[tuple[Array, Array]]:
    ratio = low_pass.ratio(fs)
    rate = ratio * fs
    for k in range(ratio):
        image = np.mod(f + k * fs, rate)
        image = np.minimum(image, rate - image)
        yield image, low_pass.gain(image, fs)
