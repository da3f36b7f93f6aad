"""The slow end: differenced block means and their exact Gaussian likelihood.

A record is cut into blocks of T seconds; the differences of neighbouring block means are a
stationary series even where the signal itself walks, and the turn-on bias drops out of them.
Their covariance is Toeplitz and known in closed form for every process, so the Durbin-Levinson
recursion whitens them, and any drift with them, exactly in O(n^2).
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, fastmath=True, inline="always")
def _step(c, phi, old, v, k):
    """Predictor of order k from that of order k - 1, in place; returns its error variance."""
    acc = c[k]
    for i in range(k - 1):
        acc -= phi[i] * c[k - 1 - i]
    r = acc / v
    for i in range(k - 1):
        old[i] = phi[i]
    for i in range(k - 1):
        phi[i] = old[i] - r * old[k - 2 - i]
    phi[k - 1] = r
    return v * (1.0 - r * r)


@njit(cache=True, nogil=True, fastmath=True)
def _levinson(c, y):
    n, q = y.shape
    out = np.empty((n, q))
    phi = np.zeros(n)
    old = np.zeros(n)
    v = c[0]
    logdet = np.log(v)
    for j in range(q):
        out[0, j] = y[0, j] / np.sqrt(v)
    for k in range(1, n):
        v = _step(c, phi, old, v, k)
        if not v > 0.0:
            return np.inf, out
        logdet += np.log(v)
        s = 1.0 / np.sqrt(v)
        for j in range(q):
            e = y[k, j]
            for i in range(k):
                e -= phi[i] * y[k - 1 - i, j]
            out[k, j] = e * s
    return logdet, out


def whiten(covariance, y):
    """Log-determinant and whitened columns of `y`, shape (n, q), under the Toeplitz covariance
    (n,).
    """
    y = np.ascontiguousarray(y, dtype=float)
    if y.ndim == 1:
        y = y[:, None]
    return _levinson(np.ascontiguousarray(covariance, dtype=float), y)


@njit(cache=True, nogil=True, fastmath=True)
def _rows(c):
    n = len(c)
    out = np.zeros((n, n))
    phi = np.zeros(n)
    old = np.zeros(n)
    v = c[0]
    out[0, 0] = 1.0 / np.sqrt(v)
    for k in range(1, n):
        v = _step(c, phi, old, v, k)
        s = 1.0 / np.sqrt(v)
        out[k, k] = s
        for i in range(k):
            out[k, k - 1 - i] = -phi[i] * s
    return out


def whitening_matrix(covariance) -> np.ndarray:
    """The lower triangular matrix that whitens a series of this Toeplitz covariance, shape (n, n)."""
    return _rows(np.ascontiguousarray(covariance, dtype=float))


def block_length(n: int, fs: float, *, most: int = 640, shortest: float = 4.0) -> int:
    """Samples in a block: at least 4 s, and at most 640 blocks to a record; short records get at
    least 48 blocks.
    """
    samples = max(shortest * fs, n / most)
    return int(max(1, min(round(samples), n // 48)))


def block_means(x, m: int) -> np.ndarray:
    """Means of consecutive blocks of `m` samples; the tail that fills no block is left out."""
    k = len(x) // m
    return x[: k * m].reshape(k, m).mean(axis=1)


def covariance(process, n: int, m: int, fs: float) -> np.ndarray:
    """Autocovariance, shape (n,), of the differenced means of blocks of `m` samples."""
    T = m / fs
    half = float(process.avar(np.array([T]), fs)[0])
    c = np.zeros(max(n, 3))
    name = process.name
    if name == "quantization":
        q2 = (process.Q / T) ** 2
        c[:3] = 6 * q2, -4 * q2, q2
    elif name == "random_walk":
        c[1] = process.K**2 * T / 6
    elif name == "gauss_markov":
        b = 1.0 / (fs * process.correlation_time)
        q = -np.expm1(-m * b)
        a = process.sigma**2 * np.exp(-b) * (q / (m * -np.expm1(-b))) ** 2
        c[1] = a * q - half
        c[2:] = -a * q**2 * np.exp(-m * b * np.arange(len(c) - 2))
    elif name == "flicker":
        j = np.arange(len(c) + 2, dtype=float)
        g = np.zeros_like(j)
        g[1:] = process.B**2 / (2 * np.pi) * j[1:] ** 2 * np.log(j[1:])
        c[2:] = g[4:] - 4 * g[3:-1] + 6 * g[2:-2] - 4 * g[1:-3] + g[:-4]
        c[1] = g[3] - 4 * g[2] + 7 * g[1] - 4 * g[0]
    elif name == "gauss_markov_2":
        u = process.beta * T * np.arange(len(c) + 2)
        g = process.sigma**2 / (process.beta * T) ** 2 * (3 + u) * np.exp(-u)
        r = g[2:] - 2 * g[1:-1] + g[:-2]  # r[j - 1]: covariance of block means j apart
        c[1] = r[0] - r[1] - half
        c[2:] = (2 * r[1:] - r[:-1] - np.append(r[2:], 0.0))[: len(c) - 2]
        c[-1] = 0.0 if len(c) > 3 else c[-1]
    else:  # white noise and anything white over blocks
        c[1] = -half
    c[0] = 2 * half
    return c[:n]


def spectrum(c) -> np.ndarray:
    """Spectrum of the differenced means on n frequencies up to half their rate, positive, shape
    (n,).
    """
    s = spectrum_difference(c)
    return np.maximum(s, 1e-3 * np.median(np.abs(s)) + 1e-300)


def spectrum_difference(c) -> np.ndarray:
    """Cosine transform of a covariance, or of a difference of two, shape (n,)."""
    return np.fft.rfft(np.concatenate([c, [0.0], c[:0:-1]])).real[1:]
