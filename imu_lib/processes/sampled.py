"""From an autocovariance or a variogram to the exact Allan variance of the samples.

With y the mean of m consecutive samples, s_d = E (x_{k+d} - x_k)^2 / 2 the semivariogram and
D_h = sum over |d| < h of (h - |d|) s_d,

    avar(m) = (D_{2m} / 2 - 2 D_m) / m^2

which holds for every process with stationary increments; for a stationary one s_d = r_0 - r_d and
the same with -r_d in place of s_d.
"""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array, ArrayLike


def cluster_size(tau: ArrayLike, fs: float) -> Array:
    """Samples per cluster, m = round(tau fs), at least 1, shape of `tau`."""
    return np.maximum(np.rint(np.asarray(tau, dtype=float) * fs), 1.0)


def avar_from_semivariogram(s: Array, m: int) -> float:
    """Exact Allan variance at cluster size m from s_0 .. s_{2m-1}, shape (>= 2m,)."""
    s = np.asarray(s[: 2 * m], dtype=float)
    d = np.arange(2 * m)
    short = 2.0 * np.sum((m - d[1:m]) * s[1:m]) + m * s[0]
    long = 2.0 * np.sum((2 * m - d[1:]) * s[1:]) + 2 * m * s[0]
    return float((0.5 * long - 2.0 * short) / m**2)


def avar_from_short_memory(r: Array, m: ArrayLike) -> Array:
    """Exact Allan variance at cluster sizes `m` of an autocovariance r_0 .. r_{L-1} that is zero
    beyond.
    """
    m = np.asarray(m, dtype=float)
    d = np.arange(1, len(r))
    zeroth = np.concatenate([[0.0], np.cumsum(r[1:])])
    first = np.concatenate([[0.0], np.cumsum(d * r[1:])])

    def double_sum(h: Array) -> Array:
        k = np.minimum(h, len(r)).astype(int) - 1
        return h * r[0] + 2.0 * (h * zeroth[k] - first[k])

    return (2.0 * double_sum(m) - 0.5 * double_sum(2 * m)) / m**2


def avar_from_transition(
    transition: Array, covariance: Array, output: Array, m: ArrayLike
) -> Array:
    """Exact Allan variance at cluster sizes `m` of y = output . x, x' = transition x + w,
    stationary.

    The sums of the autocovariance output' transition^d covariance output are geometric series of
    a matrix, so any stationary state space has a closed form.
    """
    k = len(output)
    inverse = np.linalg.inv(np.eye(k) - transition)
    right = covariance @ output
    r0 = output @ right

    def double_sum(h: float) -> float:
        power = np.linalg.matrix_power(transition, int(h))
        series = transition @ (h * inverse - (np.eye(k) - power) @ inverse @ inverse)
        return h * r0 + 2.0 * output @ series @ right

    return np.array(
        [(2.0 * double_sum(h) - 0.5 * double_sum(2 * h)) / h**2 for h in np.atleast_1d(m)]
    ).reshape(np.shape(m))
