"""The competition: candidates are screened cheaply, refitted jointly with what is in the model, and weighed by their evidence."""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from imu_lib.gap import effects, fast, slow
from imu_lib.gap.effects.step import sharpen
from imu_lib.gap.engine import Data, Fit, Likelihood, Slot, amplitude_occam

#: A change of a held parameter is log-normal, half of the time within a factor of two or so, else of any size: shares and
#: standard deviations of the two (the width is what the fit assumes first).
CHANGE_WIDTH, CHANGES = 2 * np.log(10.0), ((0.5, 0.5), (0.5, 2.0))
#: Gain in log-likelihood below which a screened candidate is not fitted.
SCREEN = 4.0


@dataclass(frozen=True)
class Item:
    """An effect in the model: a noise with free parameters, a drift (`process` of amplitude 1), a filter or a changed parameter.

    `key` names it ("gauss_markov", "parameter_change:0:N"), `slot` its free parameters with an index into the terms that
    the state fills in, `signal` a deterministic signal already taken out of the record (telegraph), `bonus` a log
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
        return effects.CATALOGUE.get(self.name)


class State:
    """A model of a clean channel: held base terms, items, and the fit of all free parameters together."""

    def __init__(self, data: Data, base, items=(), *, low_pass=None, base_slots=(), start=None):
        self.data, self.base, self.items, self.base_low_pass = data, tuple(base), tuple(items), low_pass
        self.base_slots = tuple(base_slots)
        self._fit, self._start = None, start

    def with_items(self, items) -> State:
        return State(self.data, self.base, items, low_pass=self.base_low_pass, base_slots=self.base_slots)

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
                if item.process is not None:               # the value of an earlier fit is where this one starts
                    name = item.slot.names[0]
                    terms[item.base_index] = terms[item.base_index].with_(**{name: getattr(item.process, name)})
                if item.base_index in slots:               # two parameters of one process
                    old = slots[item.base_index]
                    if item.slot.names[0] not in old.names:
                        slots[item.base_index] = Slot(old.index, old.names + item.slot.names, old.low + item.slot.low,
                                                      old.high + item.slot.high, old.widths + item.slot.widths)
                else:
                    slots[item.base_index] = item.slot
            elif item.slot is not None:
                slots[len(terms)] = replace(item.slot, index=len(terms))
                terms.append(item.process)
        matrix = np.column_stack([i.column for i in columns]) if columns else None
        return terms, tuple(slots[k] for k in slots), low_pass, matrix, columns

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
            sharp = [i for i, item in enumerate(column_items) if item.effect.sharp]
            likelihood = Likelihood(data, terms, slots, low_pass=low_pass, columns=columns, power=None)
            if sharp:
                _, beta, _ = likelihood.value(likelihood.start())
                t = np.arange(data.n) / data.fs
                signal = sum(beta[i] * column_items[i].process.mean(t) for i in sharp)
                power = Data(data.x - signal, data.fs, white=data.white).power
                likelihood = Likelihood(data, terms, slots, low_pass=low_pass, columns=columns, power=power)
            self.likelihood = likelihood
            self._fit = likelihood.maximise()
            self.column_items = column_items
        return self._fit

    @property
    def evidence(self) -> float:
        fit = self.fit
        out = fit.evidence + sum(item.bonus for item in self.items)
        for item, b, v in zip(self.column_items, fit.beta, np.diag(fit.beta_cov) if len(fit.beta) else ()):
            out += item.note.get("width", 0.0) if item.name == "step" else item.effect.penalty(self.data, abs(b) / np.sqrt(max(v, 1e-300)))
        for term in fit.terms[len(self.base):]:
            # a time constant that nears the record's length is not seen: the same noise has a name with one parameter less
            if term.name in ("gauss_markov", "gauss_markov_2"):
                out -= 4.0 * np.clip(np.log(term.correlation_time / self.data.duration * 12) / np.log(4.0), 0.0, 1.0)
        for item in self.items:
            if item.base_index is not None:
                name = item.slot.names[0]
                change = np.log(getattr(fit.terms[item.base_index], name) / getattr(self.base[item.base_index], name))
                out += np.log(CHANGE_WIDTH / np.sqrt(2 * np.pi) * sum(share / sd * np.exp(-0.5 * (change / sd) ** 2) for share, sd in CHANGES))
        return out

    @property
    def ll(self) -> float:
        return self.fit.ll + sum(item.note.get("ll", item.bonus) for item in self.items)

    def settled(self) -> State:
        """The state with its items carrying their fitted values, so that a further fit starts there."""
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
        out._fit, out.column_items, out.likelihood = fit, self.column_items, self.likelihood
        return out


# -- screening -------------------------------------------------------------------------------------------------

def _log_ladder(s0, shape, nu, power):
    """Best gain over the strength of an added shape: (gain, strength)."""
    unit = 1.0 / np.sqrt(0.5 * np.sum(nu * (shape / s0) ** 2))
    u = unit * np.geomspace(0.5, 3e5, 34)
    s1 = s0[None, :] + u[:, None] * shape[None, :]
    gain = -0.5 * np.sum(nu * (np.log(s1 / s0) + power / s1 - power / s0), axis=1)
    j = int(np.argmax(gain))
    return float(gain[j]), float(u[j])


def spectral_candidates(state: State, exclude=()) -> list[Item]:
    """Noises whose spectrum would fill what is missing, each started at its best shape."""
    data = state.cleaned
    fit = state.fit
    layout, fs = data.layout, data.fs
    power = state_power(state)
    s0 = fast.spectrum(fit.terms, fit.low_pass, layout, fs) + data.extra
    out = []
    for effect in effects.SPECTRAL:
        if effect.name in exclude or effect.name == "white_noise" and any(t.name == "white_noise" for t in fit.terms):
            continue
        if effect.name in ("quantization", "flicker", "random_walk") and any(t.name == effect.name for t in fit.terms):
            continue
        if effect.name == "autoregressive" and fit.low_pass is not None and fit.low_pass.rate != fs:
            continue                                      # a resonance of the samples has no spectrum at the filter's inner rate
        rows = []
        for process in effect.grid(fs, data.duration):
            shape = fast.spectrum([process], fit.low_pass, layout, fs)
            gain, u = _log_ladder(s0, shape, layout.nu, power)
            rows.append((gain, process.with_(**{effect.amplitude: getattr(process, effect.amplitude) * np.sqrt(u)})))
        rows.sort(key=lambda r: -r[0])
        if rows[0][0] < SCREEN:
            continue
        for gain, process in rows[:1]:
            out.append(Item(effect.name, process, effect.slot(0, fs, data.duration), bonus=-effect.rarity, note={"screen": gain, "ll": 0.0}))
    return out


def state_power(state: State) -> np.ndarray:
    """The binned periodogram, slow bins included, without what the fit knows of drifts."""
    fit, data = state.fit, state.cleaned
    if not len(fit.beta):
        return data.power
    t = np.arange(data.n) / data.fs
    signal = sum(b * item.process.mean(t, data.temperature) for b, item in zip(fit.beta, state.column_items))
    return Data(data.x - signal, data.fs).power


def change_candidates(state: State) -> list[Item]:
    """Parameters of the held base that the record would have otherwise."""
    taken = {i.key for i in state.items}
    free = {s.index for s in state.base_slots}
    out, slots, keys = [], [], []
    for index, term in enumerate(state.base):
        if index in free:
            continue
        for p in term.parameters:
            key = f"parameter_change:{index}:{p.name}"
            if key in taken or p.kind not in ("amplitude", "time", "rate") or p.name == "rate" and term.name == "autoregressive" or term.deterministic or getattr(term, p.name) <= 0:
                continue
            value = np.log(getattr(term, p.name))
            slots.append(Slot(index, (p.name,), (value - 9.0,), (value + 9.0,), (CHANGE_WIDTH,)))
            keys.append(key)
    if not slots:
        return out
    for slot, key in zip(slots, keys):
        terms, own, low_pass, columns, _ = state.assemble()
        if any(slot.index == s.index for s in own):
            screened = SCREEN
        else:
            like = Likelihood(state.cleaned, state.fit.terms, (slot,), low_pass=state.fit.low_pass, columns=columns, power=state.likelihood.power_full)
            x = like.start()
            g, info = like._derivatives(x, like.shapes(x))
            screened = 0.5 * g[0] ** 2 / max(info[0, 0], 1e-12)
        if screened >= 0.75 * SCREEN:
            out.append(Item(key, None, slot, base_index=slot.index, note={"screen": screened}))
    return out


@lru_cache(maxsize=4)
def filter_gains(layout, fs):
    """The filters of the catalogue and their power gains in the fast bins, shape (filters, bins)."""
    stages = effects.CATALOGUE["low_pass"].candidates(fs)
    f = layout.nodes[layout.slow:]
    return stages, np.array([s.gain(f, fs) @ np.array([5.0, 8.0, 5.0]) / 18.0 for s in stages])


def filter_candidates(state: State) -> list[Item]:
    """Low-pass filters, if the model has none."""
    if state.fit.low_pass is not None:
        return []
    effect, data = effects.CATALOGUE["low_pass"], state.cleaned
    power = state_power(state)[data.layout.slow:]
    nu = data.layout.nu[data.layout.slow:]
    s0 = state.likelihood.shapes(state.fit.vector)[0]
    base = -0.5 * np.sum(nu * (np.log(s0) + power / s0))
    stages, gains = filter_gains(data.layout, data.fs)
    extra = data.extra[data.layout.slow:]
    s = np.maximum((s0 - extra) * gains + extra, 1e-9 * s0)
    rows = list(zip(-0.5 * np.sum(nu * (np.log(s) + power / s), axis=1) - base, stages))
    if any(t.name == "autoregressive" for t in state.fit.terms):
        rows = [r for r in rows if r[1].rate == data.fs]
    rows.sort(key=lambda r: -r[0])
    out, kinds = [], set()
    for gain, stage in rows:
        kind = "taps" if stage.taps else f"order{stage.order}"
        if gain < SCREEN or kind in kinds or len(out) >= 4:
            continue
        kinds.add(kind)
        slot = effect.slot(data.fs) if stage.order else None
        # a moving average is one of some twenty, a filter one of four orders
        out.append(Item("low_pass", stage, slot, bonus=-np.log(26.0) if stage.taps else -np.log(8.0), note={"screen": gain, "ll": 0.0}))
    return out


def _scanner(state: State, columns):
    """Gain, amplitude and squared norm of drifts by generalised least squares under the fitted noise, beside `columns`."""
    data = state.cleaned
    vector = state.fit.vector                              # fits, and so makes the likelihood
    white = slow.whitening_matrix(state.likelihood.shapes(vector)[1])
    e = white @ data.d
    basis = None
    if columns is not None:
        basis, _ = np.linalg.qr(white @ columns)
        e = e - basis @ (basis.T @ e)

    def scan(effect, processes):
        a = white @ np.diff(effect.columns(processes, data), axis=0)
        if basis is not None:
            a = a - basis @ (basis.T @ a)
        norm = np.maximum(np.sum(a * a, axis=0), 1e-300)
        return 0.5 * (a.T @ e) ** 2 / norm, (a.T @ e) / norm, norm
    return scan


def drift_candidates(state: State) -> list[Item]:
    """Deterministic drifts by generalised least squares under the fitted noise."""
    out, scan = [], _scanner(state, state.assemble()[3])
    for effect in effects.DRIFTS:
        if effect.name in ("ramp", "warm_up", "temperature") and any(i.name == effect.name for i in state.items):
            continue
        item = _best_drift(state, effect, scan)
        if item is not None:
            out.append(item)
    return out


def _best_drift(state, effect, scan) -> Item | None:
    data = state.cleaned
    processes = effect.candidates(data)
    if not processes:
        return None
    gain, _, _ = scan(effect, processes)
    j = int(np.argmax(gain))
    if gain[j] < SCREEN:
        return None
    best = processes[j]
    if effect.shape is not None:
        best = _refine(effect, best, scan, data, state)
    column = np.diff(effect.columns([best], data)[:, 0])
    note = {"screen": float(gain[j])}
    if effect.name == "step":                              # log of the share of all instants at which the jump may lie
        note["width"] = float(np.log(np.sum(np.exp(gain - gain[j])) / len(gain)))
    if effect.shape is not None:
        note["profile"] = _profile(effect, best, scan, data)
    return Item(effect.name, best, column=column, note=note)


def retuned(state: State) -> State:
    """The state with the shapes of its drifts (time constants, instants) found anew beside one another."""
    for _ in range(2):
        moved = False
        for i, item in enumerate(state.items):
            if item.column is None or item.effect.shape is None:
                continue
            others = [o.column for o in state.items if o.column is not None and o is not item]
            if not others:
                continue
            scan = _scanner(state, np.column_stack(others))
            best = _best_drift(state, item.effect, scan)
            if best is None:
                continue
            gain, _, _ = scan(item.effect, [item.process, best.process])
            if gain[1] > gain[0] + 0.1:
                state = state.with_items(state.items[:i] + (best,) + state.items[i + 1:])
                moved = True
        if not moved:
            break
    return state


def _grid(effect, best, data, reach, points):
    value = getattr(best, effect.shape)
    if effect.name == "step":
        block = data.m / data.fs
        values = np.clip(value + np.linspace(-reach, reach, points) * block, 1.5 * block, data.duration - 1.5 * block)
    else:
        low, high = effect.bounds(data)
        values = np.exp(np.clip(np.log(value) + np.linspace(-reach, reach, points) * (high - low) / 13, low, high))
    return [best.with_(**{effect.shape: float(v)}) for v in np.unique(values)]


def _refine(effect, best, scan, data, state):
    for reach in (1.0, 0.12, 0.015):
        trial = _grid(effect, best, data, reach, 25)
        gain, amplitude, _ = scan(effect, trial)
        best = trial[int(np.argmax(gain))]
    if effect.name == "step":
        amplitude = float(amplitude[int(np.argmax(gain))])
        density = float(np.median(state.likelihood.shapes(state.fit.vector)[0])) / 2
        edge = sharpen(data.x, data.fs, best.time, data.m / data.fs, amplitude, density)
        if edge is not None:
            best = best.with_(time=edge[0])
    return best


def _profile(effect, best, scan, data):
    """Range of the shape parameter within 1.92 of the best log-likelihood (3 for an edge)."""
    trial = _grid(effect, best, data, 6.0, 241)
    gain, _, _ = scan(effect, trial)
    values = np.array([getattr(p, effect.shape) for p in trial])
    near = values[gain > gain.max() - (3.0 if effect.name == "step" else 1.92)]
    return [float(near.min()), float(near.max())]
