"""Samples that are known only to lie beyond a limit: drawn from what the others leave open there.

Good samples of a clipped signal lie on one side of what was cut off: their mean and their scatter
are not the signal's. Both are found together with the clipped samples (a censored normal, Tobin
1958), first for themselves, then under the spectrum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import ndtr, ndtri

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.samples.innovations import trend

#: Samples that one which is thrown off makes surprising from which on clipped ones are drawn
#: together, how often, and how often each for itself.
COUPLED, SWEEPS, APART = 1.5, 24, 8
#: Samples of the longest run that is drawn as one.
LONGEST = 40
#: Rounds of the censored normal, and samples of a block whose level it has at the least, blocks at
#: the most.
ROUNDS, BLOCK, BLOCKS = 40, 400, 100


@dataclass(frozen=True)
class Side:
    """Samples (`mask`) that are known only to lie beyond a `limit`: above it (`sign` 1) or below it
    (-1).
    """

    mask: np.ndarray
    limit: float
    sign: float

    def beyond(self, x: Array) -> Array:
        """How far beyond the limit samples are; less than 0 where they are short of it."""
        return self.sign * (x - self.limit)


def started(x: Array, sides: Sequence[Side], rng: np.random.Generator) -> np.ndarray:
    """`x` (n,) with its clipped samples drawn from the normal distribution of all samples about the
    level of their surroundings, beyond the limit.
    """
    out = np.array(x, float)
    size = min(max(BLOCK, len(x) // BLOCKS), len(x))
    for _ in range(ROUNDS):
        level = trend(out, size)
        sd = float(np.std(out - level))
        for side in sides:
            out[side.mask] = _cut_normal(level[side.mask], sd, side, rng)
    return out


def draw(
    out: Array,
    base: Array,
    inverse: Array,
    sides: Sequence[Side],
    rng: np.random.Generator,
    *,
    coupled: bool,
) -> None:
    """Clipped samples of `out` drawn anew in place, given all others under the spectrum of which
    `inverse` is the inverse, about `base`; run by run where they are `coupled`.
    """
    precision = irfft(inverse, 2 * (len(inverse) - 1))[:LONGEST]
    runs = [_runs(side.mask) for side in sides]
    for k in range(SWEEPS if coupled else APART):
        for side, (first, length) in zip(sides, runs):
            lean = pull(out - base, inverse)
            if coupled:
                some = first[k % 2 :: 2], length[k % 2 :: 2]
                _redraw(out, lean, precision, some, side, rng)
            else:
                at = np.flatnonzero(side.mask)[k % 2 :: 2]
                middle = out[at] - lean[at] / precision[0]
                out[at] = _cut_normal(middle, 1 / np.sqrt(precision[0]), side, rng)


def pull(x: Array, inverse: Array) -> Array:
    """A series times the inverse covariance of noise whose inverse spectrum is given at the
    ordinates of a longer transform, shape of `x`.
    """
    return irfft(rfft(x, 2 * (len(inverse) - 1)) * inverse)[: len(x)]


def _runs(mask: Array) -> tuple[Array, Array]:
    """First samples and lengths of the runs in a mask."""
    start, stop = timing.runs(mask)
    return start, stop - start


def _redraw(
    out: Array,
    lean: Array,
    precision: Array,
    runs: tuple[Array, Array],
    side: Side,
    rng: np.random.Generator,
    *,
    draws: int = 64,
) -> None:
    """Runs (first samples, lengths) of clipped samples drawn together, in place, given all samples
    outside of each and that it lies beyond the limit.

    `lean` is what the inverse covariance, of which `precision` is the first row, makes of `out`.
    """
    first, length = runs
    for size in np.unique(length):
        at = first[length == size][:, None] + np.arange(size)
        if size > len(precision):  # a level of its own
            out[at] = np.where(side.beyond(out[at]) < 0, side.limit, out[at])
            continue
        own = precision[np.abs(np.subtract.outer(np.arange(size), np.arange(size)))]
        cov = np.linalg.inv(own)
        middle = out[at] - lean[at] @ cov
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


def _cut_normal(middle: Array, sd: float, side: Side, rng: np.random.Generator) -> Array:
    """Normal numbers about `middle`, shape (n,), of standard deviation `sd`, that lie beyond the
    limit.
    """
    a = -side.beyond(middle) / sd
    tail = ndtr(-a)
    z = np.where(tail > 1e-12, -ndtri(np.maximum(rng.random(len(middle)) * tail, 1e-300)), a)
    return np.where(z < a, side.limit, middle + side.sign * sd * z)
