"""A model of a clean channel in the competition: held base terms, items that were added, and their
joint fit.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from imu_lib.gap import effects
from imu_lib.gap.engine import Data, Fit, Likelihood, Slot

#: What an effect has to add to the evidence and to the log-likelihood (calibrated on null records,
#: benchmarks/gap_null.py).
EVIDENCE, GAIN = 3.0, 9.0
#: A change of a held parameter is log-normal, half of the time within a factor of two or so, else
#: of any size: shares and
#: standard deviations of the two (the width is what the fit assumes first).
CHANGE_WIDTH, CHANGES = 2 * np.log(10.0), ((0.5, 0.5), (0.5, 2.0))


@dataclass(frozen=True)
class Item:
    """An effect in the model: a noise with free parameters, a drift (`process` of amplitude 1), a
    filter or a changed parameter.

    `key` names it ("gauss_markov", "parameter_change:0:N"), `slot` its free parameters with an
    index into the terms that
    the state fills in, `signal` a deterministic signal already taken out of the record
    (telegraph), `bonus` a log
    evidence that the likelihood of the cleaned record does not hold.
    """

    key: str
    process: object = None
    slot: Slot | None = None
    column: np.ndarray | None = None
    base_index: int | None = None
    signal: np.ndarray | None = None
    bonus: float = 0.0
    note: dict = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.key.split(":")[0]

    @property
    def effect(self):
        return next(
            (e for e in effects.DRIFTS if e.key == self.key), effects.CATALOGUE.get(self.name)
        )


class State:
    """A model of a clean channel: held base terms, items, and the fit of all free parameters
    together.
    """

    def __init__(self, data: Data, base, items=(), *, low_pass=None, base_slots=(), start=None):
        self.data, self.base, self.items, self.base_low_pass = (
            data,
            tuple(base),
            tuple(items),
            low_pass,
        )
        self.base_slots = tuple(base_slots)
        self._fit, self._start = None, start

    def with_items(self, items) -> State:
        return State(
            self.data, self.base, items, low_pass=self.base_low_pass, base_slots=self.base_slots
        )

    def holding(self, *terms) -> State:
        """The state with further terms in its base, their parameters held."""
        return State(
            self.data,
            self.base + terms,
            self.items,
            low_pass=self.base_low_pass,
            base_slots=self.base_slots,
        )

    def plus(self, item: Item) -> State:
        return self.with_items(self.items + (item,))

    def assemble(self):
        """(terms, slots, low_pass, columns, column items) of the likelihood."""
        terms, slots, low_pass, columns = list(self.base), {}, self.base_low_pass, []
        for s in self.base_slots:
            slots[s.index] = s
        for item in self.items:
            if item.column is not None:
                columns.append(item)
            elif item.name == "low_pass":
                low_pass = item.process
                if item.slot is not None:
                    slots[-1] = item.slot
            elif item.base_index is not None:
                # the value of an earlier fit is where this one starts
                if item.process is not None:
                    name = item.slot.names[0]
                    terms[item.base_index] = terms[item.base_index].with_(
                        **{name: getattr(item.process, name)}
                    )
                if item.base_index in slots:  # two parameters of one process
                    old = slots[item.base_index]
                    if item.slot.names[0] not in old.names:
                        slots[item.base_index] = Slot(
                            old.index,
                            old.names + item.slot.names,
                            old.low + item.slot.low,
                            old.high + item.slot.high,
                            old.widths + item.slot.widths,
                        )
                else:
                    slots[item.base_index] = item.slot
            elif item.slot is not None:
                slots[len(terms)] = replace(item.slot, index=len(terms))
                terms.append(item.process)
        matrix = np.column_stack([i.column for i in columns]) if columns else None
        return terms, tuple(slots[k] for k in slots), low_pass, matrix, columns

    @property
    def noise_items(self) -> list:
        """The items that add a noise to the base, in the order of the terms behind it."""
        return [
            i
            for i in self.items
            if i.slot is not None
            and i.base_index is None
            and i.column is None
            and i.name != "low_pass"
        ]

    @property
    def drifts(self) -> list:
        """The items that add a column to the regression."""
        return [i for i in self.items if i.column is not None]

    @property
    def cleaned(self) -> Data:
        """The record without the signals that were taken out (telegraphs)."""
        data = self.data
        for item in self.items:
            if item.signal is not None:
                data = data.minus(item.signal)
        return data

    @property
    def fit(self) -> Fit:
        if self._fit is None:
            data = self.cleaned
            terms, slots, low_pass, columns, column_items = self.assemble()
            sharp = [
                i
                for i, item in enumerate(column_items)
                if item.effect.sharp and "edge" in item.note
            ]
            likelihood = Likelihood(
                data, terms, slots, low_pass=low_pass, columns=columns, power=None
            )
            if sharp:
                _, beta, _ = likelihood.value(likelihood.start())
                t = np.arange(data.n) / data.fs
                signal = sum(beta[i] * column_items[i].process.mean(t) for i in sharp)
                power = Data(data.x - signal, data.fs, white=data.white).power
                likelihood = Likelihood(
                    data, terms, slots, low_pass=low_pass, columns=columns, power=power
                )
            self._likelihood, self._column_items = likelihood, column_items
            self._fit = likelihood.maximise()
        return self._fit

    @property
    def likelihood(self) -> Likelihood:
        """What the fit is the maximum of."""
        self.fit  # noqa: B018
        return self._likelihood

    @property
    def column_items(self) -> list:
        """The items whose amplitudes are `fit.beta`."""
        self.fit  # noqa: B018
        return self._column_items

    @property
    def evidence(self) -> float:
        fit = self.fit
        out = fit.evidence + sum(item.bonus for item in self.items)
        for item, b, v in zip(
            self.column_items, fit.beta, np.diag(fit.beta_cov) if len(fit.beta) else ()
        ):
            out += (
                item.note.get("width", 0.0)
                if item.name == "step"
                else item.effect.penalty(self.data, abs(b) / np.sqrt(max(v, 1e-300)))
            )
        for term in fit.terms[len(self.base) :]:
            # a time constant that nears the record's length is not seen: the same noise has a name
            # with one parameter less
            if term.name in ("gauss_markov", "gauss_markov_2"):
                out -= 4.0 * np.clip(
                    np.log(term.correlation_time / self.data.duration * 12) / np.log(4.0), 0.0, 1.0
                )
        for item in self.items:
            if item.base_index is not None:
                name = item.slot.names[0]
                change = np.log(
                    getattr(fit.terms[item.base_index], name)
                    / getattr(self.base[item.base_index], name)
                )
                out += np.log(
                    CHANGE_WIDTH
                    / np.sqrt(2 * np.pi)
                    * sum(share / sd * np.exp(-0.5 * (change / sd) ** 2) for share, sd in CHANGES)
                )
        return out

    @property
    def ll(self) -> float:
        return self.fit.ll + sum(item.note.get("ll", item.bonus) for item in self.items)

    def settled(self) -> State:
        """The state with its items carrying their fitted values, so that a further fit starts
        there.
        """
        fit = self.fit
        terms, at, items = fit.terms, len(self.base), []
        for item in self.items:
            if item.name == "low_pass":
                item = replace(item, process=fit.low_pass)
            elif item.base_index is not None:
                item = replace(item, process=terms[item.base_index])
            elif item.slot is not None and item.column is None:
                item = replace(item, process=terms[at])
                at += 1
            items.append(item)
        base = list(self.base)
        for s in self.base_slots:
            base[s.index] = terms[s.index]
        out = State(self.data, base, items, low_pass=self.base_low_pass, base_slots=self.base_slots)
        out._fit, out._column_items, out._likelihood = fit, self._column_items, self._likelihood
        return out
