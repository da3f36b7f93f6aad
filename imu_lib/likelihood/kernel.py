"""What a spectrum makes of the first cosine coefficients of a finite record.

The p-th cosine coefficient of a record of length T gathers the one-sided density S(f) with the
weight |W_p(u)|^2, u = f T, of its window w_p(s) = sqrt(2) cos(pi p s), 0 <= s <= 1:

    |W_p(u)|^2 = 4 a^2 (1 - (-1)^p cos a) / (a^2 - pi^2 p^2)^2,   a = 2 pi u,

so the expected square is the integral of S(u/T) |W_p(u)|^2 du from 0 to infinity. High up this is
S at f = p/(2T); for the first coefficients of a process whose correlation time is a sizeable part
of the record it is not (a Gauss-Markov process with Tc = T/4 has a third less power in p = 1). A
walk and white noise give S exactly at every p. The weights depend on u alone: one matrix serves
every record and every process.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from imu_lib.arrays import Array

NODES_PER_DECADE = 16
U_LOW, U_HIGH = 1e-4, 1e5


def _window_power(u: Array, p: Array) -> Array:
    """|W_p(u)|^2 for u (k,), p (q,) -> (q, k); at the removable poles u = p/2 the value is 1/2."""
    a, pole = 2 * np.pi * u[None, :], np.pi * p[:, None]
    gap = a**2 - pole**2
    near = np.abs(a - pole) < 1e-6
    power = 4 * a**2 * (1 - (-1.0) ** p[:, None] * np.cos(a)) / np.where(near, 1.0, gap) ** 2
    return np.where(near, 0.5, power)


@lru_cache(maxsize=64)
def weights(count: int) -> tuple[Array, Array]:
    """Weights of the first `count` coefficients on the nodes u.

    Returns
    -------
    u : ndarray, shape (k,)
        Nodes f T at which the density is wanted, log-spaced.
    matrix : ndarray, shape (count, k)
        Rows sum to 1 over a flat density: expected square / (fs/2) = matrix @ S(u/T).
    """
    p = np.arange(1, count + 1)
    decades = np.log10(U_HIGH / U_LOW)
    u = np.geomspace(U_LOW, U_HIGH, int(round(decades * NODES_PER_DECADE)) + 1)
    top = count + 150.0
    # a trapezoid on a uniform grid is exact for the band-limited window; below 0.5 a log grid
    # follows 1/f^2 densities
    edges = [
        np.geomspace(U_LOW, 0.5, 801),
        np.arange(0.5, top, 0.02),
        np.geomspace(top, U_HIGH, 401),
    ]
    matrix = np.zeros((count, len(u)))
    for part, fine in enumerate(edges):
        step = np.gradient(fine)
        step[[0, -1]] = (fine[1] - fine[0]) / 2, (fine[-1] - fine[-2]) / 2
        if part < 2:
            power = _window_power(fine, p)
        else:  # the oscillation averages out
            a2 = (2 * np.pi * fine[None, :]) ** 2
            power = 4 * a2 / (a2 - (np.pi * p[:, None]) ** 2) ** 2
        # interpolating S u rather than S keeps both 1/f^2 and flat densities gentle between nodes
        spread = CubicSpline(np.log(u), np.diag(u))(np.log(fine)) / fine[:, None]
        matrix += (power * step) @ spread
    return u, 2 * matrix / (2 * matrix).sum(axis=1, keepdims=True)
