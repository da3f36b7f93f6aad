"""Overlapped Allan deviation of a record, with its intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.allan import confidence
from imu_lib.allan.clusters import squared_differences
from imu_lib.arrays import Array, ArrayLike
from imu_lib.processes import Process, Sum


@dataclass(frozen=True)
class AllanCurve:
    """An overlapped Allan deviation.

    Attributes
    ----------
    tau : ndarray, shape (j,)
        Averaging times, s.
    m : ndarray of int, shape (j,)
        The same in samples.
    adev : ndarray, shape (j,)
        Allan deviation, unit of the samples.
    low, high : ndarray, shape (j,)
        95 % chi-square interval.
    edf : ndarray, shape (j,)
        Equivalent degrees of freedom of each variance.
    slope : ndarray, shape (j,)
        Local exponent of tau in the variance, from which the degrees of freedom follow.
    n : ndarray of int, shape (j,)
        Windows averaged.
    samples : int
        Samples in the record, missing ones included.
    fs : float
        Sampling rate, Hz.
    """

    tau: Array
    m: Array
    adev: Array
    low: Array
    high: Array
    edf: Array
    slope: Array
    n: Array
    samples: int
    fs: float

    @property
    def avar(self) -> Array:
        """Allan variance, ndarray, shape (j,)."""
        return self.adev**2

    @property
    def duration(self) -> float:
        """Length of the record, s."""
        return self.samples / self.fs

    def holds(self, model: Sum | Process) -> Array:
        """Whether the 95 % interval at each averaging time holds the deviation of a model, ndarray
        of bool, shape (j,).
        """
        deviation = np.sqrt(model.avar(self.tau, self.fs))
        return (self.low <= deviation) & (deviation <= self.high)

    @property
    def papers_error(self) -> Array:
        """Relative standard error by the papers' formula (2013 Eq. 15, 2011 Eq. 23), ndarray,
        shape (j,).
        """
        return confidence.papers_error(self.samples, self.m)

    def at(self, tau: float) -> int:
        """Index of the averaging time nearest to `tau` (s) on the logarithmic axis."""
        return int(np.argmin(np.abs(np.log(self.tau / tau))))


def cluster_lengths(
    n: int, *, per_decade: int = 20, limit: int = 100, longest: int | None = None
) -> Array:
    """Log-spaced cluster lengths 1 ... n // 3, at most `limit` of them, ndarray of int."""
    longest = min(max(1, n // 3), longest or n)
    count = max(2, int(np.ceil(np.log10(longest) * per_decade)) + 1)
    while True:
        m = np.unique(np.round(np.geomspace(1, longest, count)).astype(np.int64))
        if m.size <= limit or count <= 2:
            return m
        count -= max(1, (m.size - limit) // 2)


def deviation(
    x: Array,
    fs: float,
    *,
    taus: ArrayLike | None = None,
    per_decade: int = 20,
    limit: int = 100,
    present: float = 1.0,
    threads: int | None = None,
) -> AllanCurve:
    """Overlapped Allan deviation at log-spaced averaging times (Quinchia et al. 2013, Eq. 13).

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples of rate or specific force. Values that are not finite are missing: windows that
        hold one are left out, so that gaps are no reason to cut a record.
    fs : float
        Sampling rate, Hz.
    taus : array_like or None
        Averaging times, s; each is rounded to a whole number of samples. By default `per_decade` a
        decade from one sample to a third of the record, at most `limit`.
    present : float
        Least fraction of a cluster's samples that must be there for its window to count; below 1
        where single samples drop out all over the record (the mean is then over those there).
    threads : int or None
        Threads of the hot loop.

    Returns
    -------
    AllanCurve

    Raises
    ------
    ValueError
        For an `x` that is not a series of at least three samples, an `fs`, `taus` or `present` out
        of range.
    """
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or x.size < 3:
        raise ValueError(f"`x` must be a series of at least 3 samples, not of shape {x.shape}")
    if not np.isfinite(fs) or fs <= 0:
        raise ValueError(f"`fs` must be a positive rate in Hz, not {fs}")
    if not 0 < present <= 1:
        raise ValueError(f"`present` must lie in (0, 1], not {present}")
    if taus is None:
        m = cluster_lengths(x.size, per_decade=per_decade, limit=limit)
    else:
        m = np.unique(np.round(np.atleast_1d(np.asarray(taus, dtype=float)) * fs).astype(np.int64))
        m = m[(m >= 1) & (2 * m <= x.size)]
        if m.size == 0:
            raise ValueError(
                "`taus` holds no averaging time between one sample and half the record"
            )
    means, counts = squared_differences(x, m, present=present, threads=threads)
    if not (counts > 0).any():
        raise ValueError("`x` holds no two adjacent clusters without a missing sample")
    return of_means(m, means, counts, int(x.size), fs)


def of_means(m: Array, means: Array, counts: Array, samples: int, fs: float) -> AllanCurve:
    """The curve, with its intervals, from mean squared differences of neighbouring cluster means.

    Parameters
    ----------
    m : ndarray of int, shape (j,)
        Cluster lengths, samples.
    means : ndarray, shape (j,)
        Of the squared differences.
    counts : ndarray of int, shape (j,)
        Windows that went in; cluster lengths of which there is none are left out.
    samples : int
        In the record.
    fs : float, Hz
    """
    keep = counts > 0
    m, variance, counts = m[keep], means[keep] / 2, counts[keep]
    tau = m / fs
    positive = np.where(variance > 0, variance, np.nan)
    slope = confidence.local_slope(tau, positive)
    edf = confidence.degrees_of_freedom(m, counts, slope)
    adev = np.sqrt(variance)
    low, high = confidence.interval(adev, edf)
    return AllanCurve(tau, m, adev, low, high, edf, slope, counts, samples, float(fs))
