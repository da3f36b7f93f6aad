"""Stretches that a tilt, a restart or a long hole parts from the one that the model is of: what
they have that it has not is told, too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.errors import InputError
from imu_lib.faults.finding import seconds
from imu_lib.gap.found import Report
from imu_lib.gap.long.looked_at import alike, moved, process_of
from imu_lib.gap.long.views import shifted
from imu_lib.gap.loop import close
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.processes import Vibration
from imu_lib.record import Record

#: Samples of a stretch that is looked at, at the least, and stretches at the most.
LEAST, MOST = 4000, 3
#: Confidence below which an effect of another stretch is not told: a flicker looks like a warm-up
#: now and then (one of 14 calm records).
SURE = 0.9
#: Effects that were looked for in the whole record.
OF_WHOLE = ("disturbance", "dropout", "jitter", "rate_error", "tilt", "time_gaps")


def looked_at(found: Report, record: Record, model: Model | None, **options: Any) -> Report:
    """The report with what its other stretches have: vibrations as steps, all else as what is left.

    `model` and `options` are those of `gap.loop.close`.
    """
    steps, left, grown = list(found.record_steps), [], found.model
    # a clock that is wrong has stretched the times of the report
    pace, begin = record.duration / (found.whole or record.duration), (found.stretch or (0.0,))[0]
    for start, stop in found.others[:MOST]:
        part = record.slice(pace * start, pace * stop)
        if part.n < LEAST:
            continue
        seen = _seen(part, model, list(found.channels), pace * start, options)
        if seen is None:
            continue
        at = start + (seen.stretch or (0.0,))[0]
        for s in _shaking(seen, steps):
            where = f"{s.where}; seconds of the part that begins at {at:.0f} s of the record"
            s = replace(moved(s, 0.0, at - begin), where=where)
            steps.append(s)
            if s.parameters["from"] >= 0:
                grown = replace(grown, record=(*grown.record, process_of(s)))
        names = _others(found, seen)
        if names:
            left.append(
                f"from {seconds(start)} to {seconds(stop)} s of the record, which the model is not "
                f"of: {'; '.join(names)}"
            )
    told = "; ".join(filter(None, [found.record_unexplained, *left])) or None
    return replace(found, record_steps=steps, record_unexplained=told, model=grown)


def _seen(
    part: Record, model: Model | None, channels: list[str], start: float, options: dict[str, Any]
) -> Report | None:
    """What a stretch that begins at `start` s has; None where it is too little to look at."""
    names = [c for c in channels if np.nanstd(part.channels[c]) > 0]
    given = None if model is None else shifted(model, start, part.duration)
    of = {k: v for k, v in options.items() if k in ("seed", "jobs")}
    try:
        return close(part, given, channels=names, simulations=0, **of)
    except (InputError, ValueError):
        return None


def _shaking(seen: Report, known: list[Step]) -> list[Step]:
    """The vibrations of a stretch that are not known, each with its times in it."""
    new = [s for s in seen.record_steps if s.effect == Vibration.name]
    new = [s for s in new if not any(alike(s, t) for t in known)]
    whole = {"from": 0.0, "to": seen.record.duration}
    return [
        s if s.parameters.get("from") is not None else replace(s, parameters=s.parameters | whole)
        for s in new
    ]


def _others(found: Report, seen: Report) -> list[str]:
    """What else a stretch has that the one looked at has not, in words."""
    known = {(where, s.effect) for where, s in found.steps}
    names = [
        f"{s.effect} on {'all channels' if where == 'record' else where} ({s.where})"
        for where, s in seen.steps
        if (where, s.effect) not in known
        and s.confidence > SURE
        and s.effect not in (*OF_WHOLE, Vibration.name)
    ]
    for name, c in seen.channels.items():
        if c.result.unexplained and not found.channels[name].result.unexplained:
            names.append(f"{c.result.unexplained} on {name}")
    return names
