"""Does an effect hold in time that it was not fitted to? What the first part of the record shows is
held against the rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.data import Data
from imu_lib.gap.grown import FITTED
from imu_lib.gap.state import State
from imu_lib.likelihood.problem import Problem

#: Log-likelihood of the rest that an effect may cost there: two parameters fitted to one and a half
#: times as much as the rest cost it 2/3 on average where they are right, with a spread of 1.
COSTS = 4.0


#: A line that was found, and what it puts into the samples.
Line = tuple[Any, np.ndarray]


def lasting(state: State) -> list[bool]:
    """Whether each item is worth keeping in the part of the record that did not fit it.

    What happens at a time of its own (drifts, two levels) is taken out first and kept: the rest of
    the record says nothing of it.
    """
    noises = [i for i in state.items if i.column is None and i.signal is None]
    if not noises:
        return [True] * len(state.items)
    first, rest = _halves(state)
    whole = State(
        first, state.base, noises, low_pass=state.base_low_pass, base_slots=state.base_slots
    )
    value = _foretold(whole, rest)
    return [
        item not in noises or _foretold(whole.without(item), rest) < value + COSTS
        for item in state.items
    ]


def _halves(state: State) -> tuple[Data, Data]:
    """The first and the last part of the record, without what happens at a time of its own."""
    data, x = state.data, state.data.x - state.deterministic
    cut = int(FITTED * data.n)
    return data.part(x[:cut], slice(cut)), data.part(x[cut:], slice(cut, None))


def _foretold(state: State, rest: Data) -> float:
    """Log-likelihood of the rest under what was fitted to the first part."""
    fit = state.fit
    problem = Problem(rest.stats, fit.terms, low_pass=fit.low_pass, extra=rest.extra)
    return problem.loglike(np.zeros(0))


def steady(lines: list[Line], cleaned: Data, data: Data) -> tuple[list[Line], Data]:
    """Of the lines (finding, signal) that were taken out of `data` those whose first part foretells
    the rest, and the cleaned data with the others back in it.
    """
    kept = [_foretells(finding.process, data.x, data.fs) for finding, _ in lines]
    for (_, signal), keep in zip(lines, kept):
        if not keep:
            cleaned = cleaned.minus(-signal)
    return [line for line, keep in zip(lines, kept) if keep], cleaned


def _foretells(process: Any, x: Array, fs: float) -> bool:
    """Whether the line as fitted to the first part lessens the power at its frequency in the
    rest.
    """
    t = np.arange(len(x)) / fs
    cut = int(FITTED * len(x))
    turn = np.exp(-2j * np.pi * process.frequency * t)
    early, late = (
        np.mean(turn[part] * (x[part] - np.mean(x[part])))
        for part in (slice(cut), slice(cut, None))
    )
    return bool(abs(late - early) < abs(late))


def without(state: State, rivals: list[Any], kept: list[bool]) -> tuple[State, list[Any]]:
    """The state and the rivals of its items, of those items that are kept."""
    if all(kept):
        return state, rivals
    items = [i for i, keep in zip(state.items, kept) if keep]
    fewer = state.with_items(items).settled()
    return fewer, [r for r, keep in zip(rivals, kept) if keep]
