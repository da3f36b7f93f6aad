"""From when to when a place in the spectrum is louder than its surroundings: once, or on and
off.
"""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.arrays import Array

#: Gain that a beginning and an end have to bring; share of the excess that may be left outside.
TIMED, OUTSIDE = 18.0, 0.3
#: Blocks in which the beginning and the end are sought, and episodes at the most: what goes on and
#: off more often is a signal of its own.
BLOCKS, MOST = 360, 12
#: Blocks that an episode, and a pause between two, have at the least.
SHORTEST = 3
#: Share of the gain of the episodes that what is left between them may have.
STILL = 0.25
#: Share of the excess that half of the time between them has, and its standard deviations, from
#: which on it is there all the time and its amplitude wanders.
FAINT, SURE = 0.02, 5.0


def episodes(power: Array, dof: float, duration: float) -> tuple[tuple[float, float], ...] | None:
    """((from, to), ...) in s where the excess has a beginning or an end, else None.

    Parameters
    ----------
    power : ndarray, shape (n,)
        Of nearly independent samples in a narrow band, 1 where there is nothing but noise.
    dof : float
        Channels that it is the weighted mean of, as far as they count.
    duration : float, s
    """
    size = max(1, len(power) // BLOCKS)
    k = len(power) // size
    if k < 12:
        return None
    e = power[: k * size].reshape(k, size).mean(axis=1)
    dof = size * dof
    once, several = _once(e, dof), _several(e, dof)
    best = once
    if several is not None and several[0] > (once[0] if once else 0.0) + TIMED * (
        len(several[1]) - 1
    ):
        best = several
    if best is None:
        return None
    step = duration * size / len(power)
    return tuple(
        (float(i * step if i > 1 else 0.0), float(j * step if j < k - 1 else duration))
        for i, j in best[1]
    )


def _once(e: Array, dof: float) -> tuple[float, list[tuple[int, int]]] | None:
    """(gain, [(first, behind the last block)]) of the likeliest single episode, or None."""
    k = len(e)
    c = np.concatenate([[0.0], np.cumsum(e)])
    i, j = np.triu_indices(k + 1, 2)
    keep = j - i < k
    i, j = i[keep], j[keep]
    n_on, n_off = j - i, k - (j - i)
    on = (c[j] - c[i]) / n_on
    off = (c[-1] - (c[j] - c[i])) / n_off
    ll = -dof * (n_on * np.log(on) + n_off * np.log(np.maximum(off, 1e-12)))
    ll[on < off] = -np.inf
    best = int(np.argmax(ll))
    return _worth(e, dof, [(int(i[best]), int(j[best]))])


def _several(e: Array, dof: float) -> tuple[float, list[tuple[int, int]]] | None:
    """(gain, runs) of the likeliest two levels that take turns, or None."""
    on, off = float(np.mean(np.sort(e)[-max(3, len(e) // 8) :])), float(np.quantile(e, 0.25))
    runs: list[tuple[int, int]] = []
    for _ in range(8):
        state = _path(e, dof, max(on, 1e-9), max(off, 1e-9))
        if state.all() or not state.any():
            return None
        on, off = float(e[state].mean()), float(e[~state].mean())
        start, stop = timing.runs(state)
        new = list(zip(start.tolist(), stop.tolist()))
        if new == runs:
            break
        runs = new
    pauses = [b[0] - a[1] for a, b in zip(runs[:-1], runs[1:])]
    if not 2 <= len(runs) <= MOST or min(pauses) < SHORTEST:
        return None
    if min(b - a for a, b in runs) < SHORTEST:
        return None
    return _worth(e, dof, runs)


def _path(e: Array, dof: float, on: float, off: float) -> Array:
    """The likeliest sequence of the two levels, each change at half of `TIMED`; bool (k,)."""
    cost = dof * np.column_stack([np.log(off) + e / off, np.log(on) + e / on])
    total, back = cost[0].copy(), np.zeros((len(e), 2), np.int8)
    for i in range(1, len(e)):
        change = total[::-1] + 0.5 * TIMED
        back[i] = np.where(change < total, [1, 0], [0, 1])
        total = np.minimum(total, change) + cost[i]
    out = np.zeros(len(e), np.int8)
    out[-1] = int(np.argmin(total))
    for i in range(len(e) - 1, 0, -1):
        out[i - 1] = back[i, out[i]]
    return out.astype(bool)


def _worth(
    e: Array, dof: float, runs: list[tuple[int, int]]
) -> tuple[float, list[tuple[int, int]]] | None:
    """(gain, runs) where the excess is in the runs and next to nothing beside them, else None."""
    inside = np.zeros(len(e), bool)
    for i, j in runs:
        inside[i:j] = True
    n_on, n_off = int(inside.sum()), int((~inside).sum())
    if n_off == 0:
        return None
    on, off = float(e[inside].mean()), float(max(e[~inside].mean(), 1e-12))
    gain = dof * (len(e) * np.log(e.mean()) - n_on * np.log(on) - n_off * np.log(off))
    excess, outside = on - 1.0, max(off - 1.0, 0.0)
    if gain < TIMED or excess <= 0 or outside > OUTSIDE * excess:
        return None
    # fainter, but there all the same
    still = dof * n_off * (outside - np.log1p(outside))
    if still > STILL * dof * n_on * (excess - np.log1p(excess)):
        return None
    # median of chi-square values over their degrees of freedom (Wilson and Hilferty 1931)
    usual = float(np.median(e[~inside])) / (1.0 - 1.0 / (9.0 * dof)) ** 3 - 1.0
    if usual > max(FAINT * excess, SURE * 1.25 / np.sqrt(dof * n_off)):
        return None
    return gain, runs
