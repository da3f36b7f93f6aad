"""Windows of a long record that are unlike the others, looked at in full."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.gap.found import Report
from imu_lib.gap.long.views import belongs_to_means, rows, shifted
from imu_lib.gap.long.windows import Stretch
from imu_lib.gap.loop import close
from imu_lib.gap.steps import Step
from imu_lib.long_record.record import LongRecord
from imu_lib.model import Model
from imu_lib.processes import Process, from_json

#: Effects that have a time in a model, and those whose share of the samples counts.
TIMED, SHARES = ("vibration", "disturbance", "tilt"), ("dropout", "time_gaps")
#: Stretches that are looked at, at the most.
MOST = 8


@dataclass(frozen=True)
class Looked:
    """What a stretch of windows has shown: steps of the record, a sentence, and whether something
    is left there that the model cannot hold.
    """

    steps: tuple[Step, ...]
    sentence: str
    left: bool


def look(
    record: LongRecord, model: Model, found: Stretch, window: int, rate: float, seed: int
) -> Looked:
    """One stretch of windows, its worst one in full.

    model : what the rest of the record has. found : Stretch. rate : of the block means, Hz.
    """
    fs = record.rate
    low, high = rows(record, found.worst * window, (found.worst + 1) * window)
    start = found.worst * window / fs
    begin, end = found.first * window / fs, (found.last + 1) * window / fs
    where = (
        f"from {units.duration(begin)} to {units.duration(end)} of the record {found.what} on "
        f"{', '.join(found.channels)} {'are' if found.what.endswith('s') else 'is'} unlike the rest"
    )
    try:
        part = replace(record.part(low, high), notes=())
        seen = close(part, shifted(model, start, window / fs), simulations=0, jobs=1, seed=seed)
    except (InputError, ValueError) as error:
        return Looked((), f"{where}; it cannot be looked at ({str(error).rstrip('.')})", True)
    steps, names, left = [], [], False
    windows = found.last - found.first + 1
    offset = start + (seen.stretch[0] if seen.stretch else 0.0)
    for s in [*seen.record_steps, *_lines(seen)]:
        if s.effect in TIMED:
            steps.append(_placed(s, start, offset, begin, end, windows))
        elif s.effect in SHARES:
            share = (high - low) * windows / (record.rows - record.begin)
            more = {"fraction": s.parameters["fraction"] * share}
            steps.append(replace(s, parameters={**s.parameters, **more}))
        else:
            left = True
        names.append(s.effect)
    for channel, c in seen.channels.items():
        for s in c.result.steps:
            known = s.effect == "sinusoid" or model[channel].find(s.effect) is not None
            if known or belongs_to_means(s, model[channel], rate):
                continue
            names.append(f"{s.effect} on {channel}")
            left = left or s.effect != "spikes"
    told = "; ".join(dict.fromkeys(names)) or "nothing has a name there"
    return Looked(tuple(steps), f"{where}: {told}", left or not names)


def _lines(seen: Report) -> list[Step]:
    """Lines on single channels as vibrations of the record, one a frequency."""
    found: dict[float, list[tuple[str, Step]]] = {}
    for channel, c in seen.channels.items():
        for s in c.result.steps:
            if s.effect == "sinusoid":
                f = s.parameters["frequency"]
                key = next((g for g in found if abs(g - f) < 2 / seen.record.duration), f)
                found.setdefault(key, []).append((channel, s))
    out = []
    for f, on in found.items():
        first = max((s for _, s in on), key=lambda s: s.gain or 0.0)
        parameters = {
            "frequency": f,
            "bandwidth": 0.0,
            "harmonics": 1,
            "amplitude": [s.parameters["amplitude"] for _, s in on],
            "channels": [c for c, _ in on],
        }
        own = {k: v for k, v in first.intervals.items() if k == "frequency"}
        out.append(replace(first, effect="vibration", parameters=parameters, intervals=own))
    return out


def _placed(
    step: Step, start: float, offset: float, begin: float, end: float, windows: int
) -> Step:
    """A step of a window with its times in the whole record."""
    p = dict(step.parameters)
    if step.effect == "vibration":
        whole = p.get("from") is None
        if whole or windows > 1:
            p["from"], p["to"] = begin, end
        else:
            p["from"], p["to"] = p["from"] + offset, p["to"] + offset
    else:  # faults count from the first sample of the part
        key = "start" if step.effect == "disturbance" else "time"
        p[key] = p[key] + start
    return replace(step, parameters=p, where=_where(step, start))


def process_of(step: Step) -> Process:
    """A step of the record as the model file has it."""
    return from_json({"process": step.effect, **step.parameters}, on_record=True)


def together(steps: list[Step], more: Sequence[Step]) -> list[Step]:
    """The steps with those of one more stretch: a vibration that goes on, or was there before, is
    one from its first to its last second; one with a pause between is another.
    """
    out = list(steps)
    for s in more:
        same = [i for i, t in enumerate(out) if alike(s, t)]
        if s.effect != "vibration":
            out += [] if same else [s]
            continue
        span = _span(s)
        touching = [i for i in same if _touch(span, _span(out[i]))]
        begins, ends = zip(span, *(_span(out[i]) for i in touching))
        span = min(begins), max(ends)
        first = out[touching[0]] if touching else s
        if np.isfinite(span).all():
            first = replace(first, parameters={**first.parameters, "from": span[0], "to": span[1]})
        out = [t for i, t in enumerate(out) if i not in touching] + [first]
    return out


def _span(step: Step) -> tuple[float, float]:
    """Seconds from and to which a vibration is there, all the time without them."""
    p = step.parameters
    begin, end = p.get("from"), p.get("to")
    return -np.inf if begin is None else begin, np.inf if end is None else end


def _touch(a: tuple[float, float], b: tuple[float, float]) -> bool:
    return a[0] <= b[1] + 1.0 and b[0] <= a[1] + 1.0


def alike(a: Step, b: Step) -> bool:
    """Whether two views have found one thing."""
    if a.effect != b.effect:
        return False
    p, q = a.parameters, b.parameters
    if a.effect == "vibration":
        return abs(p["frequency"] - q["frequency"]) < 0.02 * p["frequency"]
    for key in ("start", "time"):
        if key in p and key in q:
            return bool(np.abs(p[key] - q[key]) < 5.0)
    return True


def moved(step: Step, faults: float, rest: float) -> Step:
    """A step of the record with later times: those of faults by `faults` s, of others by `rest`."""
    p = dict(step.parameters)
    for key in ("start", "time"):
        if p.get(key) is not None and step.effect in ("disturbance", "tilt"):
            p[key] = p[key] + faults
    for key in ("from", "to"):
        if p.get(key) is not None:
            p[key] = p[key] + rest
    timed = step.effect in TIMED and (faults or rest)
    return replace(step, parameters=p, where=_where(step, faults or rest) if timed else step.where)


def _where(step: Step, start: float) -> str:
    return f"{step.where.rstrip('.')}; seconds of the part that begins at {start:.0f} s"
