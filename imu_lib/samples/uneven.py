"""A converter whose steps are not equally wide: how its levels are occupied tells where each step
is (the code-density test, IEEE Std 1241), and what the unevenness adds to the noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from imu_lib.arrays import Array

#: Samples on a level from which on its width is told, and levels of that kind at the least;
#: samples below which a code between them is missing.
MANY, LEVELS, FEW = 200, 5, 20
#: Order of the smooth density in its logarithm, and points of it a step.
ORDER, POINTS = 4, 40
#: Samples to whose mean the slow part of the signal is taken.
BLOCK = 32
#: By how much the widths scatter before they are uneven, in steps and in what the counts scatter;
#: beyond the most it is another grid.
UNEVEN, CHANCE, MOST = 0.06, 4.0, 0.7


@dataclass(frozen=True)
class Uneven:
    """Steps of a converter that are not equally wide.

    Attributes
    ----------
    edges : ndarray, shape (k,)
        Between the levels of the grid, in steps from the first level.
    first : int
        Number of the first level, counted in steps from 0 of the grid.
    scatter : float
        Standard deviation of the widths, in steps.
    variance : float
        Of what the rounding adds to a sample, in squared steps.
    """

    edges: np.ndarray
    first: int
    scatter: float
    variance: float

    def rounded(self, u: Array) -> np.ndarray:
        """Numbers of the levels for a signal `u` in steps."""
        return self.first + np.searchsorted(self.edges, u - self.first)


def uneven(x: Array, step: float, offset: float) -> Uneven | None:
    """The steps behind samples `x`, shape (n,), on an even grid; None where they are even, or
    where a code is missing.
    """
    k = np.rint((x - offset) / step).astype(np.int64)
    first = int(k.min())
    if k.max() - first > 20_000:
        return None
    count = np.bincount(k - first).astype(float)
    if len(count) < LEVELS:
        return None
    # what a limited range piles up at its end says nothing of the last step
    piled = int(count[0] > count[1]), int(count[-1] > count[-2])
    count = count[piled[0] : len(count) - piled[1]]
    often = np.flatnonzero(count >= MANY)
    if len(often) < LEVELS:
        return None
    seen = np.arange(often[0], often[-1] + 1)
    if count[seen].min() < FEW:  # a code that hardly occurs among those that do
        return None
    density, fine = _density(count, seen, piled, (x - offset) / step - first - piled[0])
    between = np.cumsum(density) / np.sum(density)
    edges = np.interp(np.cumsum(count)[:-1] / count.sum(), between, fine)
    level = np.searchsorted(edges, fine)
    # a gain or an offset of its own is no error, and would change the noise before the rounding
    line = np.polyfit(fine, level, 1, w=np.sqrt(density))
    edges, fine = np.polyval(line, edges), np.polyval(line, fine)
    width = np.diff(edges)[seen[0] : seen[-1] - 1]
    chance = float(np.mean(1.0 / np.sqrt(count[seen])))
    scatter = float(np.std(width))
    if not max(UNEVEN, CHANCE * chance) < scatter < MOST:
        return None
    variance = float(np.average((level - fine) ** 2, weights=density))
    ends = [-0.5] * piled[0], [len(count) - 0.5] * piled[1]
    edges = np.concatenate([ends[0], edges, ends[1]]) + piled[0]
    return Uneven(edges, first, scatter, variance)


def _density(count: Array, seen: Array, piled: tuple[int, int], u: Array) -> tuple[Array, Array]:
    """The smooth density behind the counts of the levels, and the places, in steps, at which it
    is; at an end at which the range is limited (`piled`) it ends with the last level. `u` are the
    samples in steps from the first level.

    It is that of the fast noise about the slow part of the signal, which may dwell at several
    levels, corrected by a polynomial for what the noise has that a normal one has not.
    """
    at = np.arange(len(count))
    middle, size = at[seen].mean(), max(np.ptp(at[seen]) / 2.0, 1.0)
    ends = (piled[0] - 1) * POINTS, (len(count) + 1 - piled[1]) * POINTS
    fine = (np.arange(*ends) + 0.5) / POINTS - 0.5
    about = np.log(_about_means(u, fine))
    order = min(ORDER, len(seen) - 2)
    rest = np.log(count[seen]) - np.interp(at[seen], fine, about)
    fit = np.polyfit((at[seen] - middle) / size, rest, order, w=np.sqrt(count[seen]))
    # beyond the levels that tell it falls off as the fast noise does
    log = about + np.polyval(fit, np.clip((fine - middle) / size, -1.0, 1.0))
    return np.exp(log - log.max()), fine


def _about_means(u: Array, fine: Array) -> Array:
    """Density at the places `fine` (even) of normal noise about the means of blocks of `u`."""
    blocks = u[: len(u) // BLOCK * BLOCK].reshape(-1, BLOCK)
    mean = blocks.mean(axis=1)
    sd = np.sqrt(max(np.median(np.var(blocks, axis=1)), 1 / 12))  # a jump lies in few blocks
    cell = fine[1] - fine[0]
    edges = np.append(fine - cell / 2, fine[-1] + cell / 2)
    many = np.histogram(np.clip(mean, fine[0], fine[-1]), edges)[0]
    # the floor keeps the logarithm where no sample lies
    return gaussian_filter1d(many / many.sum(), sd / cell, mode="constant", truncate=8.0) + 1e-12
