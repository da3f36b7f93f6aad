"""A model of a clean channel in the competition: held base terms, candidates that entered, and
their joint fit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.drifts import scanner
from imu_lib.gap.screening import Screening
from imu_lib.likelihood.evidence import Maximum, maximum
from imu_lib.likelihood.problem import Problem
from imu_lib.likelihood.regressors import Regressors
from imu_lib.likelihood.slot import Slot
from imu_lib.processes import LowPass
from imu_lib.samples.blocks import statistics

#: What an effect has to add to the evidence and to the log-likelihood: odds of 20 to 1, and a gain
#: that one parameter reaches by chance once in 45,000 times, for the hundreds that are looked at.
#: With both, none of 939 channels in which nothing is hidden has a name or is left unexplained
#: (benchmarks/results/gap_null_wide.json, gap_null_wide_free.json).
MIN_EVIDENCE, MIN_LIKELIHOOD = 3.0, 9.0
#: Evidences are divided by this before they become weights: no catalogue is complete and no record
#: exactly of its model. How sure a name is hangs on it where there are several rivals; beside one,
#: the calibration behind it (`reliability.calibrated`, benchmarks/gap_reliability.py) makes up for
#: it: together they divide by 2.5.
TEMPER = 1.5


class State:
    """A model of a clean channel: held base terms, candidates, and the fit of all free parameters
    together. What follows from it is computed when it is first asked for.
    """

    def __init__(
        self,
        data: Data,
        base: Iterable[Any],
        items: Iterable[Candidate] = (),
        *,
        low_pass: LowPass | None = None,
        base_slots: Iterable[Slot] = (),
    ) -> None:
        self.data, self.base, self.items = data, tuple(base), tuple(items)
        self.base_low_pass, self.base_slots = low_pass, tuple(base_slots)

    # -- neighbours ------------------------------------------------------------------------------
    def with_items(self, items: Iterable[Candidate]) -> State:
        return State(
            self.data, self.base, items, low_pass=self.base_low_pass, base_slots=self.base_slots
        )

    def holding(self, *terms: Any) -> State:
        """The state with further terms in its base, their parameters held."""
        return State(
            self.data,
            self.base + terms,
            self.items,
            low_pass=self.base_low_pass,
            base_slots=self.base_slots,
        )

    def plus(self, item: Candidate) -> State:
        return self.with_items(self.items + (item,))

    def without(self, item: Candidate) -> State:
        return self.with_items([i for i in self.items if i is not item])

    def settled(self) -> State:
        """The state with its candidates at their fitted values, so that a further fit starts
        there.
        """
        base = list(self.base)
        for s in self.base_slots:
            base[s.index] = self.fit.terms[s.index]
        out = State(
            self.data,
            base,
            [c.effect.settled(self, c) for c in self.items],
            low_pass=self.base_low_pass,
            base_slots=self.base_slots,
        )
        # the maximum is the same
        out.__dict__.update(fit=self.fit, problem=self.problem)
        return out

    # -- the fit ---------------------------------------------------------------------------------
    @cached_property
    def assembly(self) -> Assembly:
        """Terms, free parameters, filter and columns."""
        out = Assembly(self.base, self.base_slots, self.base_low_pass)
        for c in self.items:
            c.effect.enter(out, c)
        return out

    @cached_property
    def cleaned(self) -> Data:
        """The record without the signals that were taken out (telegraphs)."""
        data = self.data
        for c in self.items:
            if c.signal is not None:
                data = data.minus(c.signal)
        return data

    @cached_property
    def regressors(self) -> Regressors | None:
        """The columns of the drifts held against the record, or None."""
        matrix = self.assembly.matrix
        return None if matrix is None else self.cleaned.stats.regressors_of(matrix)

    @cached_property
    def problem(self) -> Problem:
        """What the fit is the maximum of."""
        data, made = self.cleaned, self.assembly
        options: dict[str, Any] = {
            "low_pass": made.low_pass,
            "extra": data.extra,
            "regressors": self.regressors,
        }
        problem = Problem(data.stats, made.terms, made.slots.values(), **options)
        sharp = [i for i, c in enumerate(made.columns) if "edge" in c.note]
        if not sharp or self.regressors is None:
            return problem
        beta, _ = self.regressors.solve(problem.density(problem.start()))
        t = np.arange(data.n) / data.fs
        signal = sum(beta[i] * made.columns[i].process.mean(t) for i in sharp)
        stats = data.stats.with_fast(statistics(data.x - signal, data.fs))
        return Problem(stats, made.terms, made.slots.values(), **options)

    @cached_property
    def fit(self) -> Maximum:
        return maximum(self.problem)

    @property
    def mean_power(self) -> np.ndarray:
        """Mean ordinate of each band without what the fit knows of drifts, (b,)."""
        return self.fit.remaining / np.maximum(self.problem.stats.count, 1e-300)

    def free(self, place: int) -> tuple[Slot, Array]:
        """(slot of the term at `place`, where its parameters stand in the fit's vector)."""
        at = 0
        for slot in self.fit.slots:
            if slot.index == place:
                return slot, at + np.arange(len(slot.names))
            at += len(slot.names)
        raise KeyError(place)

    def amplitude(self, drift: Candidate) -> tuple[float, float]:
        """Fitted amplitude of a drift and its standard deviation."""
        k = self.assembly.place(drift)
        return float(self.fit.beta[k]), float(np.sqrt(max(self.fit.beta_cov[k, k], 1e-300)))

    @cached_property
    def drift(self) -> np.ndarray:
        """The fitted drifts, shape (n,)."""
        data, t = self.data, np.arange(self.data.n) / self.data.fs
        out = np.zeros(data.n)
        for b, c in zip(self.fit.beta, self.assembly.columns):
            out += b * c.process.mean(t, data.temperature)
        return out

    @property
    def deterministic(self) -> np.ndarray:
        """Drifts and the signals of telegraphs, shape (n,)."""
        return self.drift + sum((c.signal for c in self.items if c.signal is not None), 0.0)

    # -- what it is worth ------------------------------------------------------------------------
    @cached_property
    def evidence(self) -> float:
        """Log evidence: Laplace's of the fit, and what each candidate knows beyond it."""
        return self.fit.evidence + sum(c.bonus + c.effect.log_prior(self, c) for c in self.items)

    @property
    def ll(self) -> float:
        """Log-likelihood, with what the likelihood of the record does not hold."""
        return self.fit.ll + sum(c.gain for c in self.items)

    # -- looks at what is left -------------------------------------------------------------------
    @cached_property
    def screening(self) -> Screening:
        """What a further noise would gain."""
        return Screening(self)

    @cached_property
    def scan(self) -> Callable[..., tuple[Array, Array, Array]]:
        """What a further drift would gain."""
        return scanner(self, self.assembly.matrix)

    @property
    def drifts(self) -> list[Candidate]:
        """The candidates that add a column to the regression."""
        return [c for c in self.items if c.column is not None]
