"""White noise at rest and a vibration that follows the speed, tried in each other's place.

Which of the two was taken was decided on the path of that moment, which has moved since.
"""

from __future__ import annotations

from collections.abc import Callable

from . import prune, random_effects, readings
from .state import Change, State

WHITE = ("white_noise", "N")


def white(state: State, given: bool, say: Callable[[str], object]) -> None:
    """Put a vibration in the place of white noise that was changed, or the reverse, where it does
    better on the path as it is; given : a model's white noise may be wrong.
    """
    measured = readings.densities(state.problem)
    for change in list(state.changes):
        if not _is_white(change.change.key):
            continue
        noise = prune.without(state, [change])
        options = [
            c
            for c in random_effects.changes(state.problem, noise, given)
            if _is_white(c.key) and c.key[1] == change.change.key[1] and c.key != change.change.key
        ]
        base = state.evaluate(noise).log_likelihood
        for _, option in random_effects.screen(state, noise, base, options):
            values, gain, entered = option.fitted(state, noise, base)
            now = state.result.log_likelihood - base
            now += readings.evidence(change.change, change.values, measured)
            if gain + readings.evidence(option, values, measured) <= now:
                continue
            say(f"{option.key} in the place of {change.change.key}")
            put = Change(option, values, gain, change.before, change.rivals, entered)
            state.changes[state.changes.index(change)] = put
            state.noise = entered
            state.weigh()
            break


def _is_white(key: tuple[str, ...]) -> bool:
    return key[0] == "vibration" or (key[0] == "bias_model" and key[2:] == WHITE)
