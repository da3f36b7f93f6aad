"""A drive searched: about the axes that it has, under a noise that is given or fitted to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.model import Model
from imu_lib.navigation import axes, turns
from imu_lib.navigation.windows import Window

from . import base_model, correct, outage, search, start, vehicle
from .effects import LINEAR
from .problem import Noise
from .start import Say
from .state import State
from .steps import SUREST

REFITS = 3  # of the noise fitted to the drive, which holds what was not yet found


@dataclass(frozen=True)
class Searched:
    """What a search leaves.

    right : the drive with its axes put right; turn : of `axes.of`; windows that were withheld;
    state, first : what is held at the end, and before anything was; noise, original : under what
    is found, and the model before; turned : the case's angles and standard deviations, or None
    """

    right: Drive
    turn: axes.Found
    windows: tuple[Window, ...]
    state: State
    first: State
    noise: Noise
    original: Model
    turned: tuple[Array, Array] | None


def searched(
    drive: Drive, model: Model | None, random: bool, notes: list[str], say: Say
) -> Searched:
    """The drive searched, once more where its path shows other axes than its fixes alone did;
    random : for changes of what is random too.
    """
    turn = axes.of(turns.in_time(drive))
    for _ in range(2):
        say(f"axes {' '.join(turn[0])}")
        right = correct.axes_put_right(drive, turn[0])
        windows = outage.withheld(right)
        state, first, noise, original = _about(right, model, (windows, random), notes, say)
        turned = vehicle.mounting(state.problem, vehicle.attitude_sd(state))
        askew = _askew(turn, turned)
        if askew is None:
            break
        turn = askew
    return Searched(right, turn, windows, state, first, noise, original, turned)


def _askew(turn: axes.Found, turned: tuple[Array, Array] | None) -> axes.Found | None:
    """The axes, as of `axes.of`, where the path shows that the case lies turned by right angles:
    the path knows more of it than the fixes' own motion. turned : angles and standard deviations.
    """
    if turned is None or not vehicle.beyond_doubt(turned):
        return None
    more = vehicle.turned_axes(turned)
    if more is None:
        return None
    both = axes.of_matrix(axes.to_body(more) @ axes.to_body(turn[0]))
    gain = 0.5 * float(np.sum((turned[0] / turned[1]) ** 2))
    return both, SUREST, turn[0], gain, ()


def _about(
    drive: Drive,
    model: Model | None,
    asked: tuple[tuple[Window, ...], bool],
    notes: list[str],
    say: Say,
) -> tuple[State, State, Noise, Model]:
    """(state, first, noise, original) of `Searched`; asked: windows to withhold, and whether what
    is random is searched.
    """
    windows, random = asked
    theta, noise, given, original = start.held(drive, model, notes)
    away = tuple((w.start, w.duration) for w in windows)
    of_model = tuple(e for e in LINEAR if np.any(correct.value(theta, e)))  # to be let go again
    state = State(drive, noise, theta, kept=of_model, withhold=away, free=not given)
    start.in_time(state, say)
    first = replace(state, theta=np.zeros_like(theta), kept=())
    first.rebuild()
    if not given:
        if state.kept:  # the noise of a path that is seconds off says nothing
            state.rebuild()
        state.noise = first.noise = base_model.fit(state if state.kept else first, say)
        original = first.noise.model
        first.weigh()
    state.base = first.noise
    search.run(state, given=given, random=random, say=say)
    for _ in range(REFITS if not given else 0):
        if not base_model.anew(state, say):
            break
        search.run(state, given=given, random=random, say=say)
    base_model.settle(state, say)
    return state, first, state.base, original
