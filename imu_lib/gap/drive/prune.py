"""What was found one after the other, taken out again where it is not worth its price."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.navigation.side_by_side import each

from . import columns, random_effects, select
from .hold import held, refit

if TYPE_CHECKING:
    from imu_lib.gap.drive.problem import Noise
    from imu_lib.gap.drive.state import Change, State

PRICE_OF_SHOCK = 25.0  # nats
DOUBTED = 8.0  # times its price: effects that gain less are tried without


def noises(state: State, say: Callable[[str], object]) -> None:
    """Take out every restart and every change of what is random that is not worth its price."""
    for when in state.restarts:
        kept = state.problem.arrays
        begins = kept["begins"].copy()
        begins[np.searchsorted(kept["node_time"], when)] = False
        state.problem.arrays = {**kept, "begins": begins}
        value = state.evaluate(state.noise).log_likelihood
        state.problem.arrays = kept
        if state.result.log_likelihood - value < PRICE_OF_SHOCK:
            say(f"the shock at {when:.1f} s taken out again")
            state.restarts = tuple(r for r in state.restarts if r != when)
            state.rebuild()
    while state.changes:
        sets = _leaving(state.changes)
        tried = [without(state, out) for out in sets]
        values = each(lambda noise: state.evaluate(noise).log_likelihood, tried)
        worth = []
        for out, value in zip(sets, values):
            loss = state.result.log_likelihood - value
            worth.append(sum(random_effects.penalty(c.change) for c in out) - loss)
            if len(out) == 1:
                out[0].gain = loss
        best = int(np.argmax(worth))
        if worth[best] <= 0.0:
            break
        say(", ".join(str(c.change.key) for c in sets[best]) + " taken out again")
        state.noise = tried[best]
        state.changes = [c for c in state.changes if c not in sets[best]]
        state.weigh()


def _leaving(changes: list[Change]) -> list[list[Change]]:
    """Changes that are tried without: each, each pair, as two may only make up for each other, and
    all.
    """
    sets = [list(out) for size in (1, 2) for out in combinations(changes, size)]
    return sets if len(changes) < 3 else [*sets, list(changes)]


def worthless(state: State, say: Callable[[str], object]) -> None:
    """Take out linear effects that are not worth their price on the path as it has become."""
    while state.kept:
        top = select.score_of(state.reg, state.kept)
        rests = {e: tuple(k for k in state.kept if k != e) for e in state.kept}
        worth = {e: top - select.score_of(state.reg, rest) for e, rest in rests.items()}
        least = min(worth, key=worth.__getitem__)
        if worth[least] >= 0.0:
            return
        say(f"{least} is no longer worth its price")
        held(state, rests[least], freely=True)


def effects(state: State, say: Callable[[str], object]) -> None:
    """Take out every linear effect that a noise fitted without it makes up for: the two were found
    one after the other, and what came first may have taken what belongs to the second.
    """
    for effect in state.kept:
        part = columns.GROUPS[effect]
        without = replace(
            state, other=state.other.copy(), changes=[replace(c) for c in state.changes]
        )
        without.other[part] = -state.theta[part]
        loss = state.result.log_likelihood - without.evaluate(state.noise).log_likelihood
        price = select.PER_PARAMETER * len(part) + select.PER_EFFECT
        if loss > DOUBTED * price:
            continue
        without.weigh()
        refit(without)
        refit(without)
        if state.result.log_likelihood - without.result.log_likelihood > price:
            continue
        say(f"{effect} taken out: the noise accounts for it")
        state.noise, state.changes = without.noise, without.changes
        held(state, tuple(e for e in state.kept if e != effect), freely=True)


def without(state: State, out: list[Change]) -> Noise:
    """The noise with changes undone: the others entered anew on the first hypothesis."""
    noise = state.changes[0].before
    for other in state.changes:
        if other not in out:
            noise = other.change.enter(noise, other.values)
    return noise
