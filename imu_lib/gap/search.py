"""Candidates of the competition, screened cheaply: noises, changed parameters, filters."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from imu_lib.gap import effects, fast
from imu_lib.gap.engine import SCREEN, Data, Likelihood, Slot, measured
from imu_lib.gap.state import CHANGE_WIDTH, Item, State
from imu_lib.processes import WhiteNoise

#: Logarithms of the factors by which a time constant is tried beside its own.
FAR = np.array([-4.5, -3.4, -2.3, -1.2, 1.2, 2.3])


def _log_ladder(s0, shape, nu, power):
    """Best gain over the strength of an added shape: (gain, strength)."""
    unit = 1.0 / np.sqrt(0.5 * np.sum(nu * (shape / s0) ** 2))
    u = unit * np.geomspace(0.5, 3e5, 34)
    s1 = s0[None, :] + u[:, None] * shape[None, :]
    gain = -0.5 * np.sum(nu * (np.log(s1 / s0) + power / s1 - power / s0), axis=1)
    j = int(np.argmax(gain))
    return float(gain[j]), float(u[j])


def _free_directions(state: State, s0) -> np.ndarray:
    """Relative change of the spectrum in all bins by each free parameter of the state, orthonormal
    under the bins' weights.
    """
    like, x, layout, fs = state.likelihood, state.fit.vector, state.data.layout, state.data.fs
    h, rows = 2e-3, []
    for i in range(len(x)):
        up, down = (like.unpack(x + sign * h * (np.arange(len(x)) == i)) for sign in (1, -1))
        rows.append(
            (fast.spectrum(*up, layout, fs) - fast.spectrum(*down, layout, fs)) / (2 * h) / s0
        )
    return np.linalg.qr((np.array(rows) * np.sqrt(layout.nu / 2)).T)[0]


def _score(s0, shape, layout, power, free):
    """Gain of a little of an added shape with the free parameters found anew beside it, to second
    order: (gain, strength).
    """
    weight = np.sqrt(layout.nu / 2)
    h = weight * shape / s0
    h = h - free @ (free.T @ h)
    g, information = h @ (weight * (power / s0 - 1.0)), max(h @ h, 1e-300)
    return (float(0.5 * g * g / information), float(g / information)) if g > 0 else (0.0, 0.0)


def spectral_candidates(state: State, exclude=()) -> list[Item]:
    """Noises whose spectrum would fill what is missing, each started at its best shape."""
    data = state.cleaned
    fit = state.fit
    layout, fs = data.layout, data.fs
    power = state_power(state)
    s0 = measured(fast.spectrum(fit.terms, fit.low_pass, layout, fs), data.extra)
    free = _free_directions(state, s0) if len(fit.vector) else None
    out = []
    for effect in effects.SPECTRAL:
        if (
            effect.name in exclude
            or effect.name == "white_noise"
            and any(t.name == "white_noise" for t in fit.terms)
        ):
            continue
        if effect.name in ("quantization", "flicker", "random_walk") and any(
            t.name == effect.name for t in fit.terms
        ):
            continue
        if not effect.beside(fit.low_pass, fs):
            continue
        rows = []
        for process in effect.grid(fs, data.duration):
            shape = fast.spectrum([process], fit.low_pass, layout, fs)
            gain, u = _log_ladder(s0, shape, layout.nu, power)
            if free is not None:  # what is there already may stand in for what is missing
                gain, u = max((gain, u), _score(s0, shape, layout, power, free))
            rows.append(
                (
                    gain,
                    process.with_(
                        **{effect.amplitude: getattr(process, effect.amplitude) * np.sqrt(u)}
                    ),
                )
            )
        rows.sort(key=lambda r: -r[0])
        if rows[0][0] < SCREEN:
            continue
        for gain, process in rows[:1]:
            out.append(
                Item(
                    effect.name,
                    process,
                    effect.slot(0, fs, data.duration),
                    bonus=-effect.rarity,
                    note={"screen": gain, "ll": 0.0},
                )
            )
    return out


def state_power(state: State) -> np.ndarray:
    """The binned periodogram, slow bins included, without what the fit knows of drifts."""
    fit, data = state.fit, state.cleaned
    if not len(fit.beta):
        return data.power
    t = np.arange(data.n) / data.fs
    signal = sum(
        b * item.process.mean(t, data.temperature) for b, item in zip(fit.beta, state.column_items)
    )
    return Data(data.x - signal, data.fs).power


def _elsewhere(term) -> bool:
    """Whether a term is settled before the competition: noise in common on the record, a rounded
    integral by its grid.
    """
    return term.name == "common_mode" or bool(getattr(term, "rounded", None))


def change_candidates(state: State) -> list[Item]:
    """Parameters of the held base that the record would have otherwise."""
    taken = {i.key for i in state.items}
    free = {s.index for s in state.base_slots}
    out, slots, keys = [], [], []
    for index, term in enumerate(state.base):
        if index in free or _elsewhere(term):
            continue
        for p in term.parameters:
            key = f"parameter_change:{index}:{p.name}"
            sampling = p.name == "rate" and term.name == "autoregressive"
            if (
                key in taken
                or sampling
                or term.deterministic
                or p.kind not in ("amplitude", "time", "rate")
                or getattr(term, p.name) <= 0
            ):
                continue
            value = np.log(getattr(term, p.name))
            # a time constant beyond a third of the record is not seen
            most = max(value + 0.1, np.log(state.data.duration / 3)) if p.kind == "time" else np.inf
            slots.append(
                Slot(index, (p.name,), (value - 9.0,), (min(value + 9.0, most),), (CHANGE_WIDTH,))
            )
            keys.append(key)
    if not slots:
        return out
    for slot, key in zip(slots, keys):
        terms, own, low_pass, columns, _ = state.assemble()
        if any(slot.index == s.index for s in own):
            screened = SCREEN
        else:
            like = Likelihood(
                state.cleaned,
                state.fit.terms,
                (slot,),
                low_pass=state.fit.low_pass,
                columns=columns,
                power=state.likelihood.power_full,
            )
            x = like.start()
            g, info = like._derivatives(x, like.shapes(x))
            screened = 0.5 * g[0] ** 2 / max(info[0, 0], 1e-12)
            name = slot.names[0]
            if (
                slot.high[0] < np.inf
            ):  # a time far from the given one is not seen from its slope there
                trials = np.clip(x + FAR, slot.low[0], slot.high[0])
                values = [like.value(np.array([v]))[0] for v in trials]
                gain = max(values) - like.value(x)[0]
                if gain > max(screened, SCREEN):
                    moved = state.fit.terms[slot.index].with_(
                        **{name: float(np.exp(trials[int(np.argmax(values))]))}
                    )
                    out.append(Item(key, moved, slot, base_index=slot.index, note={"screen": gain}))
                    continue
        if screened >= 0.75 * SCREEN:
            out.append(Item(key, None, slot, base_index=slot.index, note={"screen": screened}))
    return out


@lru_cache(maxsize=4)
def filter_gains(layout, fs):
    """The filters of the catalogue and their power gains in the fast bins, shape (filters, bins)."""
    stages = effects.CATALOGUE["low_pass"].candidates(fs)
    unit = [WhiteNoise(N=np.sqrt(0.5))]  # one-sided density 1 before the filter
    return stages, np.array([fast.spectrum(unit, s, layout, fs)[layout.slow :] for s in stages])


def filter_candidates(state: State) -> list[Item]:
    """Low-pass filters, if the model has none."""
    if state.fit.low_pass is not None:
        return []
    effect, data = effects.CATALOGUE["low_pass"], state.cleaned
    power = state_power(state)[data.layout.slow :]
    nu = data.layout.nu[data.layout.slow :]
    s0 = state.likelihood.shapes(state.fit.vector)[0]
    base = -0.5 * np.sum(nu * (np.log(s0) + power / s0))
    stages, gains = filter_gains(data.layout, data.fs)
    extra = data.extra[data.layout.slow :]
    s = np.maximum((s0 - extra) * gains + extra, 1e-9 * s0)
    rows = list(zip(-0.5 * np.sum(nu * (np.log(s) + power / s), axis=1) - base, stages))
    terms = [t for t in state.fit.terms if not _elsewhere(t)]
    rows = [r for r in rows if all(effects.CATALOGUE[t.name].beside(r[1], data.fs) for t in terms)]
    rows.sort(key=lambda r: -r[0])
    out, kinds = [], set()
    for gain, stage in rows:
        kind = (stage.order, stage.smoothing, stage.rate)
        if gain < SCREEN or kind in kinds or len(out) >= 5:
            continue
        kinds.add(kind)
        slot = effect.slot(data.fs) if stage.tunable else None
        # a moving average is one of some eighty, a filter one of five kinds at one of two rates
        out.append(
            Item(
                "low_pass",
                stage,
                slot,
                bonus=-np.log(80.0) if stage.taps else -np.log(10.0),
                note={"screen": gain, "ll": 0.0},
            )
        )
    return out
