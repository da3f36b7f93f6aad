"""What the search found, as the steps of the report: names, parameters, intervals, where."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.model import Model

from . import columns, posterior, random_effects, regression, select
from .battery import Battery, battery
from .effects import CATALOGUE, LINEAR
from .left import APART, smoothed_delay

if TYPE_CHECKING:
    from .problem import Innovations, Noise
    from .state import Change, State

Step = dict[str, Any]

SUREST = 0.999  # no weight above this is claimed
ALIKE = 3.0  # nats


def step(
    effect: str,
    values: tuple[dict[str, Any], dict[str, Any]],
    weight: float,
    runner: dict[str, Any],
    alike: Iterable[str],
    gaps: tuple[float, float],
    gain: float,
    where: str | None = None,
) -> Step:
    """A step; values: its parameters and intervals; weight: of the name among its rivals, of which
    `reliability` makes the confidence.
    """
    return {
        "effect": effect,
        "parameters": values[0],
        "intervals": values[1],
        "where": where or CATALOGUE[effect].words,
        "cause": CATALOGUE[effect].cause,
        "weight": float(min(weight, SUREST)),
        "confidence": float(min(weight, SUREST)),
        "runner_up": runner,
        "indistinguishable": list(alike),
        "gap_before": float(gaps[0]),
        "gap_after": float(gaps[1]),
        "log_likelihood_gain": float(gain),
    }


def of(
    state: State, first: State, noise: Noise, rng: np.random.Generator, before: Battery
) -> list[Step]:
    """Steps of the linear effects and of the changes of what is random, the largest gain first."""
    kept = [e for e in state.kept if e in LINEAR]
    if smoothed_delay(state) is not None:
        kept.remove("gnss_time_offset")
    index = [i for e in state.kept for i in columns.GROUPS[e]]
    total = state.reg.solve(index)[2]
    values, sd = (dict(zip(index, found)) for found in state.reg.told(index))
    # one that would be larger than its name allows is held at nothing
    kept = [e for e in kept if any(values[i] for i in columns.GROUPS[e])]
    names = [n for n in columns.GROUPS if n not in state.kept]
    sure = select.confidence(state.reg, state.kept, names, state.apart)
    out: list[Step] = []
    gap = before.index
    gains = {
        e: total - state.reg.solve([i for k in state.kept if k != e for i in columns.GROUPS[k]])[2]
        for e in kept
    }
    done = [e for e in state.kept if e not in kept]
    plain = state.problem.evaluate(first.noise, sens=True, use=state.use)
    reg = regression.of(state.problem, plain, state.theta, state.use)
    for effect in sorted(kept, key=gains.__getitem__, reverse=True):
        done.append(effect)
        after = _gap_with(state, plain, reg, done, rng)
        part = LINEAR[effect].columns
        now = np.array([values[i] for i in part])
        confidence, second, chance, rivals = sure[effect]
        top = select.score_of(state.reg, state.kept)
        alike = [e for e, v in rivals.items() if top - v < ALIKE and e in LINEAR]
        parameters = LINEAR[effect].parameters(now)
        intervals = LINEAR[effect].intervals(now, np.array([sd[i] for i in part]))
        if effect == "gnss_time_offset":
            parameters, intervals = _one_offset(state, index, (values, sd), parameters, intervals)
        out.append(
            step(
                effect,
                (parameters, intervals),
                confidence,
                {"effect": second, "confidence": float(chance)},
                alike,
                (gap, after),
                gains[effect] * state.reg.temper,
            )
        )
        gap = after
    original = noise.model
    for found in sorted(state.changes, key=lambda c: -c.gain):
        noise = found.change.enter(noise, found.values)
        result = state.evaluate(noise)
        after = battery(state.problem, result.e, state.use, rng).index
        if not usual(state, found):
            out.append(_random_step(state, found, original, (gap, after)))
        gap = after
    return out


#: Ratios of errors of fixes to the stated ones within which a receiver knows them well.
KNOWN_WELL = (0.8, 1.25)


def usual(state: State, found: Change) -> bool:
    """Whether a change is the size of errors of which the file states none, or states nearly the
    right one, or has no name in the catalogue: fitted, and no finding.
    """
    if found.change.effect not in CATALOGUE:
        return True
    if found.change.effect != "gnss_noise":
        return False
    nearly = KNOWN_WELL[0] < float(found.values[0]) < KNOWN_WELL[1]
    return nearly or getattr(state.problem.drive, f"gnss_{found.change.key[1]}_sd") is None


def _one_offset(
    state: State,
    index: list[int],
    known: tuple[dict[int, float], dict[int, float]],
    parameters: dict[str, Any],
    intervals: dict[str, Any],
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The time offset as one number, unless the velocity clearly has one of its own; known: values
    and standard deviations by column.
    """
    values, sd = known
    a, b = columns.of("gnss_time_offset")
    if not state.use[:, 3].any():
        return {"offset": parameters["offset"]}, {"offset": intervals["offset"]}
    _, cov, _ = state.reg.solve(index)
    i, j = index.index(a), index.index(b)
    wider = np.array([sd[a], sd[b]]) / np.sqrt(np.diag(cov)[[i, j]])
    pair = cov[np.ix_([i, j], [i, j])] * np.outer(wider, wider)
    apart = values[b] - values[a]
    if abs(apart) > APART * np.sqrt(pair[0, 0] + pair[1, 1] - 2 * pair[0, 1]):
        return parameters, intervals
    weight = np.linalg.solve(pair, np.ones(2))
    one = float(weight @ [values[a], values[b]] / weight.sum())
    half = 1.96 / float(np.sqrt(weight.sum()))
    return {"offset": one}, {"offset": [one - half, one + half]}


def _gap_with(
    state: State,
    plain: Innovations,
    reg: regression.Regression,
    effects: Sequence[str],
    rng: np.random.Generator,
) -> float:
    """Gap index with the linear effects given, at the path as it is."""
    index = [i for e in effects for i in columns.GROUPS[e]]
    x, _, _ = reg.solve(index)
    theta = np.zeros(len(columns.ALL))
    theta[index] = x
    e = plain.e + np.einsum("fkp,p->fk", np.asarray(plain.jac), state.theta - theta)
    return battery(state.problem, e, state.use, rng).index


def _random_step(state: State, found: Change, first: Model, gaps: tuple[float, float]) -> Step:
    """The step of a change of what is random; first: the model as it was given."""
    change = found.change
    intervals = posterior.intervals(state, found)
    parameters = change.describe(found.values)
    if change.effect == "bias_model":
        parameters = {
            "channel": parameters["channel"], "process": parameters["process"],
            "name": parameters["name"], "from": _stated(first, parameters), "to": parameters["to"],
        }  # fmt: skip
    prices = random_effects.penalty(change)
    rivals = [(e, v) for e, v, key in found.rivals if e != change.effect or key[0] == "bias_model"]
    weights = [np.exp(min(v, 0.0)) for _, v in rivals] + [np.exp(-max(found.gain - prices, 0.0))]
    names = [e for e, _ in rivals] + ["nothing"]
    total = 1.0 + sum(weights)
    k = int(np.argmax(weights))
    alike = sorted({e for (e, v) in rivals if v > -ALIKE and e != change.effect})
    return step(
        change.effect, (parameters, intervals), 1.0 / total,
        {"effect": names[k], "confidence": float(weights[k] / total)}, alike, gaps, found.gain,
    )  # fmt: skip


def _stated(model: Model, parameters: Mapping[str, Any]) -> float | None:
    """The value of a process's parameter in the model as it was given."""
    for process in model[parameters["channel"]].terms:
        if process.name == parameters["process"]:
            return float(getattr(process, parameters["name"]))
    return None
