"""A parameter of the given model that the record would have otherwise."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.data import SCREEN
from imu_lib.gap.state import State
from imu_lib.likelihood.problem import Problem
from imu_lib.likelihood.slot import Slot
from imu_lib.processes import CommonMode, Parameter, Process

from .base import Effect
from .competitor import Competitor, factor

if TYPE_CHECKING:
    from imu_lib.gap.absorbed import FreeBase

#: A change of a held parameter is log-normal, half of the time within a factor of two or so, else
#: of any size: shares and standard deviations of the two (the width is what the fit assumes first).
CHANGE_WIDTH, CHANGES = 2 * np.log(10.0), ((0.5, 0.5), (0.5, 2.0))
#: Logarithms of the factors by which a time constant is tried beside its own.
TIMES_TRIED = np.array([-4.5, -3.4, -2.3, -1.2, 1.2, 2.3])


#: Confidence at the most in a name that the make of another effect would explain as well.
HALF = 0.5
#: Part of the shared noise's variance by which its estimate may be off.
SHARED = 0.1


def elsewhere(term: Process) -> bool:
    """Whether a term is settled before the competition: noise in common on the record, a rounded
    integral by its grid.
    """
    return isinstance(term, CommonMode) or bool(getattr(term, "rounded", None))


def _changed(candidate: Candidate) -> tuple[int, Slot]:
    """Index of the term that a candidate changes, and its free parameter."""
    assert candidate.at is not None and candidate.slot is not None, "it frees one of a term"
    return candidate.at, candidate.slot


class ParameterChange(Competitor):
    name = "parameter_change"
    order = 90
    cause = (
        "A parameter of the given model does not hold for this unit, this day or this environment."
    )
    red = True

    def candidates(self, state: State) -> list[Candidate]:
        free, taken = {s.index for s in state.base_slots}, {c.key for c in state.items}
        out = []
        for index, term in enumerate(state.base):
            if index in free or elsewhere(term) or term.deterministic:
                continue
            for p in term.parameters:
                known = f"{self.name}:{index}:{p.name}" in taken
                if known or p.kind not in ("amplitude", "time", "rate"):
                    continue
                if getattr(term, p.name) > 0:
                    out += self._screened(state, index, p)
        return out

    def _screened(self, state: State, index: int, parameter: Parameter) -> list[Candidate]:
        value = np.log(getattr(state.base[index], parameter.name))
        # a time constant beyond a third of the record is not seen
        most = np.log(state.data.duration / 3)
        most = max(value + 0.1, most) if parameter.kind == "time" else np.inf
        slot = Slot(
            index, (parameter.name,), (value - 9.0,), (min(value + 9.0, most),), (CHANGE_WIDTH,)
        )
        if index in state.assembly.slots:
            return [Candidate(self, None, slot, at=index, screen=SCREEN)]
        problem = Problem(
            state.problem.stats,
            state.fit.terms,
            (slot,),
            low_pass=state.fit.low_pass,
            extra=state.problem.extra,
            regressors=state.regressors,
        )
        x = problem.start()
        now, g, info = problem.score(x)
        screened = 0.5 * g[0] ** 2 / max(info[0, 0], 1e-12)
        if parameter.kind == "time":
            # a time far from the given one is not seen from its slope there
            trials = np.clip(x + TIMES_TRIED, slot.low[0], slot.high[0])
            values = [problem.loglike(np.array([v])) for v in trials]
            gain = max(values) - now
            if gain > max(screened, SCREEN):
                there = float(np.exp(trials[int(np.argmax(values))]))
                moved = state.fit.terms[index].with_(**{parameter.name: there})
                return [Candidate(self, moved, slot, at=index, screen=gain)]
        if screened < 0.75 * SCREEN:
            return []
        return [Candidate(self, None, slot, at=index, screen=screened)]

    def absorbed(self, base: FreeBase) -> bool:
        return True  # its parameters are free

    def of_differences(self, parameters: dict[str, Any]) -> bool:
        return parameters["name"] in ("N", "Q")

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        """Where an angle or a velocity is rounded instead of the sample, its errors are
        differenced, and N stands for the white noise that the grid then lacks; the density of
        `shared` noise is known to some per cent, and a channel's own N makes up for the rest.
        """
        if parameters["name"] != "N":
            return 1.0
        moved = abs(parameters["to"] ** 2 - parameters["from"] ** 2)
        return HALF if sum(e.rounds for e in beside) > 1 or moved < SHARED * shared**2 else 1.0

    def enter(self, assembly: Assembly, candidate: Candidate) -> None:
        assembly.free(candidate)

    def settled(self, state: State, candidate: Candidate) -> Candidate:
        return replace(candidate, process=state.fit.terms[_changed(candidate)[0]])

    def log_prior(self, state: State, candidate: Candidate) -> float:
        at, slot = _changed(candidate)
        name = slot.names[0]
        old, new = (getattr(t[at], name) for t in (state.base, state.fit.terms))
        change = np.log(new / old)
        density = sum(share / sd * np.exp(-0.5 * (change / sd) ** 2) for share, sd in CHANGES)
        return float(np.log(CHANGE_WIDTH / np.sqrt(2 * np.pi) * density))

    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        index, changed = _changed(candidate)
        process, name = state.fit.terms[index], changed.names[0]
        value, old = getattr(process, name), getattr(state.base[index], name)
        slot, at = state.free(index)
        k = at[slot.names.index(name)]
        sd = np.sqrt(max(state.fit.cov[k, k], 0.0))
        parameters = {"process": process.name, "name": name, "from": old, "to": value}
        return parameters, {"to": factor(value, sd)}


EFFECTS = (ParameterChange(),)
