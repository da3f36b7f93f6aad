"""A base where none is given: the family and its parameters fitted to the record, so that only
what it cannot express shows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.gap.data import Data
from imu_lib.gap.effects import CATALOGUE, DRIFTS, SPECTRAL
from imu_lib.gap.state import EVIDENCE, TEMPER, State
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, WhiteNoise

#: What a filter in the sensor has to add to the evidence of a free base.
FILTER = 6.0
#: Log evidence that a noise more in the base has to bring: one that the record does not show costs
#: nothing else, its parameters being as open as before.
PER_NOISE = 1.0
#: How many drifts are named beside a free base.
MAX_DRIFTS = 2
#: Parts of the sampling rate below which a base is fitted to start a filter beside it.
BELOW = (0.1, 0.02)
#: Samples in the shortest correlation time of a free base.
QUICKEST = 50
#: Median of a chi-square of one degree of freedom, as single ordinates are.
MEDIAN_OF_ONE = 0.455
#: Families of a free base: the noises beside white noise.
FAMILIES = (
    (),
    ("random_walk",),
    ("flicker",),
    ("gauss_markov",),
    ("flicker", "random_walk"),
    ("gauss_markov", "random_walk"),
    ("gauss_markov", "gauss_markov"),
)


def _starts(data: Data, family):
    """Several starting points of a family, from the level of the spectrum."""
    seen, first = data.stats.count > 0, slice(2, 14)
    s = data.stats.mean_power[seen]
    top = float(np.median(s[-60:]))
    low = float(np.median(s[first])) / MEDIAN_OF_ONE
    f_low = float(np.median(data.layout.frequency[first]))
    excess = max(low - top, 0.1 * top)
    strong = max(excess, 0.3 * top)
    N = np.sqrt(top / 2)
    make = {
        "random_walk": lambda _: RandomWalk(K=float(np.sqrt(excess / 2) * 2 * np.pi * f_low)),
        "flicker": lambda _: Flicker(B=float(np.sqrt(excess * np.pi * f_low))),
        "gauss_markov": lambda t: GaussMarkov(
            sigma=float(np.sqrt(strong * (1 + (2 * np.pi * f_low * t) ** 2) / (4 * t))),
            correlation_time=t,
        ),
    }
    times = [0.003 * data.duration, 0.02 * data.duration, 0.1 * data.duration]
    if "gauss_markov" not in family:
        yield [WhiteNoise(N=N)] + [make[n](None) for n in family]
    elif family.count("gauss_markov") == 1:
        for t in times:
            yield [WhiteNoise(N=N)] + [make[n](t) for n in family]
    else:
        for a, b in ((0, 2), (0, 1), (1, 2)):
            yield [WhiteNoise(N=N), make["gauss_markov"](times[a]), make["gauss_markov"](times[b])]


def _slow(slot, fs):
    """The slot with its time constant long enough for a drift: a shorter one would imitate a
    filter in the sensor.
    """
    low = tuple(
        np.log(QUICKEST / fs) if name == "correlation_time" else v
        for name, v in zip(slot.names, slot.low)
    )
    return replace(slot, low=low)


def free_base(data: Data, held=()) -> tuple[State, list[State]]:
    """The best family by evidence, as a state whose base is free, beside the drifts and the filter
    that stand far out of it; and all families.

    A drift competes with the families, each by itself: fitted first, a random walk would imitate a
    ramp that is plain to see; so do two levels, whose spectrum is that of a Gauss-Markov process. A
    filter in the sensor is tried beside a base fitted to the low part
    of the band, up to each of `BELOW`: fitted to all of it, flicker or a quick Gauss-Markov process
    would imitate the roll-off.
    """
    best, families = _likeliest(_families(data, held))
    filtered = _filtered(data, held, best)
    if filtered is not best:  # beside the filter another family may be likelier, or a drift show
        best, families = _likeliest(_families(data, held, filtered.settled().items), filtered)
    return best.settled(), [s.settled() for s in families]


def _likeliest(families, best: State | None = None) -> tuple[State, list[State]]:
    """The best of the families (and of `best`) beside the drifts and the two levels that say more,
    and the families beside these drifts.
    """
    best = max(families if best is None else [best, *families], key=_worth)
    levels = _two_levels(best, families)  # before their largest jumps are taken for steps
    for _ in range(MAX_DRIFTS):
        trials = [s.plus(c) for s in families for e in DRIFTS for c in e.candidates(s)]
        top = max(trials, key=_worth, default=None)
        if top is None or _worth(top) < _worth(best) + EVIDENCE:
            break
        best = top
        families = [s.plus(best.items[-1]) for s in families]
    if best.items:
        best = _two_levels(best, families)
    return max([best, levels], key=_worth), families


def _filtered(data: Data, held, best: State) -> State:
    """The best state, or the likeliest base behind a filter in the sensor, where there is one."""
    levels = [c for c in best.items if c.signal is not None]
    for share in BELOW:
        low = best.cleaned.below(share * data.fs)
        below = max(_families(low, held, best.drifts), key=_worth).settled()
        items = [*below.items, *levels]
        for item in CATALOGUE["low_pass"].candidates(State(data, below.base, items)):
            trial = State(data, below.base, [*items, item], base_slots=below.base_slots)
            if trial.evidence > best.evidence + FILTER:
                best = trial
    return best


def _two_levels(best: State, families) -> State:
    """The best state, or a family beside a bias that jumps between two levels, where that says
    more.
    """
    if all(t.fast for t in best.base):  # nothing that they could have been taken for
        return best
    alone = families[:2]  # white noise, and a walk beside it
    bases = [*alone, *(s for s in families[2:] if _names(s) == _names(best))]
    bases = [s for s in bases if not any(c.signal is not None for c in s.items)]
    trials = [s.plus(c) for s in bases for c in CATALOGUE["telegraph"].beside_base(s)]
    top = max(trials, key=_worth, default=best)
    return top if _worth(top) > _worth(best) + EVIDENCE else best


def _names(state: State) -> list[str]:
    return [t.name for t in state.base]


def alternatives(state: State, families) -> list[tuple[State, float]]:
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


def _worth(state: State) -> float:
    return state.evidence - PER_NOISE * len(state.base)


def _families(data, held, items=()) -> list[State]:
    """The likeliest start of every family, fitted beside `items`."""
    out = []
    for family in FAMILIES:
        states = []
        for terms in _starts(data, family):
            terms = list(held) + terms
            slots = [
                _slow(CATALOGUE[t.name].slot(i, data.fs, data.duration), data.fs)
                for i, t in enumerate(terms)
                if i >= len(held)
            ]
            states.append(State(data, terms, items, base_slots=slots))
        out.append(max(states, key=lambda state: state.evidence))
    return out


#: An effect is swallowed if the base takes this share of the information on its strength, for this
#: share of its shapes.
SWALLOWED, FAMILY = 0.5, 0.25


def absorbed(state: State) -> list[str]:
    """Effects that the free base of `state` may have swallowed: noises whose spectrum it imitates
    by a change of its own
    parameters, to first order in the effect's strength, and drifts that would show if its slow
    noises were not there.
    """
    data, problem, fit = state.data, state.problem, state.fit
    names = [t.name for t in state.base]
    s = fit.expected
    weight = np.sqrt(problem.stats.count / 2)
    own = sum(len(slot.names) for slot in state.base_slots)
    basis, _ = np.linalg.qr((problem.slopes(fit.vector)[1][:own] / s * weight).T)
    for effect in SPECTRAL:
        if not effect.beside(fit.low_pass, data.fs):
            continue
        taken = []
        for process in effect.grid(data.fs, data.duration):
            v = data.layout.shape(process, fit.low_pass) / s * weight
            taken.append(np.sum((basis.T @ v) ** 2) > SWALLOWED * np.sum(v**2))
        if np.mean(taken) > FAMILY:
            names.append(effect.name)
    # a drift that shows in the fast noise alone may be part of a fitted slow noise
    quick = data.layout.spectrum([t for t in fit.terms if t.fast], fit.low_pass)
    for effect in DRIFTS:
        shapes = [] if effect.sharp else effect.shapes(data)
        if shapes and np.all(quick > 0):
            square = effect.columns(shapes, data) ** 2
            seen, alone = (
                np.sum(square / data.stats.slow_ordinates(v)[:, None], axis=0) for v in (s, quick)
            )
            if np.mean(seen < SWALLOWED * alone) > FAMILY:
                names.append(effect.name)
    if "gauss_markov" in names:  # two levels whose dwells are lost in the noise have its spectrum
        names.append("telegraph")
    found = {item.name for item in state.items}
    return [n for n in dict.fromkeys([*names, "parameter_change"]) if n not in found]
