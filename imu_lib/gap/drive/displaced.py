"""When the fixes are displaced, if they are and stay so: the change point of the innovations.

A displacement that stays is seen for as long as the filter needs to believe it, which may be a few
fixes: it is looked for at the fixes from which on the innovations go one way most, by generalised
likelihood ratio (Willsky and Jones 1976), against one fix that is displaced alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import poisson

from imu_lib.arrays import Array

from . import columns, regression

if TYPE_CHECKING:
    from .state import State

WINDOWS = (1, 2, 4, 8, 16, 32)  # fixes over which innovations are summed
TIMES = 10  # tried
LEAST = 30.0  # nats, that the best of thousands of fixes gains by chance in no drive
BETTER = 5.0  # nats over one fix alone
# smaller ones are a receiver's usual errors: stated standard deviations, and m of the best receiver
SEEN, SEEN_METERS = 4.0, 1.0
ALONG = 0.5  # cosine between two errors of one side
RARE = 1e-4  # probability of so many wild fixes in a row


def look(state: State, say: Callable[[str], object]) -> bool:
    """Ask for a displacement of all further fixes where that explains most, if that was not asked
    before: whether so.
    """
    rows = _rows(state)
    if not rows.size or columns.MOVED in state.kept:
        return False
    gains, sizes, single = _gains(state, rows)
    best = int(np.argmax(gains))
    if gains[best] < LEAST or gains[best] < single.max() + BETTER:
        return False
    row = rows[best]
    usual = np.maximum(SEEN * np.sqrt(state.problem.stated[row, :3]), SEEN_METERS)
    if np.all(np.abs(sizes[best]) < usual):
        return False
    late = state.theta[columns.of("gnss_time_offset")[0]]
    earlier = _seen(state)
    before = earlier[earlier < row].max()
    moved_at = float(0.5 * (state.problem.time[before] + state.problem.time[row]) + late)
    if moved_at == state.moved_at:
        return False
    state.moved_at = moved_at
    say(f"fixes may be displaced from {state.moved_at:.1f} s on, {gains[best]:.0f} nats")
    state.rebuild()
    return True


def _seen(state: State) -> Array:
    """Numbers of the fixes that have innovations of their positions."""
    return np.flatnonzero((state.use & np.isfinite(state.result.e))[:, :3].all(axis=1))


def _rows(state: State) -> Array:
    """Numbers of the fixes from which on the innovations go one way most, if that is no chance."""
    seen = _seen(state)[1:]
    sums = np.cumsum(np.vstack([np.zeros(3), state.result.e[seen, :3]]), axis=0)
    first, largest = np.arange(seen.size), np.zeros(seen.size)
    for width in WINDOWS:
        one_way = sums[np.minimum(first + width, seen.size)] - sums[:-1]
        largest = np.maximum(largest, np.sum(one_way**2, axis=1) / width)
    order = np.argsort(-largest)[:TIMES]
    return seen[order[largest[order] > 2.0 * LEAST]]


def _gains(state: State, rows: Array) -> tuple[Array, Array, Array]:
    """Nats that a displacement from each of some fixes on gains, (k,), how large it is, (k, 3) m,
    and what a displacement of that fix alone gains, (k,).
    """
    number = np.arange(state.problem.time.size)[:, None]
    which = np.hstack([number >= rows, number == rows])  # (f, 2 k)
    shown = np.zeros((number.size, 6, 3 * which.shape[1]))
    for i in range(3):
        shown[:, i, i::3] = -1.0 * which
    result = state.problem.evaluate(state.noise, use=state.use, held=state.other, shown=shown)
    gains, sizes = regression.gains(state, result, columns.PRIOR[columns.of(columns.MOVED)])
    return gains[: rows.size], sizes[: rows.size], gains[rows.size :]


def in_a_row(state: State) -> list[str]:
    """What is said, in a list, where fixes taken for wild follow one another on one side: single
    wild fixes are independent of each other.
    """
    if state.noise.fraction <= 0.0:
        return []
    seen = _seen(state)
    wild, error = state.result.wild[seen], state.result.e[seen, :3]
    length = np.maximum(np.linalg.norm(error, axis=1), 1e-12)
    along = np.sum(error[1:] * error[:-1], axis=1) / (length[1:] * length[:-1]) > ALONG
    pairs = wild[1:] & wild[:-1] & along
    share = max(float(wild.mean()), float(state.noise.fraction))
    chance = 0.5 * (1.0 - ALONG) * share**2 * seen.size
    if poisson.sf(int(pairs.sum()) - 1, chance) > RARE:
        return []
    first = state.problem.time[seen[1:][pairs]][0]
    return [
        f"fixes taken for wild follow one another on one side ({int(pairs.sum())} times, where "
        f"{chance:.1g} are chance; first at {first:.0f} s): a displacement that lasts, and no "
        "single wild fixes"
    ]
