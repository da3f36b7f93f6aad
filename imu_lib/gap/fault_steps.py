"""What was found in the data, or happened to the sensor, as steps of the record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from imu_lib.faults import Finding
from imu_lib.faults.finding import named, seconds
from imu_lib.faults.standing import long_runs, stands
from imu_lib.gap.steps import Step, detected
from imu_lib.record import Record

#: Findings of each kind in the records of benchmarks/fault_score.py, and those of them that were
#: put in; tests/test_faults.py counts again.
DETECTED = {"dropout": (53, 53), "disturbance": (34, 28), "tilt": (29, 27)}


def steps(finding: Finding, record: Record) -> list[Step]:
    """A finding as steps of the record, none where the effect has no name in a model file; an
    output that stands still is one for each time that it does.
    """
    if not stands(finding):
        return [s for s in [_step(finding)] if s is not None]
    # masked like the drop-outs that hold several channels, and simulated where they were
    time, names = record.times(), named(finding.channels)
    out = []
    for first, last in long_runs(finding.rows):
        stop = float(time[last]) if last < record.n else record.duration
        p = {
            "fraction": (last - first) / record.n,
            "held": True,
            "channels": list(finding.channels),
            "from": float(time[first]),
            "to": stop,
        }
        text = (
            f"{last - first:,} samples of {names} repeat the one before, from "
            f"{seconds(float(time[first]))} to {seconds(stop)} s, up to {last - first + 1:,} in a "
            "row: frozen output."
        )
        step = _step(replace(finding, kind="dropout", parameters=p, sentence=text))
        out += [] if step is None else [step]
    return out


def _step(finding: Finding) -> Step | None:
    """A finding as a step of the record; None where the effect has no name in a model file."""
    if finding.kind not in DETECTED:
        return None
    parameters = dict(finding.parameters)
    if finding.kind == "dropout":
        if of_file(finding):
            return None
        parameters = {k: v for k, v in parameters.items() if v is not None}
    found, right = DETECTED[finding.kind]
    sure = (right + 1) / (found + 2)  # Laplace's rule of succession
    evidence = ", ".join(f"{k.replace('_', ' ')} {_figure(v)}" for k, v in finding.evidence.items())
    return detected(
        finding.kind, parameters, finding.sentence, sure, cause=finding.means, evidence=evidence
    )


def of_file(finding: Finding) -> bool:
    """Whether a drop-out is NaN: the file says itself that nothing is there."""
    return finding.parameters.get("value") is None and not finding.parameters.get("held")


def _figure(value: float | Sequence[float] | None) -> str:
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(map(_figure, value)) + ")"
    return "none" if value is None else f"{value:.3g}"


def described(effect: str, p: dict[str, Any]) -> str | None:
    """The parameters of a step in words, for a table; None where it is none of these effects."""
    if effect not in DETECTED:
        return None
    if effect == "tilt":
        angles = ", ".join(f"{1e3 * a:.3g}" for a in p["angles"])
        return f"tilt  {seconds(p['time'])} s, ({angles}) mrad"
    where = f"on {named(tuple(p['channels']))}"
    if effect == "disturbance":
        return f"disturbance  {seconds(p['start'])} s, {p['duration']:.2g} s long, {where}"
    what = "copies of the row before" if p.get("held") else f"at {p['value']}"
    even = f", one in {p['period']}" if p.get("period") else ""
    if p.get("from") is not None:
        even = f", from {seconds(p['from'])} to {seconds(p['to'])} s"
    return f"dropout  {100 * p['fraction']:.3g} % of the rows{even}, {what}, {where}"
