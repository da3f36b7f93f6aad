"""A base where none is given: the family and its parameters fitted to the record, so that only
what it cannot express shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.effects import COMPETITORS, DRIFTS, SPECTRAL, Spectral
from imu_lib.gap.state import MIN_EVIDENCE, TEMPER, State
from imu_lib.likelihood.slot import Slot
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, WhiteNoise

#: What a filter in the sensor has to add to the evidence of a free base.
MIN_FILTER_EVIDENCE = 6.0
#: Log evidence that a noise more in the base has to bring: one that the record does not show costs
#: nothing else, its parameters being as open as before. Of 80 records of white noise, or white
#: noise and a walk, 54 took one that was not there where it cost nothing, 2 where it cost one half
#: or one, none where it cost 3 (benchmarks/gap_constants.py).
PER_NOISE = 1.0
#: Log evidence that a change of level has to be ahead of the best base without it.
EVENT_EVIDENCE = 5.0
#: How many drifts are named beside a free base.
MAX_DRIFTS = 2
#: Parts of the sampling rate below which a base is fitted to start a filter beside it.
BELOW = (0.1, 0.02)
#: Samples in the shortest correlation time of a free base.
QUICKEST = 50
#: Median of a chi-square of one degree of freedom, as single ordinates are.
MEDIAN_OF_ONE = 0.455
#: Families of a free base: the noises beside white noise.
FAMILIES: tuple[tuple[type, ...], ...] = (
    (),
    (RandomWalk,),
    (Flicker,),
    (GaussMarkov,),
    (Flicker, RandomWalk),
    (GaussMarkov, RandomWalk),
    (GaussMarkov, GaussMarkov),
)
#: Shares of the record that the correlation times of a family start from: of one, of two.
STARTS_OF_ONE = (0.003, 0.02, 0.1)
STARTS_OF_TWO = ((0.003, 0.1), (0.003, 0.02), (0.02, 0.1))


def _starts(data: Data, family: tuple[type, ...]) -> Iterator[list[Any]]:
    """Several starting points of a family, from the level of the spectrum."""
    seen, first = data.stats.count > 0, slice(2, 14)
    s = data.stats.mean_power[seen]
    top = float(np.median(s[-60:]))
    low = float(np.median(s[first])) / MEDIAN_OF_ONE
    f_low = float(np.median(data.layout.frequency[first]))
    excess = max(low - top, 0.1 * top)
    strong = max(excess, 0.3 * top)
    white = of_density(WhiteNoise(N=1.0), top, f_low)
    count = family.count(GaussMarkov)
    for shares in (
        ((),) if count == 0 else [(t,) for t in STARTS_OF_ONE] if count == 1 else STARTS_OF_TWO
    ):
        left, terms = list(shares), [white]
        for kind in family:
            if kind is GaussMarkov:
                unit = GaussMarkov(sigma=1.0, correlation_time=left.pop(0) * data.duration)
                terms.append(of_density(unit, strong, f_low))
            else:
                unit = kind(**{effect_of(kind).amplitude: 1.0})
                terms.append(of_density(unit, excess, f_low))
        yield terms


def effect_of(kind: type) -> Spectral:
    """The effect that is a noise of that kind."""
    return next(e for e in SPECTRAL if e.process is kind)


def of_density(unit: Any, density: float, f: float) -> Any:
    """The noise of the shape of `unit`, of amplitude 1, that has a `density` at `f` Hz."""
    amplitude = np.sqrt(density / float(unit.psd(np.array([f]))[0]))
    return unit.with_(**{effect_of(type(unit)).amplitude: float(amplitude)})


def _slow(slot: Slot, fs: float) -> Slot:
    """The slot with its time constant long enough for a drift: a shorter one would imitate a
    filter in the sensor.
    """
    low = tuple(
        np.log(QUICKEST / fs) if name == "correlation_time" else v
        for name, v in zip(slot.names, slot.low)
    )
    return replace(slot, low=low)


def free_base(data: Data, held: Sequence[Any] = ()) -> tuple[State, list[State]]:
    """The best family by evidence, as a state whose base is free, beside the drifts and the filter
    that stand far out of it; and all families.

    A drift competes with the families, each by itself: fitted first, a random walk would imitate a
    ramp that is plain to see; so do two levels, whose spectrum is that of a Gauss-Markov process.
    A filter in the sensor is tried beside a base fitted to the low part of the band, up to each of
    `BELOW`: fitted to all of it, flicker or a quick Gauss-Markov process would imitate the
    roll-off.
    """
    best, families = _likeliest(_families(data, held))
    filtered = _filtered(data, held, best)
    if filtered is not best:  # beside the filter another family may be likelier, or a drift show
        best, families = _likeliest(_families(data, held, filtered.settled().items), filtered)
    return best.settled(), [s.settled() for s in families]


def _likeliest(families: list[State], best: State | None = None) -> tuple[State, list[State]]:
    """The best of the families (and of `best`) beside the drifts and the two levels that say more,
    and the families beside these drifts.
    """
    best = max(families if best is None else [best, *families], key=_worth)
    levels = _two_levels(best, families)  # before their largest jumps are taken for steps
    for _ in range(MAX_DRIFTS):
        trials = [s.plus(c) for s in families for e in DRIFTS for c in e.candidates(s)]
        top = max(trials, key=_worth, default=None)
        if top is None or _worth(top) < _worth(best) + MIN_EVIDENCE:
            break
        best = top
        families = [s.plus(best.items[-1]) for s in families]
    if best.items:
        best = _two_levels(best, families)
    return max([best, levels], key=_worth), families


def _filtered(data: Data, held: Sequence[Any], best: State) -> State:
    """The best state, or the likeliest base behind a filter in the sensor, where there is one."""
    levels, trials = [c for c in best.items if c.signal is not None], []
    for share in BELOW:
        low = best.cleaned.below(share * data.fs)
        below = max(_families(low, held, best.drifts), key=_worth).settled()
        items = [*below.items, *levels]
        bare = State(data, below.base, items)
        for item in (c for e in COMPETITORS if e.rolls_off for c in e.candidates(bare)):
            trials.append(State(data, below.base, [*items, item], base_slots=below.base_slots))
    top = max(trials, key=lambda trial: trial.evidence, default=best)
    return top if top.evidence > best.evidence + MIN_FILTER_EVIDENCE else best


def _two_levels(best: State, families: list[State]) -> State:
    """The best state, or a family beside a bias that jumps between two levels, where that says
    more.
    """
    if all(t.fast for t in best.base):  # nothing that they could have been taken for
        return best
    trials = [
        without.plus(c)
        for s, term, without in _less_one(families)
        for e in COMPETITORS
        for c in e.candidates_in_place(s, term, without)
    ]
    top = max(trials, key=_worth, default=best)
    return top if _worth(top) > _worth(best) + MIN_EVIDENCE else best


def _less_one(families: list[State]) -> Iterator[tuple[State, Any, State]]:
    """Families, each with a noise of it and the family of its other noises."""
    for s in families:
        if any(c.signal is not None for c in s.items):
            continue
        for i, term in enumerate(s.fit.terms[: len(s.base)]):
            names = _names(s)[:i] + _names(s)[i + 1 :]
            yield from ((s, term, t) for t in families if _names(t) == names)


def _names(state: State) -> list[str]:
    return [t.name for t in state.base]


def alternatives(state: State, families: list[State]) -> list[tuple[State, float]]:
    """The state, and with its items each other family that the record does not rule out, with their
    shares of the evidence.
    """
    names = _names(state)
    others = [
        State(state.data, f.base, state.items, base_slots=f.base_slots)
        for f in families
        if _names(f) != names
    ]
    states = [state, *others]
    evidence = np.array([s.evidence for s in states])
    share = np.exp((evidence - evidence.max()) / TEMPER)
    return list(zip(states, share / share.sum()))


def against_bases(state: State, rivals: list[Any]) -> tuple[State, list[Any]]:
    """A state whose base is free, that base chosen anew beside its items, without the changes of
    level that another base makes superfluous, and the rivals of the items.
    """
    events = [i for i in state.items if i.column is not None and i.effect.event]
    if not state.base_slots or not events:
        return state, rivals
    held = state.base[: min(slot.index for slot in state.base_slots)]
    best = max(_families(state.data, held, state.items), key=_worth)
    if _worth(best) > _worth(state) + PER_NOISE:
        state = best.settled()
    for i, item in enumerate(state.items):
        if item.column is None or not item.effect.event:
            continue
        others = [other for other in state.items if other is not item]
        bare = max(_families(state.data, held, others), key=_worth)
        ahead = _worth(state) - _worth(bare)
        if ahead < EVENT_EVIDENCE:
            return against_bases(bare.settled(), rivals[:i] + rivals[i + 1 :])
        names = _names(state)
        slow = next((t.name for t in bare.base if t.name not in names), "")
        rivals[i] = {**rivals[i], slow: max(rivals[i].get(slow, -np.inf), -ahead)}
    return state, rivals


def _worth(state: State) -> float:
    return state.evidence - PER_NOISE * len(state.base)


def _families(data: Data, held: Sequence[Any], items: Sequence[Candidate] = ()) -> list[State]:
    """The likeliest start of every family, fitted beside `items`."""
    out = []
    for family in FAMILIES:
        states = []
        for terms in _starts(data, family):
            terms = list(held) + terms
            slots = [
                _slow(effect_of(type(t)).slot(i, data.fs, data.duration), data.fs)
                for i, t in enumerate(terms)
                if i >= len(held)
            ]
            states.append(State(data, terms, items, base_slots=slots))
        out.append(max(states, key=lambda state: state.evidence))
    return out
