"""An effect that may enter a channel's model, and the model while it is put together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.likelihood.slot import FILTER, Slot
from imu_lib.processes import LowPass


@dataclass(frozen=True)
class Candidate:
    """An effect with where it starts from.

    Attributes
    ----------
    effect : effects.Competitor
    process
        The process or stage to start from; of a drift, with amplitude 1.
    slot : Slot, optional
        Its free parameters.
    column : ndarray, shape (orders,), optional
        Its cosine coefficients, a column of the regression.
    signal : ndarray, shape (n,), optional
        What it takes out of the record.
    at : int, optional
        Index of the base term whose parameter it changes.
    screen : float
        Gain in log-likelihood that a cheap look promises.
    bonus, gain : float
        Log evidence and log-likelihood that the likelihood of the record does not hold.
    note : dict
        What the effect wants to remember.
    """

    effect: Any  # effects.Competitor, which is made of candidates
    process: Any = None
    slot: Slot | None = None
    column: np.ndarray | None = None
    signal: np.ndarray | None = None
    at: int | None = None
    screen: float = 0.0
    bonus: float = 0.0
    gain: float = 0.0
    note: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The effect's name in the report."""
        return str(self.effect.name)

    @property
    def key(self) -> str:
        """Which of several of its kind it is."""
        if self.at is None or self.slot is None:
            return str(self.effect.key)
        return f"{self.name}:{self.at}:{self.slot.names[0]}"

    @property
    def form(self) -> tuple[str, ...]:
        """Its key, and which optional parameters it has: a temperature with a curvature is of
        another form than one without.
        """
        parameters = () if self.process is None else self.process.parameters
        given = (
            p.name for p in parameters if p.optional and getattr(self.process, p.name) is not None
        )
        return (self.key, *given)


class Assembly:
    """Terms, free parameters, filter and regression columns of a model, into which each candidate
    enters in turn.
    """

    def __init__(
        self, base: Iterable[Any], base_slots: Iterable[Slot], low_pass: LowPass | None
    ) -> None:
        self.terms, self.low_pass = list(base), low_pass
        self.slots = {slot.index: slot for slot in base_slots}
        self.columns: list[Candidate] = []
        self._places: dict[int, int] = {}

    def add_noise(self, candidate: Candidate) -> None:
        """A further term, its parameters free."""
        assert candidate.slot is not None, "a noise has free parameters"
        place = self._places[id(candidate)] = len(self.terms)
        self.slots[place] = replace(candidate.slot, index=place)
        self.terms.append(candidate.process)

    def add_column(self, candidate: Candidate) -> None:
        """A further column of the regression."""
        self._places[id(candidate)] = len(self.columns)
        self.columns.append(candidate)

    def set_filter(self, candidate: Candidate) -> None:
        """The sensor's filter, its cutoff free where it has one."""
        self._places[id(candidate)] = FILTER
        self.low_pass = candidate.process
        if candidate.slot is not None:
            self.slots[FILTER] = candidate.slot

    def free(self, candidate: Candidate) -> None:
        """A parameter of a held term, which starts at the value of an earlier fit."""
        at, slot = candidate.at, candidate.slot
        assert at is not None and slot is not None, "a term and what is free of it"
        self._places[id(candidate)] = at
        if candidate.process is not None:
            name = slot.names[0]
            self.terms[at] = self.terms[at].with_(**{name: getattr(candidate.process, name)})
        old = self.slots.get(at)
        if old is None:
            self.slots[at] = slot
        elif slot.names[0] not in old.names:  # two parameters of one process
            self.slots[at] = Slot(
                at,
                old.names + slot.names,
                old.low + slot.low,
                old.high + slot.high,
                old.widths + slot.widths,
            )

    def place(self, candidate: Candidate) -> int:
        """Index of its term, or of its column."""
        return self._places[id(candidate)]

    @property
    def matrix(self) -> Array | None:
        """The columns, shape (orders, columns), or None."""
        columns = [c.column for c in self.columns if c.column is not None]
        return np.column_stack(columns) if columns else None
