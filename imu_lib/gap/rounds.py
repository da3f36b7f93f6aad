"""One effect at a time: rounds of candidates, the backward pass, the swaps, and how sure each name
is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import SCREEN
from imu_lib.gap.drifts import retuned
from imu_lib.gap.effects import COMPETITORS
from imu_lib.gap.state import MIN_EVIDENCE, MIN_LIKELIHOOD, TEMPER, State

#: Alternatives within this log evidence of the winner cannot be told from it: a weight of one in
#: eight beside it, exp(-3 / TEMPER).
INDISTINCT = 3.0
#: A fit gains at the most so many times what its screening promises (one of 246 candidates gained
#: more, half of them as much as promised: benchmarks/gap_constants.py), and a rival further behind
#: in log evidence has no weight, exp(-6 / TEMPER) = 2 %, less than what a report lists.
MOST_OF_SCREENED, NO_WEIGHT = 2.0, 6.0
#: So many rivals of an item, no further behind in log evidence, are tried together with a second
#: effect.
MOST_REPLACED, FARTHEST = 3, 150.0


@dataclass(frozen=True)
class Weighed:
    """A candidate with its state and what it adds to the evidence and log-likelihood of the state
    it was added to.
    """

    item: Candidate
    state: State
    evidence: float
    gain: float


def weigh(state: State, *, exclude: tuple[str, ...] = (), least: float = 0.0) -> list[Weighed]:
    """All candidates that could be added to `state`, the best first; without those whose screening
    is far from a gain of `least`.
    """
    effects = [e for e in COMPETITORS if e.name not in exclude]
    items = [c for e in effects for c in e.candidates(state)]
    # the screening of a changed parameter is a local slope, which promises too much
    best = max((c.screen for c in items if c.at is None), default=0.0)
    simple = max((c.screen for c in items if c.effect.simple), default=0.0)
    items = [
        c
        for c in items
        if c.effect.worth_fitting(c, state, best, simple)
        and MOST_OF_SCREENED * (c.screen + SCREEN) >= least
    ]
    shaped = any(c.effect.shape is not None for c in state.drifts)
    out = []
    for item in items:
        trial = state.plus(item)
        if shaped and item.column is not None:  # drifts share what they explain
            trial = retuned(trial)
        out.append(_weighed(item, trial, state))
    out.sort(key=lambda w: -w.evidence)
    for effect in effects:
        beside = [_weighed(c, state.plus(c), state) for c in effect.candidates_beside(state, out)]
        out += sorted(beside, key=lambda w: -w.evidence)[:1]
    out.sort(key=lambda w: -w.evidence)
    return out


def _weighed(item: Candidate, trial: State, state: State) -> Weighed:
    return Weighed(item, trial, trial.evidence - state.evidence, trial.ll - state.ll)


def grow(state: State, *, most: int = 5, exclude: tuple[str, ...] = ()) -> tuple[State, list[Any]]:
    """Rounds until nothing is worth adding: the grown state and [(winner, all candidates of that
    round)].
    """
    history = []
    for _ in range(most):
        weighed = weigh(state, exclude=exclude)
        best = next(
            (w for w in weighed if w.evidence > MIN_EVIDENCE and w.gain > MIN_LIKELIHOOD), None
        )
        if best is None:
            break
        state = retuned(best.state).settled()
        history.append((best, weighed))
    return state, history


def prune(state: State) -> State:
    """Drop the items that the others have made superfluous."""
    while state.items:
        worth = []
        for i in range(len(state.items)):
            without = retuned(state.with_items(state.items[:i] + state.items[i + 1 :]))
            worth.append((state.evidence - without.evidence, i, without))
        least = min(worth, key=lambda w: w[0])
        if least[0] > MIN_EVIDENCE:
            break
        state = least[2].settled()
    return state


def swap(
    state: State, *, exclude: tuple[str, ...] = (), passes: int = 2, reach: float = FARTHEST
) -> tuple[State, list[Any]]:
    """Put every item to the test against all others in its place; returns the best state and for
    each item its rivals.

    Rivals no further behind than `reach` are tried with a second effect beside them.

    The rivals are a list of (name, log evidence relative to the item) for each item of the final
    state.
    """
    for _ in range(passes):
        changed = False
        rivals = []
        for i, item in enumerate(state.items):
            without = retuned(state.with_items(state.items[:i] + state.items[i + 1 :]))
            weighed = [w for w in weigh(without, exclude=exclude) if w.item.form != item.form]
            own = state.evidence - without.evidence
            weighed = [replace(w, evidence=w.evidence - item.effect.against(w)) for w in weighed]
            weighed.sort(key=lambda w: -w.evidence)
            if weighed and weighed[0].evidence > own + 0.5:
                state, changed = retuned(weighed[0].state).settled(), True
                break
            weighed = [w for w in weighed if w.item.key != item.key]
            others = _rivals(weighed, item, own)
            two = _by_two(weighed, own, item, exclude, reach)
            if two is not None and two[0] > MIN_EVIDENCE + 0.5:
                state, changed = retuned(two[1].state).settled(), True
                break
            if two is not None:
                others[two[2]] = max(others[two[2]], two[0])
            others[""] = -own  # nothing at all in its place
            rivals.append(others)
        if not changed:
            return state, rivals
    return state, [{} for _ in state.items] if changed else rivals


def _rivals(weighed: list[Weighed], item: Candidate, own: float) -> dict[str, float]:
    """Log evidence of each candidate, by its key, relative to an item of the evidence `own`; what
    looks like a candidate, but for the item itself, has its share of it.
    """
    out: dict[str, float] = {}
    for w in weighed:
        alike = w.item.effect.alike(w.state, w.item)
        alike = {key: share for key, share in alike.items() if key != item.key}
        shares = {**alike, w.item.key: 1.0 - sum(alike.values())}
        for key, share in shares.items():
            value = w.evidence - own + TEMPER * float(np.log(share))
            out[key] = max(out.get(key, -np.inf), value)
    return out


def _by_two(
    weighed: list[Weighed], own: float, item: Candidate, exclude: tuple[str, ...], reach: float
) -> tuple[float, Weighed, str] | None:
    """The best two other effects in the place of `item`: (log evidence relative to it, second of
    the two, key of the first), or None.

    A sum of two noises looks like a third: a slow and a fast one like flicker. A drift is two
    drifts sooner than noises, however well these follow it.
    """
    best = None
    drifts = [w for w in weighed[MOST_REPLACED:] if w.item.column is not None]
    for w in weighed[:MOST_REPLACED] + (drifts[:1] if item.column is not None else []):
        if w.evidence < max(own - reach, MIN_EVIDENCE) or (
            w.item.slot is None and w.item.column is None
        ):
            continue
        more = next(
            (
                v
                for v in weigh(
                    w.state.settled(),
                    exclude=(*exclude, "telegraph"),
                    least=own - w.evidence - NO_WEIGHT,
                )
                if v.gain > MIN_LIKELIHOOD and v.evidence > MIN_EVIDENCE
            ),
            None,
        )
        if more is None or more.item.form == item.form:
            continue
        total = w.evidence + more.evidence - own
        if best is None or total > best[0]:
            best = (total, more, w.item.key)
    return best


def confidence(rivals: dict[str, float]) -> tuple[float, dict[str, float]]:
    """Posterior weight of the item and of each rival."""
    keys = [k for k in rivals]
    values = np.array([0.0] + [rivals[k] for k in keys]) / TEMPER
    weight = np.exp(values - values.max())
    weight /= weight.sum()
    return float(weight[0]), {k: float(w) for k, w in zip(keys, weight[1:])}
