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

from . import columns, correct, levels
from .problem import Noise
from .state import NOT_YET, State

Say = Callable[[str], object]
SEEN = 0.1  # s: from this offset of the fixes on, the search starts where the turns match best


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
    """Start where the turns of the fixes match those felt best, if the innovations agree: on roads
    without turns, or where fixes jump, a match is chance.
    """
    late, likeness, _ = lateness.best_match(correct.corrected(state.drive, state.theta))
    if abs(late) < SEEN:
        return
    moved = replace(state, theta=state.theta.copy(), kept=("gnss_time_offset",))
    moved.theta[columns.of("gnss_time_offset")] += late
    costs = []
    for tried in (state, moved):
        tried.rebuild()
        costs.append(tried.cost() / tried.use.sum())
    if costs[1] < costs[0]:
        state.take(moved)  # with its heading: that of a path seconds off is none
        state.result = NOT_YET
        say(f"fixes are about {late:.1f} s late (turns agree by {likeness:.2f})")
    else:
        state.result = NOT_YET
