"""One effect at a time: rounds of candidates, the backward pass, the swaps, and how sure each name
is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.gap import effects, fast
from imu_lib.gap.drifts import drift_candidates, retuned
from imu_lib.gap.engine import SCREEN, amplitude_occam, measured
from imu_lib.gap.search import change_candidates, filter_candidates, spectral_candidates
from imu_lib.gap.state import EVIDENCE, GAIN, Item, State

#: Alternatives within this log evidence of the winner cannot be told from it.
NEAR = 3.0
#: So many rivals of an item, no further behind in log evidence, are tried together with a second
#: effect.
REPLACED, REACH = 3, 150.0
#: Samples that a level has to last on average to be told from noise.
DWELL = 50
#: A dwell's squared signal-to-noise ratio below which two levels look like a Gauss-Markov process,
#: in white noise and in a drift.
BURIED, BURIED_IN_DRIFT = 3.0, 8.0
#: Evidences are divided by this before they become weights: no catalogue is complete and no record
#: exactly of its model.
TEMPER = 1.5


@dataclass(frozen=True)
class Weighed:
    """A candidate with its state and what it adds to the evidence and log-likelihood of the state
    it was added to.
    """

    item: Item
    state: State
    evidence: float
    gain: float


def weigh(state: State, *, exclude=()) -> list[Weighed]:
    """All candidates that could be added to `state`, the best first."""
    items = (
        spectral_candidates(state, exclude)
        + change_candidates(state)
        + filter_candidates(state)
        + drift_candidates(state)
    )
    items = [i for i in items if i.name not in exclude]
    beside = [i for i in items if i.name == "ramp" and i.note["screen"] < SCREEN]
    items = _worth_fitting([i for i in items if i not in beside], state) + beside
    out = []
    shaped = any(i.column is not None and i.effect.shape is not None for i in state.items)
    for item in items:
        trial = state.plus(item)
        if shaped and item.column is not None:  # drifts share what they explain
            trial = retuned(trial)
        out.append(Weighed(item, trial, trial.evidence - state.evidence, trial.ll - state.ll))
    out.sort(key=lambda w: -w.evidence)
    if "telegraph" not in exclude:
        out += telegraphs(state, out)
    out.sort(key=lambda w: -w.evidence)
    return out


def _worth_fitting(items, state):
    """Without those that the screening has left far behind; a resonance only where it beats every
    simpler noise.
    """
    if not items:
        return items
    # the screening of a changed parameter is a local slope, which promises too much
    best = max([i.note["screen"] for i in items if i.base_index is None], default=0.0)
    simple = max(
        [
            i.note["screen"]
            for i in items
            if i.name != "low_pass" and (i.slot is None or len(i.slot.names) < 3)
        ],
        default=0.0,
    )
    resonant = any(i.name == "autoregressive" for i in state.items)
    return [
        i
        for i in items
        if i.note["screen"] >= 0.35 * best - 15
        and not (
            i.name == "autoregressive"
            and (resonant or len(i.slot.names) > 2 and i.note["screen"] < simple + 3)
        )
    ]


def telegraphs(state: State, weighed) -> list[Weighed]:
    """Two levels instead of the noises that would otherwise explain a red spectrum."""
    starts = []
    data = state.cleaned
    for w in weighed:
        if w.gain < 8 or w.item.name not in (
            "gauss_markov",
            "flicker",
            "random_walk",
            "step",
            "warm_up",
            "ramp",
            "gauss_markov_2",
            "parameter_change",
        ):
            continue
        if w.item.name == "gauss_markov":
            process = w.state.fit.terms[len(state.fit.terms)]
            rate = 0.5 / process.correlation_time
            if rate > data.fs / DWELL:
                continue
            starts += [(2 * process.sigma, rate), (2 * process.sigma, 0.4 * rate)]
        elif len(starts) < 4:
            sd = np.std(data.means)
            starts += [(2 * sd, 10 / data.duration), (2 * sd, 60 / data.duration)]
    if not starts:
        return []
    effect = effects.CATALOGUE["telegraph"]
    # before a filter, which takes nothing from a dwell
    s = measured(fast.spectrum(state.fit.terms, None, data.layout, data.fs), data.extra)[
        data.layout.slow :
    ]
    density = min(float(np.median(s[:40])), float(np.median(s))) / 2
    quick = {"white_noise", "quantization", "autoregressive", "common_mode"}
    drift = [t for t in state.fit.terms if t.name not in quick]

    def gain(size, rate):
        if not drift:
            return np.zeros(size // 2 + 1)
        f = np.maximum(np.arange(size // 2 + 1), 0.5) * rate / size
        d = sum(t.psd(f) for t in drift)
        return d / (d + 2 * density)

    best = None
    x = data.x
    if len(state.fit.beta):
        t = np.arange(data.n) / data.fs
        x = x - sum(
            b * i.process.mean(t, data.temperature)
            for b, i in zip(state.fit.beta, state.column_items)
        )
    for amplitude, rate in starts[:6]:
        start = effect.process(amplitude=float(amplitude), rate=float(max(rate, 2 / data.duration)))
        found = effect.decode(x, data.fs, start, density, gain if drift else None)
        if found is None:
            continue
        process, signal, flips, beyond, sd = found
        if flips < 2.5 or process.amplitude <= 0:
            continue
        occam = amplitude_occam(process.amplitude / sd) + np.log(
            np.sqrt(2 * np.pi / max(flips, 1)) / np.log(1e4)
        )
        note = {"flips": flips, "sd": sd}
        trial = state.plus(Item("telegraph", process, signal=signal, note={**note, "ll": 0.0}))
        alike = state.holding(process.twin)
        item = Item(
            "telegraph",
            process,
            signal=signal,
            bonus=float(alike.evidence - trial.evidence + beyond + occam),
            note={**note, "ll": float(alike.ll - trial.ll + beyond)},
        )
        trial = state.plus(item)
        w = Weighed(item, trial, trial.evidence - state.evidence, trial.ll - state.ll)
        if best is None or w.evidence > best.evidence:
            best = w
    return [best] if best is not None else []


def grow(state: State, *, most: int = 5, exclude=(), progress=None) -> tuple[State, list]:
    """Rounds until nothing is worth adding: the grown state and [(winner, all candidates of that
    round)].
    """
    history = []
    for _ in range(most):
        weighed = weigh(state, exclude=exclude)
        best = next((w for w in weighed if w.evidence > EVIDENCE and w.gain > GAIN), None)
        if best is None:
            break
        state = retuned(best.state).settled()
        history.append((best, weighed))
        if progress:
            progress(best.item.name)
    return state, history


def prune(state: State) -> State:
    """Drop the items that the others have made superfluous."""
    while state.items:
        worth = []
        for i in range(len(state.items)):
            without = retuned(state.with_items(state.items[:i] + state.items[i + 1 :]))
            worth.append((state.evidence - without.evidence, i, without))
        least = min(worth, key=lambda w: w[0])
        if least[0] > EVIDENCE:
            break
        state = least[2].settled()
    return state


def swap(state: State, *, exclude=(), passes: int = 2, reach: float = REACH) -> tuple[State, list]:
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
            weighed = [w for w in weigh(without, exclude=exclude) if w.item.key != item.key]
            own = state.evidence - without.evidence
            if weighed and weighed[0].evidence > own + 0.5:
                state, changed = retuned(weighed[0].state).settled(), True
                break
            others = {}
            for w in weighed:
                others[w.item.key] = max(others.get(w.item.key, -np.inf), w.evidence - own)
            two = _by_two(weighed, own, item, exclude, reach)
            if two is not None and two[0] > EVIDENCE + 0.5:
                state, changed = retuned(two[1].state).settled(), True
                break
            if two is not None:
                others[two[2]] = max(others[two[2]], two[0])
            others[""] = -own  # nothing at all in its place
            rivals.append(others)
        if not changed:
            return state, rivals
    return state, [{} for _ in state.items] if changed else rivals


def _by_two(weighed, own, item, exclude, reach):
    """The best two other effects in the place of `item`: (log evidence relative to it, second of
    the two, key of the first), or None.

    A sum of two noises looks like a third: a slow and a fast one like flicker.
    """
    best = None
    for w in weighed[:REPLACED]:
        if w.evidence < max(own - reach, EVIDENCE) or w.item.slot is None and w.item.column is None:
            continue
        more = next(
            (
                v
                for v in weigh(w.state.settled(), exclude=(*exclude, "telegraph"))
                if v.gain > GAIN and v.evidence > EVIDENCE
            ),
            None,
        )
        if more is None or more.item.key == item.key:
            continue
        total = w.evidence + more.evidence - own
        if best is None or total > best[0]:
            best = (total, more, w.item.key)
    return best


def confidence(rivals: dict) -> tuple[float, dict]:
    """Posterior weight of the item and of each rival."""
    keys = [k for k in rivals]
    values = np.array([0.0] + [rivals[k] for k in keys]) / TEMPER
    weight = np.exp(values - values.max())
    weight /= weight.sum()
    return float(weight[0]), {k: float(w) for k, w in zip(keys, weight[1:])}


def explains_as_telegraph(state: State, item: Item) -> bool:
    """Whether a telegraph of the same spectrum would look the same, its dwells being lost in the
    noise.
    """
    if item.name != "gauss_markov":
        return False
    at = len(state.base) + state.noise_items.index(item)
    process, others = state.fit.terms[at], [t for k, t in enumerate(state.fit.terms) if k != at]
    noise = (
        sum(
            float(t.psd(np.array([0.5 / (np.pi * process.correlation_time)]), state.data.fs)[0])
            for t in others
        )
        / 2
    )
    # beside a drift the likelihood of two levels is a lower bound, short by some tens
    drift = any(not t.fast and t.name != "common_mode" for t in others)
    return bool(
        2 * process.sigma**2 * process.correlation_time / noise
        < (BURIED_IN_DRIFT if drift else BURIED)
    )
