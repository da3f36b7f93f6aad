"""Samples drawn anew given the others, under the spectrum of the record: missing ones, and those
that are known to lie beyond a limit.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, rfft

from imu_lib.arrays import Array
from imu_lib.likelihood.tapered import bridge
from imu_lib.samples import clipped
from imu_lib.samples.innovations import Smooth, padded_size

#: Standard deviations by which the means of a stretch and of one twice as long may differ before
#: the level is not the same all along.
STEADY = 3.0


def first_fill(x: Array, bad: Array) -> np.ndarray:
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


def _level(x: Array, bad: Array) -> Array:
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
    at = np.flatnonzero(full)
    mean = _beside_holes(at, total[at] / count[at], k)
    return np.interp(np.arange(len(x)), (at + 0.5) * m, mean)


def _beside_holes(at: Array, mean: Array, blocks: int) -> np.ndarray:
    """The `mean` of each of the blocks `at` which there is one, those next to a hole from as many
    blocks as it lacks: the noise of a single one would be a jump as long as the hole.
    """
    out = np.array(mean, float)
    if len(mean) < 4:
        return out
    noise = 1.4826 * float(np.median(np.abs(np.diff(mean)))) / np.sqrt(2.0)
    lacking = np.diff(np.r_[-1, at, blocks]) - 1
    for i in np.flatnonzero(lacking > 1):
        if i > 0:
            out[i - 1] = _steady(mean[:i][::-1], lacking[i], noise)
        if i < len(mean):
            out[i] = _steady(mean[i:], lacking[i], noise)
    return out


def _steady(mean: Array, most: int, noise: float) -> float:
    """Mean of the first blocks, of as many up to `most` as differ by no more than their `noise`."""
    r = 1
    while 2 * r <= min(most, len(mean)):
        off = abs(float(mean[:r].mean() - mean[: 2 * r].mean()))
        if off >= STEADY * noise / np.sqrt(2.0 * r):
            break
        r *= 2
    return float(mean[:r].mean())


def impute(
    x: Array,
    bad: Array,
    smooth: Smooth,
    rng: np.random.Generator,
    *,
    above: tuple[Array, float] | None = None,
    below: tuple[Array, float] | None = None,
    before: Array | None = None,
    iterations: int = 40,
) -> np.ndarray:
    """Bad samples drawn from their distribution given the good ones under the spectrum
    (conditional simulation).

    `above` and `below` are (mask, limit): samples known only to lie beyond a limit; `before` (n,)
    is what was drawn for them under another spectrum.
    """
    sides = [
        clipped.Side(*side, sign)
        for side, sign in ((above, 1.0), (below, -1.0))
        if side is not None and side[0].any()
    ]
    on_rail = np.logical_or.reduce([np.zeros(len(x), bool), *(side.mask for side in sides)])
    bad = bad & ~on_rail
    out = first_fill(x, bad)
    if not (bad.any() or sides):
        return out
    if sides:
        out = clipped.started(out, sides, rng) if before is None else np.where(on_rail, before, out)
    coupled = smooth.traces > clipped.COUPLED
    base = bridge(out)
    size = padded_size(len(x))
    density = smooth.slow_too(size) * smooth.fs / 2
    inverse = 1.0 / density
    wrong = bad | on_rail if coupled and before is None else bad
    if wrong.any():
        draw = irfft(rfft(rng.standard_normal(size)) * np.sqrt(density), size)[: len(x)]
        residual = out - base - draw
        residual[wrong] = 0.0
        out[wrong] = (base + draw)[wrong] + _mean_given(residual, wrong, inverse, iterations)
    if sides:
        clipped.draw(out, base, inverse, sides, rng, coupled=coupled)
    return out


def _mean_given(residual: Array, bad: Array, inverse: Array, iterations: int) -> np.ndarray:
    """Mean of the bad samples given the good ones (0 where they are bad) by conjugate gradients."""
    wrong = np.flatnonzero(bad)

    def apply(v: Array) -> Array:
        full = np.zeros(len(residual))
        full[wrong] = v
        return clipped.pull(full, inverse)[wrong]

    b = -clipped.pull(residual, inverse)[wrong]
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
