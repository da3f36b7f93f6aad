"""The slow end: differenced block means and their exact Gaussian likelihood.

A record is cut into blocks of T seconds; the differences of neighbouring block means are a
stationary series even where the signal itself walks, and the turn-on bias drops out of them.
Their covariance is Toeplitz and known in closed form for every process, so the Durbin-Levinson
recursion whitens them, and any drift with them, exactly in O(n^2).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.gap import fast
from imu_lib.processes import Sum

#: Cutoff times the length of a block from which on the memory of a filter is short beside it.
SHORT_MEMORY = 2.0


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


def covariance(terms, low_pass, layout, n: int, m: int, fs: float) -> np.ndarray:
    """Autocovariance, shape (n,), of the differenced means of blocks of `m` samples: the terms',
    and what a filter takes from them.
    """
    c = sum((t.block_covariance(n, m, fs) for t in terms), np.zeros(n))
    if low_pass is None:
        return c
    before = tuple(t for t in terms if t.name != "common_mode" or t.filtered)
    width = m / fs
    if low_pass.cutoff is not None and low_pass.cutoff * width < SHORT_MEMORY:
        bare, filtered = Sum(before), Sum(before, (low_pass,))
        return c + filtered.block_covariance(n, m, fs) - bare.block_covariance(n, m, fs)
    # the filter's memory is short beside a block: what it adds at zero frequency (images folded by
    # the sampling) is white, and beyond that it moves noise across the edges alone, as a
    # quantization does, by the first moment of the autocovariance that it adds
    added = fast.spectrum(before, low_pass, layout, fs) - fast.spectrum(before, None, layout, fs)
    size = fast.padded(layout.samples)
    share = np.diff(layout.edge) * fs / size / (4.0 * np.sin(np.pi * layout.f / fs) ** 2)
    moment = -float((added - added[0]) @ share)
    c[:3] += np.array([-6.0, 4.0, -1.0])[:n] * moment / m**2
    c[:2] += np.array([2.0, -1.0])[:n] * added[0] * fs / (2 * m)
    return c


def spectrum(c) -> np.ndarray:
    """Spectrum of the differenced means on n frequencies up to half their rate, positive, shape
    (n,).
    """
    s = spectrum_difference(c)
    return np.maximum(s, 1e-3 * np.median(np.abs(s)) + 1e-300)


def spectrum_difference(c) -> np.ndarray:
    """Cosine transform of a covariance, or of a difference of two, shape (n,)."""
    return np.fft.rfft(np.concatenate([c, [0.0], c[:0:-1]])).real[1:]
