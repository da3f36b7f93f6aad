"""One result out of the two views of a long record."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.ensembles import ensemble
from imu_lib.ensembles.ensemble import Index
from imu_lib.gap.channel import ChannelResult
from imu_lib.gap.found import ChannelReport, Report
from imu_lib.gap.long import looked_at
from imu_lib.gap.long.views import LINE, averaged, belongs_to_means, is_slow
from imu_lib.gap.steps import Step
from imu_lib.long_record.record import LongRecord
from imu_lib.processes import Sinusoid, Sum, WhiteNoise

#: Relative change of a noise that the means show beside electronics, which is theirs, and nearness
#: of a line to the image of a fast one, in widths of an ordinate.
ELECTRONICS, IMAGE = 0.05, 3.0
#: Stages that change the level of block means by what no closed form tells.
THROUGH = ("resolution", "spikes", "stuck", "saturation", "heavy_tails")


def kept(given: Sum, grown: Sum, rate: float) -> Sum:
    """The given channel with what a part at the full rate has added or changed, without what is the
    whole record's affair. `grown` starts with the terms of `given`, in order.
    """
    grown_terms = [t for t in grown.terms]
    aligned = _aligned(given.terms, grown_terms)
    terms = []
    for t, g in zip(given.terms, aligned):
        fixed = t.deterministic or is_slow(t, rate) or g is None
        terms.append(t if fixed else g)
    used = {id(g) for g in aligned if g is not None}
    extra = [g for g in grown_terms if id(g) not in used and not is_slow(g, rate)]
    return Sum((*terms, *extra), grown.stages)


def _aligned(terms: Iterable[Any], grown: Iterable[Any]) -> list[Any]:
    """For each term the one of its kind, in order, that the grown model has in its place."""
    left, out = list(grown), []
    for t in terms:
        found = next((g for g in left if g.name == t.name), None)
        left = [g for g in left if g is not found]
        out.append(found)
    return out


def whole(fast: Sum, slow: Sum, block: int, fs: float) -> Sum:
    """The channel's model at the full rate, out of that of the part and that of the means.

    fast : as `kept` gives it. slow : the grown model of the means, which began as `averaged(fast)`.
    """
    began, places = averaged(fast, block, fs)
    aligned = _aligned(began.terms, slow.terms)
    terms: list[Any] = list(fast.terms)
    for b, g, place in zip(began.terms, aligned, places):
        if g is None or place < 0 or g == b:
            continue
        if isinstance(b, WhiteNoise) and b.name == WhiteNoise.name:
            added = b.N**2 - terms[place].N ** 2
            g = g.with_(N=float(np.sqrt(max(g.N**2 - added, 1e-4 * g.N**2))))
        terms[place] = g
    used = {id(g) for g in aligned if g is not None}
    terms += [g for g in slow.terms if id(g) not in used]
    had = {s.name for s in fast.stages}
    stages = [s for s in slow.stages if s.name not in had and s.name != "low_pass"]
    return Sum(tuple(terms), (*fast.stages, *stages))


def of_means(
    step: Step, fast: Sum, lines: list[tuple[float, float]], rate: float, duration: float
) -> bool:
    """Whether an effect found in the means is one, and not what the electronics or a fast line do
    to means.
    """
    p = step.parameters
    if step.effect == "parameter_change" and p["process"] == "white_noise":
        through = any(s.name in THROUGH for s in fast.stages)
        return not (through and abs(p["to"] / p["from"] - 1) < ELECTRONICS)
    if step.effect in ("sinusoid", "vibration"):
        for f, width in lines:
            image = abs((f + rate / 2) % rate - rate / 2)
            if abs(image - p["frequency"]) < width + IMAGE / duration:
                return False
    return True


def channel(
    name: str,
    given: Sum,
    kept: Sum,
    fast: ChannelReport,
    slow: ChannelReport | None,
    lines: list[tuple[float, float]],
    block: int,
    record: LongRecord,
) -> tuple[ChannelReport, Sum]:
    """(report, model) of a channel: the steps of both views, each with the gap of its own view, the
    gap over the statistics of both. `slow` is None where the means say nothing of it.
    """
    fs = record.rate
    rate = fs / block
    quick = [s for s in fast.result.steps if not belongs_to_means(s, given, rate)]
    if slow is None:
        return replace(fast, batteries={}), kept
    lines = [*lines, *((t.frequency, 0.0) for t in kept.terms if isinstance(t, Sinusoid))]
    seen = slow.result.steps
    late = [s for s in seen if of_means(s, kept, lines, rate, record.longest / fs)]
    model = whole(kept, slow.result.model, block, fs) if len(late) == len(seen) else kept
    f, s = fast.result, slow.result
    left = f.unexplained
    if left is None and s.unexplained is not None:
        left = f"below {rate / 2:.3g} Hz, over the whole record: {s.unexplained}"
    result: ChannelResult = replace(
        f,
        name=name,
        base=given,
        model=model,
        steps=quick + late,
        absorbed=list(dict.fromkeys([*f.absorbed, *s.absorbed])),
        unexplained=left,
        checks=[*f.checks, *s.checks],
        small=list(dict.fromkeys([*f.small, *s.small])),
        mean=s.mean,
        evidence=f.evidence + s.evidence,
    )
    before, after = _indices(fast, slow)
    return ChannelReport(result, before, after, _held_out(fast, slow), {}), model


def of_part(fast: Report, rate: float, start: float) -> list[Step]:
    """Steps of the record that a part at the full rate shows, with their times in the whole."""
    rest = start + (fast.stretch[0] if fast.stretch else 0.0)
    out = []
    for s in fast.record_steps:
        below = s.effect == "vibration" and s.parameters["frequency"] < LINE * rate
        if s.effect not in ("tilt", "time_gaps") and not below:
            out.append(looked_at.moved(s, start, rest))
    return out


def of_whole(
    steps: list[Step], slow: Report, lines: list[tuple[float, float]], rate: float, duration: float
) -> list[Step]:
    """The steps of the record, with those that the means alone show."""
    out = list(steps)
    offset = slow.stretch[0] if slow.stretch else 0.0
    for s in slow.record_steps:
        s = looked_at.moved(s, 0.0, offset)
        if of_means(s, Sum(), lines, rate, duration):
            if not any(looked_at.alike(s, t) for t in out):
                out.append(s)
    return out


def lines_of(steps: list[Step]) -> list[tuple[float, float]]:
    """(frequency, width), Hz, of the vibrations among steps of the record, whole multiples
    included.
    """
    out = []
    for s in steps:
        if s.effect == "vibration":
            p = s.parameters
            each = p.get("lines") or [p["frequency"] * (h + 1) for h in range(p["harmonics"])]
            out += [(f, p["bandwidth"]) for f in each]
    return out


def _indices(fast: ChannelReport, slow: ChannelReport) -> tuple[Index | None, Index | None]:
    if not fast.batteries or not slow.batteries:
        return None, None
    measured = _both(fast.batteries["measured"], slow.batteries["measured"])

    def gap(when: str) -> Index:
        rows = zip(fast.batteries[when], slow.batteries[when])
        return ensemble.index(measured, [_both(a, b) for a, b in rows])

    return gap("before"), gap("after")


def _both(fast: dict[str, Array], slow: dict[str, Array]) -> dict[str, Array]:
    """The statistics of both views; those of the means have domains of their own."""
    return {**fast, **{f"{d} of the means": v for d, v in slow.items()}}


def _held_out(fast: ChannelReport, slow: ChannelReport) -> dict[str, float] | None:
    """Root mean square of the views' gaps on time that was not fitted."""
    found = [r.held_out for r in (fast, slow) if r.held_out]
    if not found:
        return None
    return {
        when: round(float(np.sqrt(np.mean([h[when] ** 2 for h in found]))), 4)
        for when in ("before", "after")
    }
