"""The hot loop: sums of squared differences of adjacent clusters, over every start and many
cluster lengths.

The record is centred and integrated once, with a compensated sum, into theta (n + 1 values); a
cluster mean is then a difference of two of its values and each overlapped window costs three
loads. Windows are taken in blocks that stay in the processor's cache while all cluster lengths
pass over them, and blocks are spread over threads, so that nothing of the record's size is
allocated but theta itself (and, where samples are missing, their running count).
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit

from imu_lib.arrays import Array

BLOCK = 4096


@njit(cache=True, nogil=True)
def _integrate(x: Array, centre: float, theta: Array) -> float:
    """theta[k] = sum of the first k centred samples (Neumaier's compensated sum); returns the
    number missing.
    """
    missing = 0
    total = 0.0
    lost = 0.0
    theta[0] = 0.0
    for k in range(x.size):
        value = x[k] - centre
        if np.isfinite(value):
            new = total + value
            if abs(total) >= abs(value):
                lost += (total - new) + value
            else:
                lost += (value - new) + total
            total = new
        else:
            missing += 1
        theta[k + 1] = total + lost
    return missing


@njit(cache=True, nogil=True)
def _count_missing(x: Array, gone: Array) -> None:
    gone[0] = 0
    for k in range(x.size):
        gone[k + 1] = gone[k] + (0 if np.isfinite(x[k]) else 1)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def _full(theta: Array, m: int, start: int, stop: int) -> float:
    """Sum of (theta[k+2m] - 2 theta[k+m] + theta[k])^2 for k in start..stop-1."""
    total = 0.0
    a = theta[start:stop]
    b = theta[start + m : stop + m]
    c = theta[start + 2 * m : stop + 2 * m]
    for k in range(a.size):
        d = (c[k] - b[k]) - (b[k] - a[k])
        total += d * d
    return total


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz"})
def _whole(theta: Array, gone: Array, m: int, start: int, stop: int) -> tuple[float, int]:
    """The same over the windows that miss nothing; returns sum and count."""
    total = 0.0
    count = 0
    a, b, c = theta[start:stop], theta[start + m : stop + m], theta[start + 2 * m : stop + 2 * m]
    before, after = gone[start:stop], gone[start + 2 * m : stop + 2 * m]
    for k in range(a.size):
        d = (c[k] - b[k]) - (b[k] - a[k])
        here = 1 if before[k] == after[k] else 0
        total += here * (d * d)
        count += here
    return total, count


@njit(cache=True, nogil=True)
def _gappy(
    theta: Array, gone: Array, m: int, start: int, stop: int, allowed: int
) -> tuple[float, int]:
    """The same over windows of which each cluster misses at most `allowed` samples; returns sum
    and count.

    The mean of a cluster is over the samples that are present; the sum is scaled to theta's
    differences.
    """
    total = 0.0
    count = 0
    for k in range(start, stop):
        first = gone[k + m] - gone[k]
        second = gone[k + 2 * m] - gone[k + m]
        if first <= allowed and second <= allowed:
            d = m * (
                (theta[k + 2 * m] - theta[k + m]) / (m - second)
                - (theta[k + m] - theta[k]) / (m - first)
            )
            total += d * d
            count += 1
    return total, count


@njit(cache=True, nogil=True)
def _pass(
    theta: Array,
    gone: Array,
    lengths: Array,
    allowed: Array,
    first: int,
    last: int,
    block: int,
    sums: Array,
    counts: Array,
) -> None:
    """Blocks first..last-1 of the windows, all cluster lengths over each block."""
    n = theta.size - 1
    for b in range(first, last):
        start = b * block
        for i in range(lengths.size):
            stop = min(start + block, n - 2 * lengths[i] + 1)
            if stop > start:
                if gone.size:
                    if allowed[i] == 0:
                        total, count = _whole(theta, gone, lengths[i], start, stop)
                    else:
                        total, count = _gappy(theta, gone, lengths[i], start, stop, allowed[i])
                    sums[i] += total
                    counts[i] += count
                else:
                    sums[i] += _full(theta, lengths[i], start, stop)
                    counts[i] += stop - start


def squared_differences(
    x: Array, lengths: Array, *, present: float = 1.0, threads: int | None = None
) -> tuple[Array, Array]:
    """Mean squared difference of adjacent cluster means over all overlapped windows.

    Parameters
    ----------
    x : ndarray, shape (n,), float
        Samples; a value that is not finite is missing.
    lengths : ndarray of int, shape (j,)
        Cluster lengths m, 1 <= m <= n // 2.
    present : float
        Least fraction of a cluster's samples that must be there for its window to count.
    threads : int or None
        Number of threads; as many as processors (at most four) by default.

    Returns
    -------
    means : ndarray, shape (j,)
        Mean over windows of (second cluster's mean - first's)^2; NaN where no window is complete.
    counts : ndarray of int, shape (j,)
        Windows that went in.
    """
    x = np.asarray(x, dtype=float)
    lengths = np.ascontiguousarray(lengths, dtype=np.int64)
    theta = np.empty(x.size + 1)
    missing = _integrate(x, _centre(x), theta)
    gone = np.empty(0, dtype=np.int32)
    if missing:
        gone = np.empty(x.size + 1, dtype=np.int32)
        _count_missing(x, gone)
    allowed = np.minimum(np.floor((1.0 - present) * lengths + 1e-9), lengths - 1).astype(np.int64)
    blocks = -(-(x.size + 1) // BLOCK)
    threads = threads or min(4, os.cpu_count() or 1)
    pieces = np.linspace(0, blocks, min(blocks, 16 * threads) + 1).astype(int)

    def work(bounds: tuple[int, int]) -> tuple[Array, Array]:
        sums, counts = np.zeros(lengths.size), np.zeros(lengths.size, dtype=np.int64)
        _pass(theta, gone, lengths, allowed, bounds[0], bounds[1], BLOCK, sums, counts)
        return sums, counts

    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(work, zip(pieces[:-1], pieces[1:], strict=True)))
    sums = np.array([p[0] for p in parts])
    counts = np.sum([p[1] for p in parts], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(
            counts > 0, sums.sum(axis=0) / counts / lengths.astype(float) ** 2, np.nan
        ), counts


def _centre(x: Array) -> float:
    """A value near the mean, taken from finite samples without a copy of the record."""
    head = x[:: max(1, x.size // 20000)]
    head = head[np.isfinite(head)]
    return float(head.mean()) if head.size else 0.0
