"""A found effect as the report gives it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.gap import fast, measured, rounds
from imu_lib.gap.engine import measured as behind_electronics

Z95 = 1.959963984540054


@dataclass(frozen=True)
class Step:
    """One effect: name, parameters, 95 % intervals, where it showed, how sure the name is, and who
    came second.

    `gain` is in log-likelihood; None for what was `detected` without one, by its `evidence`: then
    the confidence is the measured share of right names among such findings.
    """

    effect: str
    parameters: dict
    intervals: dict
    where: str
    confidence: float
    runner_up: dict
    indistinguishable: list
    gain: float | None = 0.0
    gap_before: float | None = None
    gap_after: float | None = None
    cause: str = ""
    detected: bool = False
    evidence: str = ""

    def capped(self, most: float) -> Step:
        """The same step with no more than that confidence."""
        return replace(self, confidence=min(self.confidence, most))

    def to_json(self) -> dict:
        out = {
            "effect": self.effect,
            "parameters": _plain(self.parameters),
            "intervals": _plain(self.intervals),
            "where": self.where,
            "confidence": round(float(self.confidence), 4),
            "runner_up": _plain(self.runner_up),
            "indistinguishable": list(self.indistinguishable),
            "gain": None if self.gain is None else round(float(self.gain), 2),
            "detected": self.detected,
            "evidence": self.evidence,
            "cause": self.cause,
            "gap_before": _plain(self.gap_before),
            "gap_after": _plain(self.gap_after),
        }
        return out


def _plain(value):
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    return value


def _parameters(process) -> dict:
    out = process.to_json()
    out.pop("process")
    return out


def steps_of_findings(findings, fs) -> list[Step]:
    """Electronics, noise level and lines."""
    out = []
    for f in findings:
        # where there is no likelihood: as often as such a finding was right
        detected = f.gain is None or not np.isfinite(f.gain)
        sure = measured.share(f.effect.name) if detected else measured.odds(f.gain, f.places)
        rival = {"effect": "none", "confidence": float(1 - sure)}
        out.append(
            Step(
                f.process.name,
                _parameters(f.process),
                f.intervals,
                f.where,
                0.5 if f.doubt else float(sure),
                rival,
                [],
                gain=None if detected else float(f.gain),
                cause=f.effect.cause,
                detected=detected,
                evidence=f.evidence or (f.where if detected else ""),
            )
        )
    return out


def steps_of_items(state, rivals, n_base) -> list[Step]:
    """The effects of the competition with their intervals and rivals."""
    fit = state.fit
    sds = np.sqrt(np.maximum(np.diag(fit.cov), 0.0)) if len(fit.vector) else np.zeros(0)
    place, at = {}, 0
    for slot in fit.slots:
        for k, name in enumerate(slot.names):
            place[(slot.index, name)] = at + k
        at += len(slot.names)
    out, index, column = [], n_base, 0
    for item, others in zip(state.items, rivals):
        intervals = {}
        if item.column is not None:
            b, v = fit.beta[column], fit.beta_cov[column, column]
            column += 1
            sd = float(np.sqrt(max(v, 0.0)))
            process = item.process.with_(**{item.effect.amplitude: float(b)})
            intervals[item.effect.amplitude] = [b - Z95 * sd, b + Z95 * sd]
            intervals.update(item.note.get("intervals", {}))
            if "profile" in item.note:
                intervals[item.effect.shape] = item.note["profile"]
            parameters = _parameters(process)
        elif item.base_index is not None:
            process = fit.terms[item.base_index]
            name = item.slot.names[0]
            value, old = getattr(process, name), getattr(state.base[item.base_index], name)
            sd = sds[place[(item.base_index, name)]]
            parameters = {"process": process.name, "name": name, "from": old, "to": value}
            intervals = {"to": [value * np.exp(-Z95 * sd), value * np.exp(Z95 * sd)]}
        elif item.name == "low_pass":
            process = fit.low_pass
            parameters = _parameters(process)
            if item.slot is not None:
                sd = sds[place[(-1, "cutoff")]]
                intervals["cutoff"] = [
                    process.cutoff * np.exp(-Z95 * sd),
                    process.cutoff * np.exp(Z95 * sd),
                ]
        elif item.signal is not None:
            process = item.process
            parameters = _parameters(process)
            sd, spread = item.note["sd"], Z95 / np.sqrt(max(item.note["flips"], 1))
            intervals = {
                "amplitude": [process.amplitude - Z95 * sd, process.amplitude + Z95 * sd],
                "rate": [process.rate * np.exp(-spread), process.rate * np.exp(spread)],
            }
        else:
            process = fit.terms[index]
            parameters = _parameters(process)
            slot = next(s for s in fit.slots if s.index == index)
            at = place[(index, slot.names[0])] + np.arange(len(slot.names))
            for name in slot.names:
                if hasattr(process, name):
                    g, value = slot.relative(process, name), getattr(process, name)
                    sd = np.sqrt(max(g @ fit.cov[np.ix_(at, at)] @ g, 0.0))
                    intervals[name] = [value * np.exp(-Z95 * sd), value * np.exp(Z95 * sd)]
            index += 1
        sure, weights = rounds.confidence(others) if others else (1.0, {})
        by_name = {}
        for key, w in weights.items():
            by_name[key.split(":")[0] or "none"] = max(
                by_name.get(key.split(":")[0] or "none", 0.0), w
            )
        if rounds.explains_as_telegraph(state, item):
            by_name["telegraph"] = max(by_name.get("telegraph", 0.0), 0.5)
            sure *= 0.5
        second = max(by_name, key=by_name.get) if by_name else "none"
        near = sorted(
            (n for n, w in by_name.items() if n != "none" and w > 0.05 * max(sure, 1e-9)),
            key=lambda n: -by_name[n],
        )
        cause = (
            item.effect.cause
            if item.effect is not None
            else "A parameter of the given model does not hold for this unit, this day or this environment."
        )
        out.append(
            Step(
                item.name,
                parameters,
                intervals,
                where(state, item),
                sure,
                {"effect": second, "confidence": by_name.get(second, 0.0)},
                near,
                gain=float(
                    state.ll - state.with_items([i for i in state.items if i is not item]).ll
                ),
                cause=cause,
            )
        )
    return out


def where(state, item) -> str:
    """Where the model without the item and the record disagree, in physical words."""
    if item.column is not None or item.signal is not None:
        data = state.data
        if item.name == "step":
            return f"mean of the signal: a jump at {item.process.time:.1f} s"
        if item.name == "temperature":
            return f"regression on the temperature between {data.temperature.min():.1f} and {data.temperature.max():.1f} degC"
        if item.name == "telegraph":
            return f"distribution of the bias: two levels, about {item.note['flips']:.0f} flips in {data.duration:.0f} s"
        if item.name == "sinusoid":
            return (
                f"mean of the signal: it swings with a period of {1 / item.process.frequency:.4g} s"
            )
        if item.name == "ramp":
            return f"mean of the signal: a drift over the {data.duration:.0f} s of the record"
        return (
            f"mean of the signal: a transient over the first {3 * item.process.time_constant:.0f} s"
        )
    without = state.with_items([i for i in state.items if i is not item])
    layout, fs = state.data.layout, state.data.fs
    a, b = (
        behind_electronics(fast.spectrum(s.fit.terms, s.fit.low_pass, layout, fs), state.data.extra)
        for s in (state, without)
    )
    decibel = 10 * np.log10(np.maximum(a, 1e-300) / np.maximum(b, 1e-300))
    weight = np.abs(decibel)
    on = weight > 0.5 * weight.max()
    f = layout.f[on]
    peak = decibel[int(np.argmax(weight))]
    low, high = f.min(), f.max()
    side = "above" if peak > 0 else "below"
    text = f"power spectral density between {low:.3g} and {high:.3g} Hz, up to {abs(peak):.2g} dB {side} the simulated level"
    if high < 0.5:
        text += f" (Allan deviation from {0.4 / high:.3g} s on)"
    return text
