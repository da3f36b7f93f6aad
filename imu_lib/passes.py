"""One pass over a stretch of a channel: all that the estimators need of it, in bounded memory.

The samples go through two cascades, block means (each level the means of pairs of the one before)
and a halving filter, and into segments at the full rate. What is left at the end of a pass is some
megabytes, whatever the length, and passes over neighbouring parts of a stretch merge: a pass over
two halves equals a pass over the whole.
"""

from __future__ import annotations

import numpy as np
from scipy import fft

from imu_lib.allan import one_pass as clusters
from imu_lib.autocorrelation import one_pass as blocks
from imu_lib.autoregressive import one_pass as lags
from imu_lib.spectrum import one_pass as tapered
from imu_lib.stream import (
    CHUNK,
    PASSED,
    Halved,
    Keep,
    LagSums,
    Means,
    bounds,
    original,
)

#: Values that are kept of the slowest level of block means, and of the halving filter.
MEANS, SLOW = 1 << 18, 1 << 20
#: Samples of a segment at the full rate per sample at the low one.
SEGMENT = 1 << 11
#: Where the two scales meet, as a share of the low rate.
SEAM = 0.3
assert SEAM < PASSED


class Pass:
    """A pass over the samples `begin` ... of a stretch of `n` samples.

    Parameters
    ----------
    n : int
        Samples of the whole stretch, 2^16 or more.
    fs : float, Hz
    centre : float
        Taken off every sample; any value near the mean, the same in passes to be merged.
    begin : int
    curves : bool
        Whether the curves are wanted (Allan, autocorrelation, autoregressive, averaged spectrum),
        or what the likelihood needs alone.
    """

    def __init__(self, n, fs, *, centre=0.0, begin=0, curves=True):
        self.n, self.fs, self.centre = int(n), float(fs), float(centre)
        self.begin = self.end = begin
        self.curves = curves
        self.depth = max(int(np.ceil(np.log2(n / MEANS))), 1)
        self.halvings = max(int(np.ceil(np.log2(n / SLOW))), 1)
        self.segment = SEGMENT << self.halvings
        self.limit = n - n % (1 << self.halvings)
        self.slow = Keep(_level(begin, self.halvings, Halved.first))
        self.halved = [self.slow]
        for k in range(self.halvings - 1, -1, -1):
            self.halved = [Halved(self.halved, _level(begin, k, Halved.first))]
        self.fast = tapered.segments(self.segment, self.fs, begin)
        self.moments = LagSums(lags.LAGS if curves else 0, begin)
        self.all = [self.fast, self.moments]
        if curves:
            self._with_curves(begin)

    def _with_curves(self, begin):
        self.m = clusters.lengths(self.n, self.depth)
        at = clusters.level_of(self.m, self.depth)
        starts = [_level(begin, k, lambda b: -(-b // 2)) for k in range(self.depth + 1)]
        self.clusters = [
            clusters.Clusters(self.m[at == k] >> k, starts[k]) for k in range(self.depth + 1)
        ]
        self.levels = [blocks.sums(starts[k]) for k in range(self.depth)]
        self.means = Keep(starts[-1])
        node = [self.means, self.clusters[-1]]
        for k in range(self.depth - 1, -1, -1):
            node = [*self.levels[k], self.clusters[k], Means(2, node, starts[k])]
        self.all += node

    def feed(self, x):
        """The next samples, ndarray (k,), without NaN."""
        for low, high in bounds(x.size):
            piece = x[low:high] - self.centre
            for taker in self.all:
                taker.feed(piece)
            self.halved[0].feed(piece[: max(self.limit - self.end, 0)])
            self.end += piece.size

    def merge(self, other):
        """Go on with the pass over the samples that follow."""
        if (other.n, other.centre) != (self.n, self.centre):
            raise ValueError("`other` is a pass over another stretch, or has another centre")
        for mine, after in zip([*self.all, *self.halved], [*other.all, *other.halved], strict=True):
            mine.merge(after)
        self.end = other.end

    def finish(self):
        """Close the pass over the whole stretch; returns itself."""
        if (self.begin, self.end) != (0, self.n):
            raise ValueError(f"the pass has seen {self.begin} ... {self.end} of {self.n} samples")
        self.halved[0].finish()
        return self

    # -- what it has found -----------------------------------------------------------------------
    @property
    def mean(self):
        """Of the samples."""
        return self.centre + self.moments.total[1] / self.n

    @property
    def variance(self):
        """Of the samples."""
        products, total, n = self.moments.total
        return products[0] / n - (total / n) ** 2

    @property
    def low_rate(self):
        return self.fs / (1 << self.halvings)

    @property
    def seam(self):
        """Frequency at which the two scales meet, Hz."""
        return SEAM * self.low_rate

    def allan(self):
        """The AllanCurve."""
        return clusters.curve(self.clusters, self.m, self.depth, self.n, self.fs)

    def autocorrelation(self):
        return blocks.characterise(self.levels, self.means.values, 1 << self.depth, self.fs)

    def autoregressive(self):
        return lags.characterise(self.moments)

    def spectrum(self):
        """The averaged Spectrum."""
        rates = self.fs, self.low_rate
        return tapered.averaged(self.fast, self.slow.values, rates, self.seam)

    def scales(self):
        """(slow, fast) as `likelihood.of_scales` takes them."""
        p = int(PASSED * self.low_rate * 2 * self.limit / self.fs)
        slow = fft.dct(self.slow.values, norm="ortho")[1 : p + 1]
        slow = original(slow, self.limit, self.halvings)
        power = self.fast.power / self.fast.count
        return (self.limit, slow), (self.segment, self.fast.count, power)


def over(pieces, n, fs, *, curves=True) -> Pass:
    """The pass over a stretch of `n` samples that comes in pieces."""
    out = None
    for x in pieces:
        if out is None:
            out = Pass(n, fs, centre=float(np.mean(x)), curves=curves)
        out.feed(x)
    return out.finish()


def over_array(x, fs, *, curves=True) -> Pass:
    """The pass over a stretch that is in memory, ndarray (n,)."""
    return over((x[low:high] for low, high in bounds(x.size, CHUNK)), x.size, fs, curves=curves)


def _level(begin, k, first):
    for _ in range(k):
        begin = first(begin) if begin else 0
    return begin
