"""How sure an overlapped Allan deviation is: equivalent degrees of freedom, and the papers'
percentage error.

The Allan variance estimate behaves like a chi-square with `edf` degrees of freedom, edf = 2 E[V]^2
/ Var[V]. For power-law noise the covariance of two windows that lie t cluster lengths apart is a
fourth difference of |t|^p (or t^p ln|t|), and Var[V] is the sum of its squares over all pairs of
windows (Greenhall and Riley 2003, Eqs. 7-10).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import stats

from imu_lib.arrays import Array, ArrayLike

#: Exponent of tau in the Allan variance, and alpha, the exponent in Greenhall and Riley's density
#: f^(alpha - 2).
SLOPES = {-2: 2, -1: 0, 0: -1, 1: -2}
_STEPS = 100  # windows per cluster length where there are more than this


def _power(t: Array, alpha: int) -> Array:
    """Generalised autocovariance |t|^(3 - alpha), with ln|t| for odd alpha (Eq. 7; a common
    factor does not matter).
    """
    t = np.abs(t)
    return t ** (3 - alpha) * (np.log(np.where(t > 0, t, 1.0)) if alpha % 2 else 1.0)


def _covariance(t: Array, alpha: int, m: int | None = None) -> Array:
    """Covariance of two windows t cluster lengths apart (Eqs. 8-9; m None where the cluster is
    very long).
    """

    def between(u: Array) -> Array:
        if m is None:
            return _power(u, alpha + 2)
        return m**2 * (2 * _power(u, alpha) - _power(u - 1 / m, alpha) - _power(u + 1 / m, alpha))

    return 6 * between(t) - 4 * (between(t - 1) + between(t + 1)) + between(t - 2) + between(t + 2)


@lru_cache(maxsize=16)
def _squares(alpha: int, steps: int, m: int | None) -> Array:
    """Squared correlation of windows 0, 1/steps, 2/steps, ... cluster lengths apart, up to
    three.
    """
    t = np.arange(3 * steps + 1) / steps
    covariance = _covariance(t, alpha, m)
    return (covariance / covariance[0]) ** 2


def _edf(alpha: int, m: int, windows: float) -> float:
    """Degrees of freedom of one averaging time (Eqs. 10-13)."""
    if alpha == 2:
        if windows <= 2 * m:
            alpha = 0  # no closed form this far out, where quantization does not rule anyway
        else:
            return windows / (70 / 36 - m / windows)  # Eq. 20: binom(8, 4) / binom(4, 2)^2, d / 2
    steps = min(m, _STEPS)
    squares = _squares(alpha, steps, m if 3 * m <= 100 else None)
    count = windows * steps / m  # windows at the coarser stride, which loses nothing
    lag = np.arange(1, min(squares.size, int(np.ceil(count))))
    return count / (squares[0] + 2 * np.sum((1 - lag / count) * squares[lag]))


def degrees_of_freedom(m: Array, windows: Array, slope: Array) -> Array:
    """Equivalent degrees of freedom of overlapped Allan variance estimates.

    Parameters
    ----------
    m : ndarray of int, shape (j,)
        Cluster lengths, samples.
    windows : ndarray, shape (j,)
        Number of overlapped windows, n - 2 m + 1 for a whole record.
    slope : ndarray, shape (j,)
        Local exponent of tau in the Allan variance: -2 quantization, -1 white, 0 flicker, 1 walk.
        Between those the logarithm of the degrees of freedom is interpolated; outside it is held.

    Returns
    -------
    ndarray, shape (j,)
    """
    known = np.array(sorted(SLOPES))
    out = np.empty(len(m))
    for j, (length, count, s) in enumerate(zip(m, windows, slope, strict=True)):
        if count < 1:
            out[j] = np.nan
            continue
        s = min(max(s, known[0]), known[-1])
        below = int(min(np.searchsorted(known, s, side="right") - 1, known.size - 2))
        share = s - known[below]
        ends = [
            np.log(_edf(SLOPES[int(k)], int(length), float(count)))
            for k in known[below : below + 2]
        ]
        out[j] = np.exp((1 - share) * ends[0] + share * ends[1])
    return np.maximum(out, 1.0)


def local_slope(tau: Array, variance: Array, *, decades: float = 0.5) -> Array:
    """Exponent of tau in the Allan variance around each averaging time, by a straight line in
    log-log.

    The line covers `decades` of tau and weighs each point by tau^-1, its variance for white noise.
    Quantization comes before every other noise: once the curve has turned to a slope above -1.3, a
    steeper stretch is scatter and counts as white.
    """
    x, y = np.log(tau), np.log(variance)
    good = np.isfinite(y)
    out = np.full(x.size, -1.0)
    if good.sum() < 2:
        return out
    for j in np.flatnonzero(good):
        half = decades * np.log(10) / 2
        near = good & (
            np.abs(x - np.clip(x[j], x[good][0] + half, x[good][-1] - half)) <= half * 1.001
        )
        if near.sum() < 2:
            near = np.isin(
                np.arange(x.size), np.flatnonzero(good)[np.argsort(np.abs(x[good] - x[j]))[:2]]
            )
        weight = 1 / tau[near]
        dx = x[near] - np.average(x[near], weights=weight)
        out[j] = np.sum(weight * dx * y[near]) / np.sum(weight * dx * dx)
    turned = np.cumsum(out > -1.3) > 0
    return np.where(turned, np.maximum(out, -1.0), out)


def interval(deviation: ArrayLike, edf: ArrayLike, *, level: float = 0.95) -> tuple[Array, Array]:
    """Two-sided chi-square interval of a deviation (or, squared, of a variance) with `edf` degrees
    of freedom.
    """
    tail = (1 - level) / 2
    low = deviation * np.sqrt(edf / stats.chi2.ppf(1 - tail, edf))
    high = deviation * np.sqrt(edf / stats.chi2.ppf(tail, edf))
    return low, high


def papers_error(n: int, m: ArrayLike) -> Array:
    """Relative standard error of an Allan deviation as the papers give it: 1 / sqrt(2 (n/m - 1)).

    Quinchia et al. 2013, Eq. 15 and Zhao et al. 2011, Eq. 23 (there in per cent). It counts
    clusters that do not overlap and takes no notice of the kind of noise.
    """
    return 1 / np.sqrt(2 * (np.asarray(n) / np.asarray(m) - 1))
