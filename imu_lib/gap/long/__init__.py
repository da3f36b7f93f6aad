"""The gap workflow on a record that stays on disk.

A record of days is looked at twice. A part at the full rate, the one most like all the rest, shows
the electronics, the lines and the noises that are quick; the whole record, as means of blocks,
shows what is slow. Means of blocks are what a moving average of that length gives, read once a
block: the model of one view is that of the other behind one more filter, and the same workflow
goes over both. One pass over the record makes the means, and holds every window of some minutes
against the others: what is unlike them is looked at in full.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from imu_lib import scheduler, units
from imu_lib.arrays import Array
from imu_lib.ensembles import ensemble
from imu_lib.errors import InputError
from imu_lib.gap import absent, loop
from imu_lib.gap.found import Report
from imu_lib.gap.long import begun, joined, looked_at, views
from imu_lib.gap.long.progress import Told
from imu_lib.gap.long.scan import Scan, scan
from imu_lib.gap.long.windows import Stretch, stretches, typical_run
from imu_lib.gap.steps import Step
from imu_lib.long_record.record import LongRecord
from imu_lib.model import Model
from imu_lib.processes import Sum
from imu_lib.stream import Keep, Means

#: Samples of the part at the full rate, and block means at the most.
PART, MEANS = 1 << 19, 1 << 18


@dataclass(frozen=True)
class LongReport(Report):
    """What was found in a long record; `views`: the reports of the part at the full rate and of the
    block means, each with the record that it is of.
    """

    views: tuple[Report, ...] = ()


def close(
    record: LongRecord,
    model: Model | None = None,
    *,
    channels: Sequence[str] | None = None,
    seed: int = 0,
    simulations: int = ensemble.SIZE,
    jobs: int | None = None,
    progress: loop.Progress | None = None,
) -> Report:
    """As `gap.close`, of a `LongRecord`: of its longest part without a gap, in bounded memory.

    Raises
    ------
    ValueError, InputError
        As `gap.loop.close`.
    """
    began = time.perf_counter()
    if record.longest <= 2 * PART:
        return _at_once(record, model, channels, seed, simulations, jobs, progress)
    names, fs, runs = _names(record, channels), record.rate, record.continuous()
    jobs = jobs or min(2, os.cpu_count() or 1)
    say = Told(progress)
    block = max(2, -(-record.longest // MEANS))
    say.at(0, "one pass over the record")
    work = [(record, n, runs, block) for n in names]
    of: dict[str, Scan] = {s.name: s for s in scheduler.shared(scan, work, jobs)}
    scans = [of[n] for n in names]
    unlike, scores = stretches(scans)
    options: dict[str, Any] = {"seed": seed, "simulations": simulations, "jobs": jobs}
    start, fast = _part(record, model, scans, scores, say, options)
    names = [n for n in names if n in fast.channels]
    rate = fs / block
    given = begun.with_bases(None if model is None else _there(model, fast), fast, scans, rate)
    means = views.averages(record, [of[n] for n in names], _warmth(record, runs, block))
    free = [n for n in names if model is None or n not in model]
    given = begun.between_levels(means, given, free, block, options)
    kept = {n: joined.kept(given[n], fast.model[n], rate) for n in names}
    steps = joined.of_part(fast, rate, start)
    grown = replace(given, channels=kept, record=_of_record(given, steps))
    steps, said, left = _looked_at(record, grown, steps, unlike, scans[0].window, rate, seed, say)
    say.at(60, "the whole record")
    common = tuple(p for p in fast.model.record if p.name == "common_mode")
    slow_given = Model(
        {n: views.averaged(kept[n], block, fs)[0] for n in names}, record=common, rate=rate
    )
    progress_of = partial(say.of, "the whole record", 60, 39)
    slow = loop.close(means, slow_given, progress=progress_of, **options)
    say.at(100, "done")
    notes = (*_said(record, fast, slow, start, block), *said)
    without = [fast.record_unexplained, *left, slow.record_unexplained]
    looks = _Looks(record, given, model is not None, kept, fast, slow, block)
    return looks.together(steps, notes, without, began)


def _there(model: Model, fast: Report) -> Model:
    """The given model less what a part at the full rate does not have of what is in every part."""
    everywhere = ("vibration", "common_mode")
    gone = [a for a in fast.absent if not a.term and a.process.name in everywhere]
    return absent.without(model, gone)


def _of_record(given: Model, steps: Iterable[Step]) -> tuple[Any, ...]:
    return given.record + tuple(looked_at.process_of(s) for s in steps)


def _part(
    record: LongRecord,
    model: Model | None,
    scans: list[Scan],
    scores: Array,
    say: Told,
    options: dict[str, Any],
) -> tuple[float, Report]:
    """The part at the full rate that is most like the rest: where it begins, s, and what is
    found.
    """
    window, fs = scans[0].window, record.rate
    count = min(max(PART // window, 1), scores.shape[1])
    first = typical_run(scores, count)
    low, high = views.rows(record, first * window, (first + count) * window)
    start, part = first * window / fs, replace(record.part(low, high), notes=())
    found = loop.close(
        part,
        None if model is None else views.shifted(model, start, part.duration),
        channels=[s.name for s in scans],
        progress=partial(say.of, "a part at the full rate", 5, 45),
        **options,
    )
    return start, found


def _looked_at(
    record: LongRecord,
    grown: Model,
    steps: list[Step],
    unlike: list[Stretch],
    window: int,
    rate: float,
    seed: int,
    say: Told,
) -> tuple[list[Step], list[str], list[str]]:
    """Windows unlike the rest, of which `grown` is the model: the steps with theirs, what is said
    of them, and what is left there without a name.
    """
    notes, left = [], []
    for k, found in enumerate(unlike[: looked_at.MOST]):
        say.at(50 + k, f"{k + 1} of {len(unlike)} stretches unlike the rest")
        seen = looked_at.look(record, grown, found, window, rate, seed)
        steps = looked_at.together(steps, seen.steps)
        notes.append(f"{seen.sentence[0].upper()}{seen.sentence[1:]}.")
        if seen.left:
            left.append(seen.sentence)
    if len(unlike) > looked_at.MOST:
        notes.append(
            f"{len(unlike) - looked_at.MOST} more stretches are unlike the rest; the "
            f"{looked_at.MOST} that are most so were looked at."
        )
    return steps, notes, left


@dataclass(frozen=True)
class _Looks:
    """Both views of a record: what each has found, and the models that they began with.

    given : the model of all channels. by_hand : whether somebody gave it. kept : the channels that
    the means began with. block : samples of a mean.
    """

    record: LongRecord
    given: Model
    by_hand: bool
    kept: dict[str, Sum]
    fast: Report
    slow: Report
    block: int

    def together(
        self,
        steps: list[Step],
        notes: tuple[str, ...],
        left: Iterable[str | None],
        began: float,
    ) -> LongReport:
        """One report, with the steps of the record, from `began` on."""
        record, given, fast, slow = self.record, self.given, self.fast, self.slow
        lines, fs = joined.lines_of(steps), record.rate
        reports, models = {}, {}
        for n, own in self.kept.items():
            views_of = fast.channels[n], slow.channels.get(n)
            reports[n], models[n] = joined.channel(
                n, given[n], own, *views_of, lines, self.block, record
            )
        steps = joined.of_whole(steps, slow, lines, fs / self.block, record.longest / fs)
        grown = replace(
            given,
            channels=models,
            record=_of_record(given, steps),
            rate=fs,
            name=given.name or record.name,
            source="imu-lib gap",
        )
        return LongReport(
            reports,
            steps,
            next((t for t in left if t), None),
            replace(given, channels={n: given[n] for n in self.kept}),
            grown,
            record,
            time.perf_counter() - began,
            self.by_hand,
            notes,
            absent=tuple(a for a in fast.absent if a.process not in given.record),
            views=(fast, slow),
        )


def _at_once(
    record: LongRecord,
    model: Model | None,
    channels: Sequence[str] | None,
    seed: int,
    simulations: int,
    jobs: int | None,
    progress: loop.Progress | None,
) -> Report:
    """A record whose gaps leave no long part: the longest one at the full rate."""
    low, high = views.rows(record, 0, record.longest)
    part = replace(record.part(low, high), notes=record.notes)
    options: dict[str, Any] = {"channels": channels, "seed": seed, "simulations": simulations}
    found = loop.close(part, model, jobs=jobs, progress=progress, **options)
    used = (
        f"The longest part without a gap of more than 10 samples was used, "
        f"{units.duration(part.duration)} of {units.duration(record.duration)}."
    )
    return replace(found, notes=(used, *found.notes))


def _names(record: LongRecord, channels: Sequence[str] | None) -> list[str]:
    wanted = record.channel_names if channels is None else channels
    for name in channels or ():
        if name not in record:
            raise ValueError(f"`channels` has {name!r}, which the record lacks")
    names = [n for n in wanted if n not in record.flat]
    if not names:
        raise InputError(
            f"{record.source}: no channel says anything of its noise (none ever changes); check "
            "the logger."
        )
    return names


def _warmth(record: LongRecord, runs: Array, block: int) -> Array | None:
    """Block means of the temperature, or None."""
    if record.temperature is None:
        return None
    kept = Keep()
    means = Means(block, [kept])
    for x in record.pieces("temperature", runs):
        means.feed(x)
    out = kept.values
    return ensemble.filled(out) if np.isfinite(out).any() else None


def _said(record: LongRecord, fast: Report, slow: Report, start: float, block: int) -> list[str]:
    """What was looked at, and what the two views say themselves."""
    out = []
    used, covered = record.longest / record.rate, record.duration
    if covered - used > 1.0:
        out.append(
            f"The longest part without a gap of more than 10 samples was used, {used / 3600:.4g} "
            f"of {covered / 3600:.4g} h."
        )
    out.append(
        f"The record was looked at twice: {fast.record.duration / 60:.3g} min at the full rate "
        f"from {units.duration(start)} on, which are most like the rest, and all of it as means of "
        f"{block} samples; the gap of a step is that of the view that shows it."
    )
    return out + [*fast.notes, *(n for n in slow.notes if n not in fast.notes)]
