"""Autocovariances of block means from sums that one pass over a record made."""

from __future__ import annotations

import numpy as np

from imu_lib.autocorrelation.gauss_markov import of_levels
from imu_lib.autocorrelation.lag_fit import SEGMENT, SMALLEST, Level, block_levels
from imu_lib.stream import LagSums, Products

#: Lags of the block means that are fitted.
LAGS = 32


def sums(begin=0):
    """What a pass makes of the means at one level of the cascade: lagged and segments' products."""
    return [LagSums(LAGS, begin), Products(SEGMENT, begin)]


def autocovariance(made: LagSums, lags: int) -> np.ndarray:
    """Sample autocovariances about the mean, lags 0 ... `lags`, (lags + 1,), sums over n."""
    products, total, n = made.total
    mean = total / n
    first = np.concatenate([[0.0], np.cumsum(made.head[:lags])])
    last = np.concatenate([[0.0], np.cumsum(made.tail[::-1][:lags])])
    d = np.arange(lags + 1)
    cross = mean * (2 * total - first - last) - (n - d) * mean**2
    return (products[: lags + 1] - cross) / n


def characterise(levels, coarsest, unit, fs):
    """sigma and correlation time of a channel, dict of str to Estimate.

    Parameters
    ----------
    levels : list of (LagSums, Products)
        Of means of 1, 2, 4, ... samples.
    coarsest : ndarray
        The means of `unit` samples, the next of the cascade, as they are.
    fs : float, Hz
    """
    variance = autocovariance(levels[0][0], 1)[0]
    found = []
    for k, (lagged, segments) in enumerate(levels):
        n = lagged.total[2]
        gamma = autocovariance(lagged, min(LAGS, n // 3)) / variance
        found.append(
            Level.of(1 << k, n, gamma, products=(segments.matrix / variance, segments.count))
        )
    if coarsest.size >= SMALLEST:
        found += block_levels(coarsest / np.sqrt(variance), LAGS, unit=unit)
    fit = of_levels(found, fs, np.sqrt(variance))
    return {"sigma": fit.sigma, "correlation_time": fit.correlation_time}
