"""Covariance of overlapped Allan variance estimates across averaging times, from a model's
spectrum.

An estimate V_i is the mean over M_i windows of D_i^2, where D_i is the record through a filter
with the real, even response h_i about the window's centre. For a Gaussian process

    Cov(V_i, V_j) = 2 / (M_i M_j) * sum over the lags d of w_ij(d) C_ij(d)^2,
    C_ij(d) = integral of S(f) h_i(f) h_j(f) cos(2 pi f d / fs) df,

with w_ij(d) the number of pairs of windows whose centres are d samples apart. While the clusters
are short against the record, w_ij = min(M_i, M_j) wherever C_ij matters and Parseval's theorem
turns the sum into an integral over frequency, a Gram matrix. For the long clusters the sum is done
as it stands, on a coarse grid of lags.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from imu_lib.arrays import Array

# Frequencies per octave, spread through the lobes of h by the golden ratio: few where all
# responses are smooth (below
# a quarter of a cycle in the record), many at the top, where quantization has its power.
_SMOOTH, _PER_OCTAVE, _TOP = 24, 90, 400
_LONG = 32  # clusters longer than n / _LONG are summed over lags
_LAGS = 256  # grid of lags over the record


class Quadrature:
    """Frequencies, weights and window responses for a record of n samples and cluster lengths m.

    Parameters
    ----------
    m : ndarray of int, shape (j,)
    n : int
        Samples in the record.
    windows : ndarray, shape (j,)
        Windows averaged at each cluster length (fewer than n - 2 m + 1 where samples are missing).
    fs : float
        Hz.
    """

    def __init__(self, m: Array, n: int, windows: Array, fs: float) -> None:
        self.m = np.asarray(m, dtype=float)
        self.n, self.fs = int(n), float(fs)
        self.windows = np.asarray(windows, dtype=float)
        self.f, self.weight, self.response = _grid(tuple(int(k) for k in m), self.n)
        self.f = self.f * self.fs
        self._mean: Array | None = None
        self.long = np.flatnonzero(self.m > self.n / _LONG)

    def covariance(self, density: Array) -> Array:
        """Covariance of the Allan variances, ndarray, shape (j, j).

        Parameters
        ----------
        density : ndarray, shape (k,)
            One-sided density of the samples at the frequencies `f`, unit^2/Hz.
        """
        power = density * self.fs * self.response**2  # (j, k): S |h|^2 per unit of f / fs
        gram = (power * self.weight) @ power.T  # 2 sum C_ij^2 = integral of (S |h_i| |h_j|)^2
        share = np.minimum(1 / self.windows[:, None], 1 / self.windows[None, :])
        out = gram * share
        if self.long.size:
            self._replace_long(out, density, power, share)
        return out

    def mean_covariance(self, density: Array) -> Array:
        """Covariance of the plain means of the windows D_i (the square root's linear term),
        ndarray, shape (j, j).
        """
        if self._mean is None:
            x = np.pi * self.f / self.fs
            count = (self.n - 2 * self.m + 1)[:, None]
            self._mean = self.response * np.sin(x * count) / (count * np.sin(x))
        return (self._mean * (density * self.fs * self.weight)) @ self._mean.T

    def _replace_long(self, out: Array, density: Array, power: Array, share: Array) -> None:
        """The block of long clusters, summed over lags with the true number of pairs of windows.

        What varies faster than the grid of lags resolves adds its part by Parseval's theorem as
        before.
        """
        idx = self.long
        cosine, low, step = _cosines(tuple(int(k) for k in self.m), self.n)
        lag = step * np.arange(cosine.shape[1])
        half = (density[low] * self.fs * self.weight[low])[None, :] * self.response[idx][:, low]
        rows, columns = np.triu_indices(idx.size)
        cross = (half[rows] * self.response[idx][:, low][columns]) @ cosine  # (pairs, lags)
        whole = self.n - 2 * self.m[idx] + 1
        before = np.diag(out)[idx].copy()
        fast = np.ones(self.f.size, dtype=bool)
        fast[low] = False
        exact = (
            (power[idx][:, fast] * self.weight[fast])
            @ power[idx][:, fast].T
            * share[np.ix_(idx, idx)]
        )
        for p, (a, b) in enumerate(zip(rows, columns, strict=True)):
            few, many = sorted((whole[a], whole[b]))
            pairs = np.clip((whole[a] + whole[b]) / 2 - lag, 0, few)
            total = step * (2 * np.sum(pairs * cross[p] ** 2) - pairs[0] * cross[p, 0] ** 2)
            missing = np.sqrt(whole[a] * whole[b] / (self.windows[idx[a]] * self.windows[idx[b]]))
            exact[a, b] += 2 * total / (few * many) * missing
            exact[b, a] = exact[a, b]
        # the same edge effect, ever smaller, on the shorter clusters, so that the two parts join
        # smoothly
        edge = np.sqrt(np.diag(exact) / before)
        scale = np.sqrt(1 - np.minimum((1 - edge[0] ** 2) * self.m / self.m[idx[0]], 0.5))
        scale[idx] = edge
        out *= np.outer(scale, scale)
        out[np.ix_(idx, idx)] = exact


@lru_cache(maxsize=8)
def _grid(m: tuple[int, ...], n: int) -> tuple[Array, Array, Array]:
    """Frequencies (cycles per sample), quadrature weights, and h of each cluster length."""
    pieces = []
    for low, high, density in (
        (1 / (64 * n), 0.25 / n, _SMOOTH),
        (0.25 / n, 1 / 32, _PER_OCTAVE),
        (1 / 32, 0.5, _TOP),
    ):
        octaves = np.log2(high / low) if high > low else 0.0
        count = int(np.ceil(octaves * density))
        shift = (np.arange(count) * 0.6180339887498949) % 1.0
        f = low * 2.0 ** ((np.arange(count) + shift) * octaves / max(count, 1))
        pieces.append((f, np.log(2) * octaves / max(count, 1) * f))
    f, weight = (np.concatenate(part) for part in zip(*pieces, strict=True))
    length = np.asarray(m, dtype=float)[:, None]
    response = np.sqrt(2) * np.sin(np.pi * f * length) ** 2 / (length * np.sin(np.pi * f))
    return f, weight, response


@lru_cache(maxsize=8)
def _cosines(m: tuple[int, ...], n: int) -> tuple[Array, Array, float]:
    """cos(2 pi f d) on the grid of lags, for the frequencies that long clusters see; the indices;
    the step.
    """
    f, _, _ = _grid(m, n)
    step = n / _LAGS
    low = np.flatnonzero(f < 0.5 / step)
    return np.cos(2 * np.pi * np.outer(f[low], step * np.arange(_LAGS))), low, step
