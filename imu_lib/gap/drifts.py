"""Deterministic drifts beside one another: scanned by generalised least squares, their time
constants and instants found anew.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.arrays import Array

if TYPE_CHECKING:
    from imu_lib.gap.candidate import Candidate
    from imu_lib.gap.state import State


#: (effect, processes, their columns where these are known) -> gain, amplitude and squared norm of
#: each.
Scan = Callable[..., tuple[Array, Array, Array]]


def scanner(state: State, columns: Array | None) -> Scan:
    """Function of (effect, processes, their columns where these are known) that gives gain,
    amplitude and squared norm of drifts by generalised least squares under the fitted noise, beside
    `columns`.
    """
    data = state.cleaned
    white = 1.0 / np.sqrt(data.stats.slow_ordinates(state.fit.expected))
    e = white * data.cosines
    basis = None
    if columns is not None:
        basis, _ = np.linalg.qr(white[:, None] * columns)
        e = e - basis @ (basis.T @ e)

    def scan(
        effect: Any, processes: Iterable[Any], known: Array | None = None
    ) -> tuple[Array, Array, Array]:
        a = white[:, None] * (effect.columns(processes, data) if known is None else known)
        if basis is not None:
            a = a - basis @ (basis.T @ a)
        norm = np.maximum(np.sum(a * a, axis=0), 1e-300)
        return 0.5 * (a.T @ e) ** 2 / norm, (a.T @ e) / norm, norm

    return scan


def _shaped(state: State) -> Iterator[tuple[int, Candidate, Array | None]]:
    """(place, candidate, columns of the other drifts or None) of drifts with a shape parameter."""
    for i, c in enumerate(state.items):
        if c.column is not None and c.effect.shape is not None:
            others = [o.column for o in state.items if o.column is not None and o is not c]
            yield i, c, np.column_stack(others) if others else None


def profiled(state: State) -> State:
    """The state with the range of every drift's shape parameter noted."""
    items, found = list(state.items), False
    for i, c, others in _shaped(state):
        items[i], found = c.effect.profiled(c, scanner(state, others), state.cleaned), True
    return state.with_items(items).settled() if found else state


def retuned(state: State) -> State:
    """The state with the shapes of its drifts (time constants, instants) found anew beside one
    another.
    """
    for _ in range(2):
        moved = False
        for i, c, _ in list(_shaped(state)):
            others = [o.column for o in state.items if o.column is not None and o is not c]
            if not others:
                continue
            scan = scanner(state, np.column_stack(others))
            best = c.effect.best(state, scan)
            if best is None:
                continue
            gain, _, _ = scan(c.effect, [c.process, best.process])
            if gain[1] > gain[0] + 0.1:
                state = state.with_items(state.items[:i] + (best,) + state.items[i + 1 :])
                moved = True
        if not moved:
            break
    return state
