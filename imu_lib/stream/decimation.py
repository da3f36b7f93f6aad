"""Every second value behind a low-pass filter, and what that does to a cosine transform.

The filter is symmetric with an even number of taps, the series continued at both ends as in a
mirror: the cosine transform (DCT-II) of what comes out is that of the series times the filter's
gain, exactly but for what the stop band lets through (1e-6 of the amplitude).
"""

from __future__ import annotations

import numpy as np
from scipy import signal

from imu_lib.stream.scratch import bounds
from imu_lib.stream.windowed import Windowed

#: Share of the rate after halving up to which the gain is 1 to 1e-6 and nothing is folded.
PASSED = 0.4
_TAPS = signal.firwin(84, 0.25, window=("kaiser", 12.3), fs=1.0)
_HALF = _TAPS.size // 2
_PADDED = np.concatenate([[0.0], _TAPS])


class Halved(Windowed):
    """The filtered series at half its rate, handed on to `children`.

    Parameters
    ----------
    children : list of Windowed
        Begin at `first(begin)`.
    begin : int
    """

    def __init__(self, children, begin=0):
        start = begin if begin else 1 - _HALF
        super().__init__(_TAPS.size, 2, start, phase=(1 - _HALF) % 2)
        self.children = children
        self.waiting = None if begin else np.empty(0)

    @staticmethod
    def first(begin):
        """Index of the first output of a pass that begins at `begin`."""
        return -(-(begin + _HALF - 1) // 2) if begin else 0

    def feed(self, x):
        if self.waiting is not None:  # the mirror at the start
            self.waiting = np.concatenate([self.waiting, x])
            if self.waiting.size < _HALF:
                return
            x, self.waiting = self.waiting, None
            x = np.concatenate([x[: _HALF - 1][::-1], x])
        super().feed(x)

    def merge(self, other):
        if self.waiting is not None:
            raise ValueError(f"a first pass needs {_HALF} values or more")
        super().merge(other)

    def use(self, values, count):
        last = (count - 1) * 2 + _TAPS.size
        # output m of `upfirdn` ends at value 2 m, windows at odd ones: a tap of zero goes before
        out = signal.upfirdn(_PADDED, values[:last], 1, 2)[_HALF:][:count]
        for child in self.children:
            child.feed(out)

    def absorb(self, other):
        for child, after in zip(self.children, other.children, strict=True):
            child.merge(after)

    def finish(self):
        """The mirror at the end; call once, when all is merged."""
        super().feed(self.tail[-(_HALF - 1) :][::-1].copy())
        for child in self.children:
            if isinstance(child, Halved):
                child.finish()


def gain(share):
    """Gain of one halving at frequencies as a share of the rate before it, same shape: a sum of
    cosines of odd multiples by Clenshaw's recurrence (1955).
    """
    twice, this, last = 2.0 * np.cos(2.0 * np.pi * share), 0.0, 0.0
    for tap in _TAPS[:_HALF]:  # the outermost first
        this, last = tap + twice * this - last, this
    return 2.0 * np.cos(np.pi * share) * (this - last)


def original(coefficients, n, halvings):
    """Coefficients p = 1, 2, ... of the orthonormal cosine transform of a series of `n` values from
    those of the series halved `halvings` times.
    """
    out = np.array(coefficients)
    for low, high in bounds(out.size, 1 << 13):
        share = np.arange(low + 1, high + 1) / (2.0 * n)
        for k in range(halvings):
            out[low:high] *= np.sqrt(2.0) / gain(share * 2**k)
    return out
