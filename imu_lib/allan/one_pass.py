"""Allan variance in one pass over a record of any length, merged from parts.

Clusters of up to 127 samples are laid over every start. A longer cluster is 64 to 127 blocks of 2^k
samples, the block means made from each other in a cascade, and is laid over every start of a block:
a stride of a 64th of its length or less, whose estimate scatters like the fully overlapped one to
0.1 per cent. Every averaging time is exact, a whole number of samples.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.allan.clusters import _full
from imu_lib.allan.deviation import AllanCurve, cluster_lengths, of_means
from imu_lib.arrays import Array
from imu_lib.stream import Windowed

#: Blocks of the shortest cluster of a level but the first, and one past the longest.
SHORT, LONG = 64, 128


def lengths(n: int, depth: int) -> Array:
    """Cluster lengths of a record of `n` samples whose cascade has `depth` levels, samples."""
    wanted = cluster_lengths(n)
    level = np.clip(np.floor(np.log2(np.maximum(wanted / SHORT, 1))), 0, depth).astype(np.int64)
    step = 1 << level
    return np.unique(np.maximum(np.rint(wanted / step).astype(np.int64), 1) * step)


def level_of(m: Array, depth: int) -> Array:
    """Level of the cascade at which clusters of these lengths are laid, (j,) of int."""
    level = np.clip(np.floor(np.log2(np.maximum(m / SHORT, 1))), 0, depth).astype(np.int64)
    whole = (m % (1 << level)) == 0
    return np.where(whole, level, level - 1)


class Clusters(Windowed):
    """Squared differences of neighbouring clusters of some numbers of blocks, over every start.

    Parameters
    ----------
    blocks : ndarray of int, shape (j,)
        Cluster lengths in blocks.
    begin : int
    """

    def __init__(self, blocks: Array, begin: int = 0) -> None:
        super().__init__(2 * int(blocks.max(initial=1)), begin=begin)
        self.blocks = blocks
        self.sums, self.counts = np.zeros(blocks.size), np.zeros(blocks.size, np.int64)

    def use(self, values: Array, count: int) -> None:
        _laid(values, self.blocks, count, self.sums)
        self.counts += count

    def absorb(self, other: Any) -> None:
        self.sums += other.sums
        self.counts += other.counts

    def means(self) -> tuple[Array, Array]:
        """Mean squared difference of cluster means, (j,), and windows laid, (j,)."""
        sums, counts = self.sums.copy(), self.counts.copy()
        for j, m in enumerate(self.blocks):  # the last windows, in which the longest has no room
            more = self.tail.size - 2 * int(m) + 1
            if more > 0:
                one = np.zeros(1)
                _laid(self.tail, self.blocks[j : j + 1], more, one)
                sums[j] += one[0]
                counts[j] += more
        with np.errstate(invalid="ignore", divide="ignore"):
            return sums / counts, counts


def _laid(values: Array, blocks: Array, count: int, sums: Array) -> None:
    piece = 4096
    theta = np.concatenate([[0.0], np.cumsum(values)])
    for low in range(0, count, piece):
        high = min(low + piece, count)
        for j, m in enumerate(blocks):
            sums[j] += _full(theta, int(m), low, high) / float(m) ** 2


def curve(levels: list[Clusters], m: Array, depth: int, samples: int, fs: float) -> AllanCurve:
    """The Allan deviation from the clusters of all levels.

    Parameters
    ----------
    levels : list of Clusters
        Of the cascade's levels 0 ... depth.
    m : ndarray of int, shape (j,)
        Cluster lengths as `lengths` gives them.
    depth, samples : int
    fs : float, Hz
    """
    means, counts = np.empty(m.size), np.empty(m.size, np.int64)
    at = level_of(m, depth)
    for k, level in enumerate(levels):
        here = at == k
        means[here], found = level.means()
        counts[here] = found << k  # windows that a full overlap would lay
    whole = samples - 2 * m + 1
    return of_means(m, means, np.minimum(counts, whole), samples, fs)
