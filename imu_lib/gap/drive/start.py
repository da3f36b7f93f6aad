"""Where the search on a drive starts: what the model holds of it, and the time of its fixes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.navigation import lateness
from imu_lib.navigation.held import Held

from . import alone, columns, correct, levels, select
from .problem import Noise
from .state import NOT_YET, State

Say = Callable[[str], object]
SEEN = 0.1  # s: from this offset of the fixes on, the search starts where the turns match best
TIME = "gnss_time_offset"
BESIDE = (TIME, *select.RIDGES[TIME])
LEAST = 0.02  # s: a smaller step of the delay is left to the search
STEPS = 6  # that are tried
PRICE = select.PER_EFFECT + 2 * select.PER_PARAMETER  # nats that the delay has to gain


def held(drive: Drive, model: Model | None, notes: list[str]) -> tuple[Array, Noise, bool, Model]:
    """Values, noise, whether a model was given, and the model without what it holds."""
    theta = np.zeros(len(columns.ALL))
    if model is None:
        plain = levels.guess()
        return theta, Noise(plain), False, plain
    missing = [c for c in columns.CHANNEL_NAMES if c not in model]
    if missing:
        raise InputError(
            f"the error model {model.name or ''} has no channel {missing[0]}; a drive needs all six"
        )
    noise = Noise(model.with_drive(()))
    angles = Held.of(model.drive).mounting
    turn = Rotation.identity() if angles is None else Rotation.from_euler("ZYX", angles[::-1])
    for effect in model.drive:
        values = effect.parameters
        part = columns.of(effect.name)
        if effect.name == "lever_arm":
            given = np.zeros(3) if drive.lever_arm is None else drive.lever_arm
            # of the vehicle's axes into the case's, in which the search runs
            theta[part] = turn.inv().apply(values["arm"]) - given
        elif effect.name == "gnss_time_offset":
            theta[part] = values["offset"], values.get("velocity_offset", values["offset"])
        elif part:
            theta[part] = np.ravel(next(iter(values.values())))
        elif effect.name == "gnss_noise":
            noise = noise.with_(**{values["of"]: values["ratio"]})
        elif effect.name == "gnss_correlated":
            noise = noise.with_(sigma=values["sigma"], tau=values["correlation_time"])
        elif effect.name == "gnss_outliers":
            noise = noise.with_(fraction=values["fraction"], scale=values["scale"])
        else:
            notes.append(f"{effect.name} of the model's key `drive` is searched for anew.")
    return theta, noise, True, model.with_drive(())


def in_time(state: State, say: Say) -> None:
    """Start at the delay of the fixes that the innovations like best: as the stamps stand or where
    the turns of the fixes match those felt (on roads without turns, or where fixes jump, a match is
    chance), and from there on.

    A path follows fixes that are late, so that the regression about it asks for a part of their
    delay alone, and other effects would stand for the rest: its steps are doubled until it asks
    for the opposite, and then divided.
    """
    late, likeness, _ = lateness.best_match(correct.corrected(state.drive, state.theta))
    delay = np.zeros(2)
    stay = best = _delayed(state, delay)
    if abs(late) >= SEEN:
        moved = _delayed(state, delay + late)
        if _better(moved, best):
            best, delay = moved, delay + late
    at, asks, share, growth = delay, _asked(best), 1.0, 2.0
    for _ in range(STEPS):
        if np.abs(asks).max() < LEAST:
            break
        there = at + share * asks
        moved = _delayed(state, there)
        if _better(moved, best):
            best, delay = moved, there
        wants = _asked(moved)
        if asks @ wants < 0.0 and np.abs(wants).max() > LEAST:  # past it: between the two
            share *= float(asks @ asks / (asks @ asks - asks @ wants))
            growth = 1.0
        elif best is moved:
            at, asks, share = there, wants, growth * share
        else:
            break
    if _better(best, stay, PRICE):
        state.take(best)  # with its heading: that of a path seconds off is none
        say(f"fixes are about {delay[0]:.2f} s late (turns agree by {likeness:.2f})")
    state.result = NOT_YET


def _delayed(state: State, delay: Array) -> State:
    """The state on a path whose fixes are later by as much, (2,) s: positions and velocities."""
    kept = tuple(dict.fromkeys((*state.kept, TIME)))
    moved = replace(state, theta=state.theta.copy(), kept=kept)
    moved.theta[columns.of(TIME)] += delay
    moved.rebuild()
    return moved


def _better(state: State, other: State, nats: float = 0.0) -> bool:
    """Whether innovations are better by more than some nats as they are, and with what the
    regression makes up for; of more or fewer fixes alike.
    """
    costs = np.array([[s.cost(), s.cost() - alone.promised(s, BESIDE)] for s in (state, other)])
    gain = costs[1] / other.use.sum() - costs[0] / state.use.sum()
    return bool(np.all(gain * other.use.sum() > nats))


def _asked(state: State) -> Array:
    """By how much later the regression wants positions and velocities, (2,) s, beside what may be
    taken for a delay.
    """
    part = columns.of(TIME)
    index = [i for effect in BESIDE for i in columns.of(effect)]
    step = state.reg.solve(index)[0][:2] - state.theta[part]
    seen = np.diag(state.reg.information)[part] > 0.0
    return np.where(seen, step, step[::-1] if seen.any() else 0.0)
