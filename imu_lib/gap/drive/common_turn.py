"""A turn that both sensors have in common, which no reading shows: the case's own.

Accelerometers that read A f and gyros that read G w may as well read (A Q) f' and (G Q) w' in a
body turned by Q: the innovations are the same, and a misalignment of one sensor that is a turn is
one of the other with the case mounted askew. To first order the regression has no say in it, and
what it leaves to second order looks like scale factors. So the turn of each sensor in question is
taken out of both, and what remains is led to a path of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import polar

from imu_lib.arrays import Array

from . import alone, columns, correct

if TYPE_CHECKING:
    from imu_lib.gap.drive.state import State

SENSORS = ("accel", "gyro")
LEAST = 1e-3  # rad: a smaller turn changes nothing to second order


def taken_out(state: State, say: Callable[[str], object]) -> bool:
    """Hold a misalignment of one sensor instead of the other's, or of both, where the same turn
    taken out of both leaves as good a path, and a case that stands straighter: whether so.
    """
    temper = state.reg.temper
    best, top, name = None, alone.misfit(state, temper), ""
    for sensor, kept, theta in _turned(state):
        trial = replace(state, theta=theta, other=state.other.copy(), kept=kept, heading=None)
        trial.rebuild()
        alone.converge(trial, kept, enough=state.cost())
        now = alone.misfit(trial, temper)
        if now < top:
            best, top, name = trial, now, sensor
    if best is None:
        return False
    say(f"a turn of both sensors taken out: {name} is not misaligned")
    state.take(best)
    return True


def _turned(state: State) -> Iterator[tuple[str, tuple[str, ...], Array]]:
    """(sensor, set, values) without the misalignment of each sensor that has one, the other's with
    the turn that it had.
    """
    for sensor, other in (SENSORS, SENSORS[::-1]):
        mine, others = f"{sensor}_misalignment", f"{other}_misalignment"
        if mine not in state.kept:
            continue
        kept = tuple(dict.fromkeys(others if e == mine else e for e in state.kept))
        turn = polar(_matrix(state.theta, sensor), side="left")[0]
        if np.linalg.norm(turn - np.eye(3)) < LEAST:
            continue
        yield sensor, kept, in_body(state.theta, turn.T, kept, state.drive.lever_arm)


def in_body(theta: Array, turn: Array, kept: tuple[str, ...], arm: Array | None = None) -> Array:
    """Values of a set that say the same of a body turned by a rotation matrix (3, 3): vectors of
    the old one are `turn` times those of the new; arm : m, of the file (3,).
    """
    out = theta.copy()
    for sensor in SENSORS:
        apart = _matrix(theta, sensor) @ turn - np.eye(3)
        out[columns.of(f"{sensor}_scale")] = np.diag(apart)
        out[columns.of(f"{sensor}_misalignment")] = apart[~np.eye(3, dtype=bool)]
    g = correct.value(theta, "gyro_g_sensitivity").reshape(3, 3) @ turn
    out[columns.of("gyro_g_sensitivity")] = g.ravel()
    given = np.zeros(3) if arm is None else np.asarray(arm, float)
    out[columns.of("lever_arm")] = turn.T @ (given + correct.value(theta, "lever_arm")) - given
    for i, column in enumerate(columns.ALL):
        if column.effect not in kept:
            out[i] = 0.0
    return out


def _matrix(theta: Array, sensor: str) -> Array:
    """I + scale factors + misalignments of a sensor, (3, 3)."""
    x = correct.cross_coupling(correct.value(theta, f"{sensor}_misalignment"))
    return np.eye(3) + np.diag(correct.value(theta, f"{sensor}_scale")) + x
