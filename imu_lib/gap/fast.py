"""The fast end: the tapered periodogram, averaged into narrow bins, and its gamma likelihood.

Above the Nyquist frequency of the block means the ordinates of the periodogram are independent
chi-squares with two degrees of freedom around the spectrum; averaging them over bins 3.5 % wide
loses nothing that a smooth spectrum could show.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import next_fast_len, rfft

#: Gauss-Legendre nodes and weights over a bin, where the spectrum may be steep.
_NODES = np.array([-0.7745966692414834, 0.0, 0.7745966692414834])
_WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0


@dataclass(frozen=True, eq=False)
class Bins:
    """Bins of the periodogram of `n` samples: `edge` (k + 1,) ordinate numbers, `f` (k,) centres
    Hz, `nu` (k,) degrees of
    freedom, `nodes` (k, 3) Hz where a spectrum is evaluated; `slow` of them lie below the Nyquist
    frequency of the blocks.
    """

    edge: np.ndarray
    f: np.ndarray
    nu: np.ndarray
    nodes: np.ndarray
    slow: int
    samples: int


@lru_cache(maxsize=8)
def taper(n: int) -> np.ndarray:
    """Cosine taper over 1 % at either end, mean square 1."""
    w = np.ones(n)
    k = max(2, n // 100)
    ramp = 0.5 - 0.5 * np.cos(np.pi * (np.arange(k) + 0.5) / k)
    w[:k], w[-k:] = ramp, ramp[::-1]
    w /= np.sqrt(np.mean(w**2))
    w.setflags(write=False)
    return w


def efficiency(n: int) -> float:
    """Independent ordinates of the tapered and padded transform of `n` samples per ordinate."""
    return float(1.0 / np.mean(taper(n) ** 4) * n / padded(n))


@lru_cache(maxsize=8)
def bins(n: int, fs: float, m: int) -> Bins:
    """Bins for `n` samples at `fs` Hz with blocks of `m` samples."""
    size = padded(n)
    top = size // 2
    cut = max(3, int(np.ceil(size / (2 * m))))
    low = np.unique(np.round(np.geomspace(1, cut, 30)).astype(int))
    high = np.unique(np.round(cut * 2.0 ** (np.arange(0, np.log2(top / cut), 0.05))).astype(int))
    edge = np.unique(np.concatenate([low[:-1], high, [top]]))
    left, right = (edge[:-1] - 0.5) * fs / size, (edge[1:] - 0.5) * fs / size
    middle, half = (left + right) / 2, (right - left) / 2
    nodes = middle[:, None] + half[:, None] * _NODES
    return Bins(
        edge, middle, 2.0 * np.diff(edge) * efficiency(n), nodes, int(np.searchsorted(edge, cut)), n
    )


@lru_cache(maxsize=32)
def padded(n: int) -> int:
    """Length of the transform: little more than `n`, with small factors, even."""
    size = next_fast_len(n, real=True)
    return size if size % 2 == 0 else next_fast_len(n + 1 + n % 2, real=True) // 2 * 2


def transform(x) -> np.ndarray:
    """Transform of the tapered record whose mean square modulus is the one-sided density in
    unit^2/Hz times fs.
    """
    n = len(x)
    return rfft(taper(n) * (x - _bridge(x)), padded(n)) * np.sqrt(2.0 / n)


def _bridge(x):
    """The straight line between the means of the first and the last tenth."""
    n = len(x)
    k = max(1, n // 10)
    a, b = x[:k].mean(), x[-k:].mean()
    slope = (b - a) / max(n - k, 1)
    return a + slope * (np.arange(n) - (k - 1) / 2)


def average(power, layout: Bins) -> np.ndarray:
    """Means of the ordinates in the bins."""
    return np.add.reduceat(power[: layout.edge[-1]], layout.edge[:-1]) / np.diff(layout.edge)


@lru_cache(maxsize=64)
def _images(low_pass, layout: Bins, fs: float):
    """Frequencies that the sampling folds onto the nodes of the bins, shape (images, bins, 3), the
    filter's gain there, and its rate.
    """
    ratio = low_pass.ratio(fs)
    f = np.mod(layout.nodes + fs * np.arange(ratio)[:, None, None], ratio * fs)
    f = np.minimum(f, ratio * fs - f)
    return f, low_pass.gain(f, fs), ratio * fs


def spectrum(terms, low_pass, layout: Bins, fs: float) -> np.ndarray:
    """Model spectrum in the bins, one-sided, unit^2/Hz: terms, then filter."""
    s = np.zeros(layout.nodes.shape)
    for term in terms:
        # what channels have in common may be added behind their filters, and so are the errors of
        # a rounded integral
        behind = term.name == "common_mode" and not term.filtered or getattr(term, "rounded", None)
        if low_pass is None or behind:
            s += term.psd(layout.nodes, fs)
        else:
            f, gain, rate = _images(low_pass, layout, fs)
            s += np.sum(gain * term.psd(f, rate), axis=0)
    return s @ _WEIGHTS
