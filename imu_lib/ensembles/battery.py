"""The battery: one set of statistics, computed the same way on the measurement and on every
simulation.

They are of the raw output, electronics and all. Each is on a scale on which simulations scatter
about normally (logarithms of powers), so that standardising by their scatter makes them comparable.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from scipy.fft import rfft

from imu_lib.arrays import Array

#: Bands of equal width that the range up to half the sampling rate is divided into, for the
#: spectrum and its lines.
BANDS = 64
#: Seconds of the blocks whose means and mean squares are taken, and how many of them at a time the
#: latter are taken over.
BLOCK, JOINED = 2.0, (1, 5, 15, 75)


def edges(n: int) -> np.ndarray:
    """Edges of the bands of the spectrum of `n` samples, in ordinates: logarithmic up to the width
    of `BANDS` equal ones.
    """
    last = n // 2 - 1
    steps = np.geomspace(3, last, 33)
    equal = np.linspace(0, last, BANDS + 1)
    narrow = steps[:-1][np.diff(steps) < equal[1]]
    return np.unique(
        np.round(np.concatenate([narrow, equal[equal > narrow[-1] + 0.5 * equal[1]]])).astype(int)
    )


@lru_cache(maxsize=4)
def _window(n: int) -> tuple[Array, Array]:
    """Hann taper of mean square 1, and the edges of the bands."""
    return (np.hanning(n) * np.sqrt(8 / 3)).astype(np.float32), edges(n)


@njit(cache=True, nogil=True)
def _pass(x: Array, b: int) -> tuple[Array, Array, Array, float, float, float, int, int]:
    """Block means, mean squares about them, moments and lagged products of the deviations, ties,
    ends of the range.
    """
    k = len(x) // b
    level, square = np.empty(k), np.empty(k)
    r = np.empty(k * b)
    s3 = s4 = 0.0
    for i in range(k):
        m = 0.0
        for j in range(i * b, i * b + b):
            m += x[j]
        m /= b
        level[i] = m
        q = 0.0
        for j in range(i * b, i * b + b):
            d = x[j] - m
            r[j] = d
            q += d * d
            s3 += d * d * d
            s4 += d * d * d * d
        square[i] = q / b
    same, high, low = 0, x[0], x[0]
    for j in range(1, len(x)):
        if x[j] == x[j - 1]:
            same += 1
        high = max(high, x[j])
        low = min(low, x[j])
    tops, bottoms = 0, 0
    for j in range(len(x)):
        tops += x[j] == high
        bottoms += x[j] == low
    return level, square, r, s3 / len(r), s4 / len(r), same / len(x), tops, bottoms


@njit(cache=True, nogil=True, fastmath=True)
def _avar(c: Array, m: int, step: int) -> float:
    """Mean square second difference of the cumulative sum `c` over `m` samples at every `step`-th
    instant, per sample squared.
    """
    acc, count = 0.0, 0
    for i in range(0, len(c) - 2 * m, step):
        d = c[i + 2 * m] - 2 * c[i + m] + c[i]
        acc += d * d
        count += 1
    return acc / count / m**2


@njit(cache=True, nogil=True, fastmath=True)
def _shape(r: Array, sd: float, lags: Array) -> tuple[float, float, float, float, Array]:
    """Shares of deviations beyond 3, beyond 4 and within 0.5 standard deviations, the largest, and
    lagged products.
    """
    n = len(r)
    a = b = c = 0
    most = 0.0
    out = np.zeros(len(lags))
    for i in range(n):
        u = abs(r[i]) / sd
        a += u > 3
        b += u > 4
        c += u < 0.5
        most = max(most, u)
    for k in range(len(lags)):
        acc = 0.0
        for i in range(n - lags[k]):
            acc += r[i] * r[i + lags[k]]
        out[k] = acc / n / sd**2
    return a / n, b / n, c / n, most, out


#: Distances in samples at which these are compared.
LAGS = np.array([1, 2, 3, 5, 8, 13, 25, 50])


def battery(x: Array, fs: float, temperature: Array | None = None) -> dict[str, Array]:
    """Statistics by domain: name of the domain -> ndarray. `x` has shape (n,), no NaN."""
    x = np.asarray(x, float)
    x = x - x.mean()
    level, energy, fast = _fast_part(x, fs)
    return {
        **_spectrum(x),
        "allan": _allan(x),
        **fast,
        "mean": _means(level),
        "variance": _energies(energy),
        "temperature": _against(x, temperature),
    }


def _spectrum(x: Array) -> dict[str, Array]:
    """Logarithms of the mean power in bands, and of the largest ordinate over it in the wide
    ones.
    """
    taper, edge = _window(len(x))
    z = rfft(x.astype(np.float32) * taper)
    p = z.real**2 + z.imag**2
    size = np.diff(edge)
    mean = np.add.reduceat(p[: edge[-1]], edge[:-1]) / size
    peak = np.maximum.reduceat(p[: edge[-1]], edge[:-1])
    wide = size > 40
    return {
        "psd": np.log(mean + 1e-30 * mean.max()),
        "lines": np.log(peak[wide] / mean[wide]) if wide.any() else np.zeros(0),
    }


def _allan(x: Array) -> np.ndarray:
    """Logarithms of the Allan variances of block sums, from the cumulative sum."""
    n = len(x)
    c = np.concatenate([[0.0], np.cumsum(x)])
    spans = 3 ** np.arange(np.floor(np.log(max(n // 9, 1)) / np.log(3) + 1e-9) + 1).astype(int)
    return np.log(np.array([_avar(c, m, max(1, m // 4)) for m in spans]) + 1e-300)


def _fast_part(x: Array, fs: float) -> tuple[Array, Array, dict[str, Array]]:
    """Means of blocks of two seconds, mean squares about them, and what the deviations say."""
    n, b = len(x), max(2, int(BLOCK * fs))
    level, energy, r, third, fourth, same, tops, bottoms = _pass(x, b)
    var = energy.mean()
    sd = np.sqrt(var)
    far, farther, core, most, products = _shape(r, sd, LAGS)
    shape = np.array(
        [
            third / (var * sd),
            np.log(fourth / var**2),
            np.log(far + 1 / n),
            np.log(farther + 1 / n),
            np.log(most),
            np.log(same + 20 / n),
            np.log(core + 1 / n),
            float(tops >= 3) + float(bottoms >= 3),
        ]
    )
    return level, energy, {"autocorrelation": products, "distribution": shape}


def _means(level: Array) -> np.ndarray:
    """Slope, beginning, steepest and largest jump and spread of the means of blocks, over their
    scatter.
    """
    k = len(level)
    t = np.linspace(-1, 1, k)
    scatter = np.std(np.diff(level)) / np.sqrt(2)
    return np.array(
        [
            np.mean(level * t) * 3 / scatter,
            (level[: max(1, k // 20)].mean() - level.mean()) / scatter,
            np.log(np.abs(np.diff(level)).max() / scatter),
            np.log(_largest_jump(level) / scatter),
            np.log(np.std(level) / scatter),
        ]
    )


def _energies(e: Array) -> np.ndarray:
    """Scatter and largest of the mean squares over spans of some lengths, and of the halves."""
    k, values = len(e), []
    for join in JOINED:
        g = k // join
        if g >= 6:
            v = e[: g * join].reshape(g, join).mean(axis=1)
            values += [np.log(np.std(v) / v.mean()), np.log(v.max() / v.mean())]
    half = k // 2
    return np.array([*values, np.log(e[:half].mean() / e[half:].mean())])


def _against(x: Array, temperature: Array | None) -> np.ndarray:
    """Correlations with the temperature, of levels and of changes."""
    if temperature is None or not np.ptp(temperature) > 0:
        return np.zeros(0)
    q = max(1, len(x) // 400)
    g = len(x) // q
    a, h = (v[: g * q].reshape(g, q).mean(axis=1) for v in (x, temperature))
    h = h - h.mean()
    d, dh = np.diff(a), np.diff(h)
    return np.array(
        [
            np.dot(a, h) / np.sqrt(np.dot(h, h) * np.dot(a, a)),
            np.dot(d, dh) / np.sqrt(np.dot(dh, dh) * np.dot(d, d)),
        ]
    )


def _largest_jump(level: Array) -> float:
    """The largest difference of means on the two sides of any instant, each over a tenth of the
    record.
    """
    k = len(level)
    w = max(2, k // 10)
    c = np.concatenate([[0.0], np.cumsum(level)])
    i = np.arange(w, k - w + 1)
    return float(np.abs(c[i + w] - 2 * c[i] + c[i - w]).max() / w) if len(i) else 1e-12


def stack(rows: list[dict[str, Array]]) -> dict[str, Array]:
    """Batteries of many simulations: domain -> ndarray, shape (simulations, statistics)."""
    return {d: np.array([r[d] for r in rows]) for d in rows[0]}
