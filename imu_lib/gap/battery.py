"""The battery: one set of statistics, computed the same way on the measurement and on every simulation.

They are of the raw output, electronics and all. Each is on a scale on which simulations scatter about
normally (logarithms of powers), so that standardising by their scatter makes them comparable.
"""
from __future__ import annotations

import numpy as np
from scipy.fft import rfft

DOMAINS = ("psd", "lines", "allan", "autocorrelation", "distribution", "mean", "variance", "temperature")


def battery(x, fs: float, temperature=None) -> dict:
    """Statistics by domain: name of the domain -> ndarray. `x` has shape (n,), no NaN."""
    n = len(x)
    x = np.asarray(x, float)
    x = x - x.mean()
    out = {}
    y = x.astype(np.float32)
    taper = np.hanning(n).astype(np.float32) * np.float32(np.sqrt(8 / 3))
    p = np.abs(rfft(y * taper)) ** 2
    edges = np.unique(np.round(np.geomspace(3, len(p) - 2, 33)).astype(int))
    mean = np.add.reduceat(p[:edges[-1]], edges[:-1]) / np.diff(edges)
    out["psd"] = np.log(mean + 1e-30 * mean.max())
    size = np.diff(edges)
    peak = np.maximum.reduceat(p[:edges[-1]], edges[:-1])
    wide = size > 40
    out["lines"] = np.log(peak[wide] / mean[wide]) if wide.any() else np.zeros(0)
    # Allan variances of block sums, from the cumulative sum
    c = np.concatenate([[0.0], np.cumsum(x)])
    out["allan"] = []
    m = 1
    while m <= n // 9:
        step = max(1, m // 4)
        s = c[2 * m::step][: (n - 2 * m) // step + 1] - 2 * c[m:-m:step][: (n - 2 * m) // step + 1] + c[:-2 * m:step][: (n - 2 * m) // step + 1]
        out["allan"].append(np.log(np.mean(s * s) / m**2 + 1e-300))
        m *= 3
    out["allan"] = np.array(out["allan"])
    # the fast part: block-wise deviations over two seconds
    b = max(2, int(2 * fs))
    k = n // b
    blocks = x[:k * b].reshape(k, b)
    level = blocks.mean(axis=1)
    r = (blocks - level[:, None]).ravel()
    var = np.mean(r * r)
    sd = np.sqrt(var)
    out["autocorrelation"] = np.array([np.dot(r[:-lag], r[lag:]) / (len(r) * var) for lag in (1, 2, 3, 5, 8, 13, 25, 50)])
    u = np.abs(r) / sd
    same = np.mean(np.diff(x) == 0.0)
    top = np.sort(np.partition(x, (2, n - 3))[[0, 1, 2, n - 3, n - 2, n - 1]])
    out["distribution"] = np.array([np.mean(r**3) / (var * sd), np.log(np.mean(u**4)), np.log(np.mean(u > 3) + 1 / n), np.log(np.mean(u > 4) + 1 / n),
                                    np.log(u.max()), np.log(same + 1 / n), np.log(np.mean(u < 0.5)),
                                    float(top[5] == top[3]) + float(top[0] == top[2])])
    t = np.linspace(-1, 1, k)
    scatter = np.std(np.diff(level)) / np.sqrt(2)
    jump = _largest_jump(level)
    out["mean"] = np.array([np.mean(level * t) * 3 / scatter, (level[:max(1, k // 20)].mean() - level.mean()) / scatter,
                            np.log(np.abs(np.diff(level)).max() / scatter), np.log(jump / scatter), np.log(np.std(level) / scatter)])
    square = (r * r).reshape(k, b)
    e = square.mean(axis=1)
    values = []
    for join in (1, 5, 15, 75):
        g = k // join
        if g >= 6:
            v = e[:g * join].reshape(g, join).mean(axis=1)
            values += [np.log(np.std(v) / v.mean()), np.log(v.max() / v.mean())]
    half = k // 2
    out["variance"] = np.array(values + [np.log(e[:half].mean() / e[half:].mean())])
    if temperature is not None and np.ptp(temperature) > 0:
        q = max(1, n // 400)
        g = n // q
        a = x[:g * q].reshape(g, q).mean(axis=1)
        h = temperature[:g * q].reshape(g, q).mean(axis=1)
        h = h - h.mean()
        d, dh = np.diff(a), np.diff(h)
        out["temperature"] = np.array([np.dot(a, h) / np.sqrt(np.dot(h, h) * np.dot(a, a)), np.dot(d, dh) / np.sqrt(np.dot(dh, dh) * np.dot(d, d))])
    else:
        out["temperature"] = np.zeros(0)
    return out


def _largest_jump(level):
    """The largest difference of means on the two sides of any instant, each over a tenth of the record."""
    k = len(level)
    w = max(2, k // 10)
    c = np.concatenate([[0.0], np.cumsum(level)])
    i = np.arange(w, k - w + 1)
    return float(np.abs(c[i + w] - 2 * c[i] + c[i - w]).max() / w) if len(i) else 1e-12


def stack(rows: list[dict]) -> dict:
    """Batteries of many simulations: domain -> ndarray, shape (simulations, statistics)."""
    return {d: np.array([r[d] for r in rows]) for d in rows[0]}
