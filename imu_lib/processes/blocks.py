"""Autocovariance of the differences of neighbouring block means.

A record is cut into blocks of m samples; with y_i the mean of block i, d_i = y_{i+1} - y_i is
stationary even where the signal walks, and a turn-on bias drops out of it. With r_j the
autocovariance of the block means,

    c_j = E d_i d_{i+j} = 2 r_j - r_{j-1} - r_{j+1},        c_0 = 2 avar(m samples).

Each process answers with its own closed form (`Process.block_covariance`); what has none is
integrated from its spectrum here.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.fft import dct

from imu_lib.arrays import Array

#: Points of the integral between two multiples of the block rate: in the lowest interval for each
#: lag (a feature narrower than an eighth of the resolution of the record is a line), then fewer
#: where 1 / f^2 leaves little.
POINTS_PER_LAG, POINTS_NEAR, POINTS_FAR = 8, 256, 16
#: Intervals that count as near.
NEAR = 32


def from_means(r: Array, half: float) -> Array:
    """c_0 .. c_{n-1} from r_0 .. r_n of the block means (r_0 is not used), shape (n + 1,), and the
    Allan variance `half`, in which nothing cancels.
    """
    n = len(r) - 1
    c = np.empty(n)
    c[0] = 2.0 * half
    if n > 1:
        c[1] = (r[1] - r[2]) - half
        c[2:] = (r[2:-1] - r[1:-2]) - (r[3:] - r[2:-1])
    return c


def from_psd(psd: Callable[[Array], Array], n: int, m: int, fs: float) -> Array:
    """c_0 .. c_{n-1}, shape (n,), by integration of the one-sided spectrum `psd(f)` of the samples.

    The spectrum of the differences at the block rate fs / m is that of the samples through the
    block mean, folded: 4 sin^4(pi f T) times the sum over all images of S / (m sin(pi f / fs))^2.
    """
    rate, points = fs / m, max(POINTS_PER_LAG * n, 1024)

    def folded(f: Array, images: Array) -> Array:
        f = np.mod(f[None, :] + images[:, None] * rate, fs)
        f = np.minimum(f, fs - f)
        f = np.maximum(f, 1e-9 * rate)
        return np.sum(psd(f.ravel()).reshape(f.shape) / (m * np.sin(np.pi * f / fs)) ** 2, axis=0)

    f = (np.arange(points) + 0.5) * rate / (2 * points)
    density = folded(f, np.zeros(1))
    k = np.arange(1, m)
    near = np.minimum(k, m - k) <= NEAR
    for images, count in ((k[near], POINTS_NEAR), (k[~near], POINTS_FAR)):
        at = np.linspace(0.0, rate / 2, count)
        for part in np.array_split(images, max(1, len(images) * count // 1_000_000)):
            if len(part):
                density += np.interp(f, at, folded(at, part))
    density *= 4.0 * np.sin(np.pi * f / rate) ** 4
    return dct(density, type=2)[:n] * (rate / (4 * points))


def from_short_memory(r: Array, n: int, m: int) -> Array:
    """c_0 .. c_{n-1}, shape (n,), of samples with the autocovariance r_0 .. r_{L-1}, zero beyond."""
    d = np.arange(len(r))
    zeroth, first = np.cumsum(r), np.cumsum(d * r)

    def triangle(h: Array) -> Array:  # sum over |d| < h of (h - |d|) r_|d|
        k = np.minimum(h, len(r)) - 1
        return np.where(h > 0, 2.0 * (h * zeroth[k] - first[k]) - h * r[0], 0.0)

    # every second difference of it over blocks is a covariance of block means
    whole = triangle(np.arange(n + 3) * m)
    between = np.empty(n + 2)
    between[0] = whole[1]
    between[1:] = 0.5 * (whole[2:] - 2.0 * whole[1:-1] + whole[:-2])
    between /= m**2
    return from_means(between[: n + 1], float(between[0] - between[1]))


def from_transition(
    transition: Array, covariance: Array, output: Array, n: int, m: int, half: float
) -> Array:
    """c_0 .. c_{n-1}, shape (n,), of y = output . x, x' = transition x + w, stationary.

    r_j = output' S F^{(j-1)m+1} S covariance output / m^2 with S = 1 + F + ... + F^{m-1}.
    """
    k = len(output)
    power = np.linalg.matrix_power(transition, m)
    series = np.linalg.solve((np.eye(k) - transition).T, (np.eye(k) - power).T).T
    left, right = output @ series, transition @ series @ covariance @ output
    r = np.zeros(n + 2)
    least = 1e-14 * np.linalg.norm(right)
    for j in range(1, n + 2):
        r[j] = left @ right / m**2
        right = power @ right
        if np.linalg.norm(right) < least:
            break
    return from_means(r[: n + 1], half)


def from_semivariogram(s: Array, n: int, m: int) -> Array:
    """c_0 .. c_{n-1}, shape (n,), of samples with the semivariogram s_0 .. s_{(n+1)m-1}, that is
    E (x_{k+d} - x_k)^2 / 2.
    """
    second = np.concatenate([[0.0], np.cumsum(np.cumsum(s))])  # sum over d < h of (h - d) s_d
    whole = second[np.arange(n + 2) * m]
    mean = np.empty(n + 1)  # mean semivariogram between blocks j apart
    mean[0] = (2.0 * whole[1] - m * s[0]) / m**2
    mean[1:] = (whole[2:] - 2.0 * whole[1:-1] + whole[:-2]) / m**2
    step = np.concatenate([[mean[1] - mean[0]], mean - mean[0]])
    return step[2:] + step[:-2] - 2.0 * step[1:-1]
