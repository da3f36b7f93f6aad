"""Samples drawn anew given the others, under the spectrum of the record: missing ones, and those
that are known to lie beyond a limit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import ndtr, ndtri

from imu_lib.gap.innovations import Smooth, padded_size
from imu_lib.likelihood.tapered import bridge

#: Samples that one which is thrown off makes surprising from which on clipped ones are drawn
#: together, and how often.
COUPLED, SWEEPS = 1.5, 24
#: Samples of the longest run that is.
LONGEST = 40


def first_fill(x, bad) -> np.ndarray:
    """Bad samples replaced by the straight line between good ones plus what good samples deviate
    from it elsewhere.
    """
    out = np.array(x, float)
    good = np.flatnonzero(~bad)
    wrong = np.flatnonzero(bad)
    if len(wrong) == 0:
        return out
    level = _level(x, bad)
    source = good[(np.arange(len(wrong)) + len(good) // 3) % len(good)]
    out[wrong] = level[wrong] + x[source] - level[source]
    return out


def _level(x, bad):
    """The level from the good samples of each of some 2000 blocks, straight lines across blocks
    that have too few of them.
    """
    m = max(8, len(x) // 2000)
    k = len(x) // m
    ok = ~bad[: k * m].reshape(k, m)
    count = ok.sum(axis=1)
    total = np.where(ok, np.where(bad, 0.0, x)[: k * m].reshape(k, m), 0.0).sum(axis=1)
    full = count >= max(1, m // 4)
    if not full.any():
        full = count > 0
    return np.interp(np.arange(len(x)), (np.arange(k) + 0.5)[full] * m, total[full] / count[full])


@dataclass(frozen=True)
class _Side:
    """Samples (`mask`) that are known only to lie beyond a `limit`: above it (`sign` 1) or below it
    (-1).
    """

    mask: np.ndarray
    limit: float
    sign: float

    def beyond(self, x):
        """How far beyond the limit samples are; less than 0 where they are short of it."""
        return self.sign * (x - self.limit)


def impute(
    x, bad, smooth: Smooth, rng, *, above=None, below=None, iterations: int = 40
) -> np.ndarray:
    """Bad samples drawn from their distribution given the good ones under the spectrum
    (conditional simulation).

    `above` and `below` are (mask, limit): samples known only to lie beyond a limit.
    """
    sides = [
        _Side(*side, sign)
        for side, sign in ((above, 1.0), (below, -1.0))
        if side is not None and side[0].any()
    ]
    bad = np.logical_or.reduce([bad, *(side.mask for side in sides)])
    wrong = np.flatnonzero(bad)
    out = np.array(x, float)
    if len(wrong) == 0:
        return out
    out[wrong] = first_fill(x, bad)[wrong]
    base = bridge(out)
    size = padded_size(len(x))
    density = smooth.slow_too(size) * smooth.fs / 2
    inverse = 1.0 / density
    draw = irfft(rfft(rng.standard_normal(size)) * np.sqrt(density), size)[: len(x)]
    residual = out - base - draw
    residual[wrong] = 0.0
    v = _mean_given(residual, bad, inverse, iterations)
    out[wrong] = base[wrong] + draw[wrong] + v
    short = np.zeros(len(x), bool)
    for side in sides:
        short |= side.mask & (side.beyond(out) < 0)
    if not short.any():
        return out
    if smooth.traces > COUPLED:
        _drawn_together(out, base, inverse, sides, rng)
        return out
    sd = np.sqrt(smooth.conditional_variance)
    for side in sides:
        # given its neighbours a clipped sample is normal around their forecast, cut at the limit
        at = np.flatnonzero(side.mask & short)
        middle = base[at] + v[np.searchsorted(wrong, at)] + draw[at] - _own(draw, smooth, size, at)
        out[at] = _cut_normal(middle, sd, side, rng)
    return out


def _mean_given(residual, bad, inverse, iterations: int) -> np.ndarray:
    """Mean of the bad samples given the good ones (0 where they are bad) by conjugate gradients."""
    wrong = np.flatnonzero(bad)

    def apply(v):
        full = np.zeros(len(residual))
        full[wrong] = v
        return _pull(full, inverse)[wrong]

    b = -_pull(residual, inverse)[wrong]
    # gradients find the mean of a long gap last: start from the level around it
    v = _level(residual, bad)[wrong]
    r = b - apply(v)
    p, rr = r.copy(), r @ r
    stop = 1e-8 * float(b @ b)
    for _ in range(iterations):
        if rr <= stop:
            break
        ap = apply(p)
        alpha = rr / (p @ ap)
        v += alpha * p
        r -= alpha * ap
        new = r @ r
        p, rr = r + new / rr * p, new
    return v


def _drawn_together(out, base, inverse, sides: list[_Side], rng):
    """Clipped samples drawn anew in place, run by run, in turns."""
    precision = irfft(inverse, 2 * (len(inverse) - 1))[:LONGEST]
    runs = [_runs(side.mask) for side in sides]
    for k in range(SWEEPS):
        for side, (first, length) in zip(sides, runs):
            some = first[k % 2 :: 2], length[k % 2 :: 2]
            _redraw(out, _pull(out - base, inverse), precision, some, side, rng)


def _pull(x, inverse):
    """A series times the inverse covariance of noise whose inverse spectrum is given at the
    ordinates of a longer transform, shape of `x`.
    """
    return irfft(rfft(x, 2 * (len(inverse) - 1)) * inverse)[: len(x)]


def _runs(mask):
    """First samples and lengths of the runs in a mask."""
    edge = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return edge[::2], np.diff(edge)[::2]


def _redraw(out, pull, precision, runs, side: _Side, rng, *, draws: int = 64):
    """Runs (first samples, lengths) of clipped samples drawn together, in place, given all samples
    outside of each and that it lies beyond the limit.

    `pull` is what the inverse covariance, of which `precision` is the first row, makes of `out`.
    """
    first, length = runs
    for size in np.unique(length):
        at = first[length == size][:, None] + np.arange(size)
        if size > len(precision):  # a level of its own
            out[at] = np.where(side.beyond(out[at]) < 0, side.limit, out[at])
            continue
        own = precision[np.abs(np.subtract.outer(np.arange(size), np.arange(size)))]
        cov = np.linalg.inv(own)
        middle = out[at] - pull[at] @ cov
        root = np.linalg.cholesky(0.5 * (cov + cov.T))
        trial = middle + rng.standard_normal((draws, *at.shape)) @ root.T
        over = np.min(side.beyond(trial), axis=2)  # shape (draws, runs)
        new = trial[np.argmax(over >= 0, axis=0), np.arange(len(at))]
        none = ~(over >= 0).any(axis=0)
        if none.any():  # one sample after the other, many times
            part = np.where(side.beyond(new[none]) < 0, side.limit, new[none])
            for _ in range(60):
                for j in range(size):
                    centre = part[:, j] - (part - middle[none]) @ own[j] / own[j, j]
                    part[:, j] = _cut_normal(centre, 1 / np.sqrt(own[j, j]), side, rng)
            new[none] = part
        out[at] = new


def _cut_normal(middle, sd, side: _Side, rng):
    """Normal numbers about `middle`, shape (n,), of standard deviation `sd`, that lie beyond the
    limit.
    """
    a = -side.beyond(middle) / sd
    tail = ndtr(-a)
    z = np.where(tail > 1e-12, -ndtri(np.maximum(rng.random(len(middle)) * tail, 1e-300)), a)
    return np.where(z < a, side.limit, middle + side.sign * sd * z)


def _own(draw, smooth, size, at):
    """What each drawn sample adds to the forecast from its neighbours."""
    inverse = 1.0 / (smooth.on(size) * smooth.fs / 2)
    return _pull(draw, inverse)[at] / np.mean(inverse)
