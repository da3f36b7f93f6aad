"""Blocks of a record: what moves more slowly than two of them is a drift, the rest is noise."""

from __future__ import annotations

from imu_lib.arrays import Array
from imu_lib.likelihood.statistics import Statistics

#: The drifts are heard in periods of two blocks and longer: a block has four seconds at least, a
#: record this many blocks at the most and at the least.
SHORTEST_BLOCK, MOST_BLOCKS, FEWEST_BLOCKS = 4.0, 640, 48


def block_length(n: int, fs: float) -> int:
    """Samples in a block."""
    samples = max(SHORTEST_BLOCK * fs, n / MOST_BLOCKS)
    return int(max(1, min(round(samples), n // FEWEST_BLOCKS)))


def statistics(x: Array, fs: float) -> Statistics:
    """What the likelihood knows of samples: cosine coefficients below one cycle in two blocks, the
    tapered periodogram above.
    """
    return Statistics.split(x, fs, fs / (2 * block_length(len(x), fs)))
