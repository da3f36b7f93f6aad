"""Samples that are thrown off in coloured noise: which they are, where the surprises of their
neighbours are of their making.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft
from scipy.ndimage import maximum_filter1d
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

from imu_lib.arrays import Array
from imu_lib.samples.innovations import Smooth

#: Samples thrown off so near each other are looked at together.
CLOSE = 6
#: Share of the least squared height by which one sample must explain more than another to be the
#: one that is off.
ALIKE = 0.36


def spike_odds(y: Array, p: float, scale: float) -> np.ndarray:
    """Log odds of each sample, in standard deviations (n,), for being a spike: of probability `p`
    and normal height of standard deviation `scale` on normal noise.
    """
    own = np.log(p / (1 - p)) - 0.5 * np.log1p(scale**2)
    return own + 0.5 * y**2 * scale**2 / (1 + scale**2)


def deconvolved(
    y: Array, smooth: Smooth, *, least: float = 5.0, reach: int = 256, rounds: int = 10
) -> tuple[np.ndarray, np.ndarray]:
    """Surprises of which each stands for its own sample alone, shape (n,), and the samples that may
    be off in place of another, mask (n,).

    In coloured noise a sample that is thrown off makes its neighbours surprising, too, as the
    correlation of the surprises says. The heights of those beyond `least` are estimated together,
    the strongest first, and the rest is freed of them.
    """
    size = 4096
    response = irfft(1.0 / smooth.on(size), size)[: reach + 1]
    response = response / response[0]
    both = np.concatenate([response[:0:-1], response])
    # in a stop band that the spectrum's floor hides the surprises are smaller than they were
    # thought
    least = least * min(1.0, loudest(y))
    padded, rest, at = np.pad(y, reach), np.array(y, float), np.zeros(0, int)
    heights, near = np.zeros(0), np.zeros(0, int)
    for _ in range(rounds):
        strong = np.abs(rest)
        strong[at] = 0.0
        new = np.flatnonzero(strong > least)
        new = new[strong[new] >= maximum_filter1d(strong, 33)[new]]
        if len(new) == 0:
            break
        at = np.sort(np.concatenate([at, new]))
        if len(at) > len(y) // 20:  # another distribution, not a few samples
            return y, np.zeros(len(y), bool)
        at, near = _settled(y, at, new, near, response, least)
        heights = _heights(y, at, response)
        left = padded.copy()
        for i, h in zip(at, heights):
            left[i : i + 2 * reach + 1] -= h * both
        rest = left[reach:-reach]
    rest[at] = heights
    instead = np.zeros(len(y), bool)
    instead[near] = True
    return rest, instead


def loudest(y: Array, parts: int = 16) -> float:
    """Standard deviation of the surprises, without their outliers, in the part of the record where
    it is largest.
    """
    return max(1.4826 * float(np.median(np.abs(part[::5]))) for part in np.array_split(y, parts))


def _settled(
    y: Array, at: Array, new: Array, near: Array, response: Array, least: float
) -> tuple[Array, Array]:
    """The samples `at`, those about the `new` ones moved to where they explain the most beside
    their neighbours, without those that are then too weak; and `near`, the samples that explain
    nearly as much as one of them."""
    heights = np.zeros(len(y))
    heights[at] = _heights(y, at, response)
    lag, out, instead, fresh = np.arange(-CLOSE, CLOSE + 1), [], [near], set(new.tolist())
    for group in np.split(at, np.flatnonzero(np.diff(at) > 2 * CLOSE) + 1):
        if len(group) > 12 or fresh.isdisjoint(group.tolist()):
            out.append(group)
            continue
        # what the group has to explain: its surroundings without the spikes further off
        here = np.arange(max(0, group[0] - CLOSE), min(len(y), group[-1] + CLOSE + 1))
        beyond = at[
            np.searchsorted(at, group[0] - len(response) // 2) : np.searchsorted(
                at, group[-1] + len(response) // 2
            )
        ]
        beyond = beyond[(beyond < group[0]) | (beyond > group[-1])]
        want = y[here] - response[np.abs(np.subtract.outer(here, beyond))] @ heights[beyond]
        r = response[np.abs(np.subtract.outer(here, here))]
        picks = list(group - here[0])
        for _ in range(4):
            before = list(picks)
            for k in range(len(picks)):
                others = [p for p in picks if p != picks[k]]
                gain = _gains(want, r, others)
                around = picks[k] + lag
                around = around[(around >= 0) & (around < len(here))]
                picks[k] = int(around[np.argmax(gain[around])])
            picks = sorted(set(picks))
            weak = [_gains(want, r, [q for q in picks if q != p])[p] for p in picks]
            if min(weak) < least**2:
                picks.remove(picks[int(np.argmin(weak))])
            if picks == before or not picks:
                break
        out.append(here[np.array(picks, int)])
        for p in picks:
            gain = _gains(want, r, [q for q in picks if q != p])
            instead.append(here[gain > gain[p] - ALIKE * least**2])
    return np.concatenate(out), np.unique(np.concatenate(instead))


def _gains(want: Array, r: Array, others: list[int]) -> Array:
    """Squared surprise of each sample in its standard deviations, given that the `others` are off,
    too.
    """
    if not others:
        return want**2
    part = r[np.ix_(others, others)]
    back = np.linalg.solve(part + 1e-9 * np.eye(len(others)), r[others])
    var = 1.0 - np.sum(r[others] * back, axis=0)
    out = (want - back.T @ want[others]) ** 2 / np.maximum(var, 1e-3)
    out[others] = 0.0
    return out


def _heights(y: Array, at: Array, response: Array) -> Array:
    """What the samples `at` are off, given all others, in standard deviations of one alone."""
    reach = len(response) - 1
    first = np.searchsorted(at, at - reach)
    columns = (
        np.concatenate([np.arange(a, i + 1) for i, a in enumerate(first)])
        if len(at)
        else np.zeros(0, int)
    )
    rows = np.repeat(np.arange(len(at)), np.arange(len(at)) - first + 1)
    values = response[at[rows] - at[columns]]
    off = rows != columns
    matrix = csc_matrix(
        (
            np.concatenate([values, values[off]]),
            (np.concatenate([rows, columns[off]]), np.concatenate([columns, rows[off]])),
        )
    )
    return np.atleast_1d(spsolve(matrix, y[at])) if len(at) else np.zeros(0)
