"""A found effect as the report gives it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imu_lib.gap import reliability, rounds
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.effects.competitor import process_parameters
from imu_lib.gap.state import State

#: The effect of which a report says what has changed.
CHANGE = "parameter_change"
#: Share of the winner's confidence from which on a rival is listed.
LISTED = 0.05


@dataclass(frozen=True)
class Step:
    """One effect: name, parameters, 95 % intervals, where it showed, how sure the name is, and who
    came second.

    `gain` is in log-likelihood; None for what was `detected` without one, by its `evidence`: then
    the confidence is the measured share of right names among such findings. `changes` are the
    (process, name) of the parameters whose change is one of the `indistinguishable`.
    """

    effect: str
    parameters: dict[str, Any]
    intervals: dict[str, Any]
    where: str
    confidence: float
    runner_up: dict[str, Any]
    indistinguishable: list[str]
    gain: float | None = 0.0
    gap_before: float | None = None
    gap_after: float | None = None
    cause: str = ""
    detected: bool = False
    evidence: str = ""
    changes: tuple[tuple[str, str], ...] = ()

    @property
    def rivals(self) -> list[str]:
        """What the record cannot tell it from, in words: of a changed parameter also which."""
        which = ", ".join(f"{name} of {process}" for process, name in self.changes)
        return [
            f"{effect} ({which})" if which and effect == CHANGE else effect
            for effect in self.indistinguishable
        ]

    def capped(self, most: float) -> Step:
        """The same step with no more than that confidence."""
        return replace(self, confidence=min(self.confidence, most))

    def to_json(self) -> dict[str, Any]:
        out = {
            "effect": self.effect,
            "parameters": _plain(self.parameters),
            "intervals": _plain(self.intervals),
            "where": self.where,
            "confidence": round(float(self.confidence), 4),
            "runner_up": _plain(self.runner_up),
            "indistinguishable": list(self.indistinguishable),
            "changes": [{"process": process, "name": name} for process, name in self.changes],
            "gain": None if self.gain is None else round(float(self.gain), 2),
            "detected": self.detected,
            "evidence": self.evidence,
            "cause": self.cause,
            "gap_before": _plain(self.gap_before),
            "gap_after": _plain(self.gap_after),
        }
        return out


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    return value


def detected(
    effect: str,
    parameters: dict[str, Any],
    where: str,
    sure: float,
    *,
    intervals: dict[str, Any] | None = None,
    rival: str = "none",
    cause: str = "",
    evidence: str = "",
) -> Step:
    """A step without a likelihood, as `sure` as such findings were right; its `evidence` is where
    it shows if nothing else is given.
    """
    other = {"effect": rival, "confidence": round(1 - sure, 4)}
    return Step(
        effect,
        parameters,
        intervals or {},
        where,
        sure,
        other,
        [],
        gain=None,
        cause=cause,
        detected=True,
        evidence=evidence or where,
    )


def step_of(f: Finding) -> Step:
    """A finding as a step; in doubt it is at even odds."""
    name, parameters = f.process.name, process_parameters(f.process)
    gain = None if f.gain is None or not np.isfinite(f.gain) else float(f.gain)
    sure = reliability.share(f.effect.name) if gain is None else reliability.odds(gain, f.places)
    return Step(
        name,
        parameters,
        f.intervals or {},
        f.where,
        min(float(sure), 0.5) if f.doubt else float(sure),
        {"effect": "none", "confidence": round(1 - float(sure), 4)},
        [],
        gain=gain,
        cause=f.effect.cause,
        detected=gain is None,
        evidence=f.evidence or (f.where if gain is None else ""),
    )


def steps_of_items(state: State, rivals: list[dict[str, float]]) -> list[Step]:
    """The effects of the competition with their intervals and rivals."""
    out = []
    for item, others in zip(state.items, rivals):
        parameters, intervals = item.effect.report(state, item)
        sure, weights = rounds.confidence(others) if others else (1.0, {})
        by_name: dict[str, float] = {}
        for key, w in weights.items():
            name = key.split(":")[0] or "none"
            if name == item.name and item.at is None:  # of another kind, but of the same name
                sure += w
                continue
            by_name[name] = max(by_name.get(name, 0.0), w)
        for name, share in item.effect.alike(state, item).items():
            by_name[name] = max(by_name.get(name, 0.0), share)
            sure *= 1.0 - share
        weight, sure = sure, reliability.calibrated(sure)
        rest = (1.0 - sure) / max(1.0 - weight, 1e-12)  # what is left is the rivals'
        by_name = {n: min(w * rest, 1.0 - sure) for n, w in by_name.items()}
        second = max(by_name, key=by_name.__getitem__) if by_name else "none"
        near = sorted(
            (n for n, w in by_name.items() if n != "none" and w > LISTED * max(sure, 1e-9)),
            key=lambda n: -by_name[n],
        )
        out.append(
            Step(
                item.name,
                parameters,
                intervals,
                item.effect.where(state, item),
                sure,
                {"effect": second, "confidence": by_name.get(second, 0.0)},
                near,
                gain=float(state.ll - state.without(item).ll),
                cause=item.effect.cause,
                changes=_changes(state, {k: w * rest for k, w in weights.items()}, LISTED * sure),
            )
        )
    return out


def _changes(state: State, weights: dict[str, float], least: float) -> tuple[tuple[str, str], ...]:
    """(process, name) of the parameters of the base whose change weighs more than `least`, the
    likeliest first.
    """
    keys = sorted((k for k, w in weights.items() if w > least), key=lambda k: -weights[k])
    parts = [k.split(":") for k in keys if k.count(":") == 2]
    return tuple((state.base[int(at)].name, name) for _, at, name in parts)
