"""Effects of two kinds that stand for each other: a column of the innovations, and a change of what
is random. The search takes one after the other, whichever gains more at the time; here each is
tried in the other's place, on a path of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from . import alone, prune, random_effects, select
from .hold import held
from .state import Change, State

NoiseStep = Callable[[State], Change | None]
Say = Callable[[str], object]
#: Nats by which the other has to be better: its path and its noise are fitted anew, that of what
#: is held may have been so long ago.
BETTER = 2.0


def exchange(state: State, names: list[str], noise_step: NoiseStep, say: Say) -> bool:
    """Exchange a change of what is random for columns, or a column of little worth for a change,
    where that does better: whether something was exchanged.

    names : of the columns that can be asked for; noise_step : the best change under a state
    """
    now = worth(state, state.reg.temper)
    for trial in (*_columns_for_changes(state, names), *_changes_for_columns(state, noise_step)):
        if worth(trial, state.reg.temper) < now - BETTER:
            say("of the other kind, and better: " + _told(trial))
            state.take(trial)
            state.noise, state.changes = trial.noise, trial.changes
            return True
    return False


def worth(state: State, temper: float) -> float:
    """Misfit of the innovations with the price of all that is held, nats."""
    random = sum(random_effects.penalty(c.change) for c in state.changes)
    return alone.misfit(state, temper) + random


def _told(state: State) -> str:
    return ", ".join((*state.kept, *(str(c.change.key) for c in state.changes)))


def _columns_for_changes(state: State, names: list[str]) -> list[State]:
    """Each change taken out, where the columns then ask for another set."""
    out = []
    for change in state.changes:
        if change.change.effect == "gnss_outliers":
            continue  # what is taken for wild is no matter of columns
        trial = state.copy()
        trial.noise = prune.without(trial, [trial.changes[state.changes.index(change)]])
        del trial.changes[state.changes.index(change)]
        trial.weigh()
        kept, _ = select.best(trial.reg, names)
        if set(kept) - set(state.kept) and held(trial, kept, freely=True):
            out.append(trial)
    return out


def _changes_for_columns(state: State, noise_step: NoiseStep) -> list[State]:
    """Each column of little worth taken out, and the best change of what is random put in."""
    out, top = [], select.score_of(state.reg, state.kept)
    for effect in state.kept:
        rest = tuple(e for e in state.kept if e != effect)
        price = select.price(state.reg, (effect,))
        if top - select.score_of(state.reg, rest) > prune.DOUBTED * price:
            continue
        trial = state.copy()
        held(trial, rest, freely=True)
        found = noise_step(trial)
        if found is None:
            continue
        trial.noise = found.noise
        trial.changes = [*trial.changes, replace(found)]
        trial.rebuild()
        out.append(trial)
    return out
