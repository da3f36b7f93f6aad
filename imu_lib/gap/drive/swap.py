"""Noises of one channel tried in each other's place.

Which of them was taken was decided on the path of that moment, and before others were held; both
have changed since.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imu_lib.arrays import Array

from . import prune, random_effects, readings
from .random_effects import Change as Option
from .readings import Densities
from .state import Change, State

OF_CHANNELS = ("bias_model", "vibration")
FITTED = 3  # of what a few values promise
PROMISED = 0.5  # of the gain of what is held: what promises less is not fitted
BETTER = 2.0  # nats by which another has to be better


def noises(state: State, given: bool, say: Callable[[str], object]) -> None:
    """Put another noise of the same channel in the place of one that was changed, where it does
    better on the path as it is; given : a model's processes may be wrong.
    """
    measured = (
        readings.densities(state.problem),
        readings.densities(state.problem, readings.SLOW),
    )
    short = replace(state, problem=state.problem.brief())
    for change in [c for c in state.changes if c.change.effect in OF_CHANNELS]:
        noise = prune.without(state, [change])
        base = short.evaluate(noise).log_likelihood

        held = change.change
        gain = short.evaluate(state.noise).log_likelihood - base
        now = _worth(held, change.values, gain, measured)
        found = [(now, gain, held, change.values, state.noise)]
        others = _others(short, change, given, gain)
        for option in [held, *others] if others else []:
            values, gain, entered = option.fitted(short, noise, base)
            value = _worth(option, values, gain, measured) - (BETTER if option is not held else 0.0)
            found.append((value, gain, option, values, entered))
        found.sort(key=lambda f: -f[0])
        best, gain, option, values, entered = found[0]
        elsewhere = [r for r in change.rivals if r[2][1:2] != option.key[1:2]]
        rivals = [f for f in found if f[2] is not option]
        change.rivals = [(f[2].effect, f[0] - best, f[2].key) for f in rivals] + elsewhere
        if entered is not state.noise:
            if option is not held:
                say(f"{option.key} in the place of {held.key}")
            change.change, change.values, change.gain = option, values, gain
            state.noise = entered
            state.weigh()


def _worth(
    option: Option, values: Array, gain: float, measured: tuple[Densities, Densities]
) -> float:
    """Nats that a noise is worth, with its price and what the readings say of it, as they are and
    at a few hertz.
    """
    shown, slow = measured
    if not readings.possible(option, values, slow):
        return -np.inf
    return gain - random_effects.penalty(option) + readings.evidence(option, values, shown)


def _others(state: State, change: Change, given: bool, gain: float) -> list[Option]:
    """What may stand in the place of a change that gains so much, nats."""
    noise, key = prune.without(state, [change]), change.change.key
    base = state.evaluate(noise).log_likelihood
    held = {c.change.key for c in state.changes}
    options = [
        c
        for c in random_effects.changes(state.problem, noise, given)
        if c.effect in OF_CHANNELS and c.key[1] == key[1] and c.key not in held
    ]
    ranked = random_effects.screen(state, noise, base, options)
    out = [c for value, c in ranked[:FITTED] if value > PROMISED * gain]
    return [*out, random_effects.shaken(state.problem, noise, key[1])] if given else out
