"""What a process contributes to the likelihood at amplitude 1: its spectrum in the bins and its
covariance of block differences. Both are linear in the square of the amplitude, so that a fit that
moves amplitudes alone evaluates no spectrum at all.
"""

from __future__ import annotations

from copy import copy
from functools import lru_cache

import numpy as np

from imu_lib.gap import fast, slow


@lru_cache
def _amplitude(kind) -> str:
    return next(p.name for p in kind.parameters if p.kind == "amplitude")


def amplitude_of(process) -> str:
    """Name of the parameter that a noise scales with."""
    return _amplitude(type(process))


def split(process):
    """(process of amplitude 1, squared amplitude)."""
    name = amplitude_of(process)
    amplitude = getattr(process, name)
    if amplitude == 1.0:
        return process, 1.0
    unit = copy(process)  # valid as it is: not checked again, a hundred thousand times
    object.__setattr__(unit, name, 1.0)
    return unit, amplitude**2


@lru_cache(maxsize=2048)
def of_unit(process, low_pass, n: int, fs: float):
    """Spectrum in the bins (b,) and covariance of block differences (k,) behind the filter, of `n`
    samples at `fs` Hz.
    """
    m = slow.block_length(n, fs)
    layout = fast.bins(n, fs, m)
    s = fast.spectrum([process], low_pass, layout, fs)
    c = slow.covariance([process], low_pass, layout, n // m - 1, m, fs)
    s.setflags(write=False)
    c.setflags(write=False)
    return s, c


def of_sum(terms, low_pass, n: int, fs: float):
    """As `of_unit`, of a sum of processes with their amplitudes."""
    m = slow.block_length(n, fs)
    s, c = np.zeros(len(fast.bins(n, fs, m).f)), np.zeros(n // m - 1)
    for term in terms:
        unit, square = split(term)
        own = of_unit(unit, low_pass, n, fs)
        s += square * own[0]
        c += square * own[1]
    return s, c
