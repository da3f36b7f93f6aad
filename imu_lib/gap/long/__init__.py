"""The gap workflow on a record that stays on disk.

A record of days is looked at twice. A part at the full rate, the one most like all the rest, shows
the electronics, the lines and the noises that are quick; the whole record, as means of blocks, shows
what is slow. Means of blocks are what a moving average of that length gives, read once a block: the
model of one view is that of the other behind one more filter, and the same workflow goes over both.
One pass over the record makes the means, and holds every window of some minutes against the others:
what is unlike them is looked at in full.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from imu_lib import likelihood, scheduler, units
from imu_lib.errors import InputError
from imu_lib.gap import ensemble, loop
from imu_lib.gap.found import Report
from imu_lib.gap.long import joined, looked_at, views
from imu_lib.gap.long.scan import scan
from imu_lib.gap.long.windows import stretches, typical_run
from imu_lib.model import Model
from imu_lib.processes import GaussMarkov, Sum, Telegraph

#: Samples of the part at the full rate, and block means at the most.
PART, MEANS = 1 << 19, 1 << 18


@dataclass(frozen=True)
class LongReport(Report):
    """What was found in a long record; `views`: the reports of the part at the full rate and of the
    block means, each with the record that it is of.
    """

    views: tuple[Report, ...] = ()


def close(
    record,
    model: Model | None = None,
    *,
    channels=None,
    seed: int = 0,
    simulations: int = ensemble.SIZE,
    jobs: int | None = None,
    progress=None,
) -> LongReport:
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
    say = _Told(progress)
    block = max(2, -(-record.longest // MEANS))
    say.at(0, "one pass over the record")
    scans = {s.name: s for s in scheduler.shared(scan, [(record, n, runs, block) for n in names], jobs)}  # fmt: skip
    scans = [scans[n] for n in names]
    unlike, scores = stretches(scans)
    window = scans[0].window
    count = min(max(PART // window, 1), scores.shape[1])
    first = typical_run(scores, count)
    # -- a part at the full rate
    low, high = views.rows(record, first * window, (first + count) * window)
    start = first * window / fs
    options = {"seed": seed, "simulations": simulations, "jobs": jobs}
    part = replace(record.part(low, high), notes=())
    fast = loop.close(
        part,
        None if model is None else views.shifted(model, start, part.duration),
        channels=names,
        progress=partial(say.of, "a part at the full rate", 5, 45),
        **options,
    )
    names = [n for n in names if n in fast.channels]
    rate = fs / block
    given = _with_bases(model, fast, scans, rate)
    own = [s for s in scans if s.name in names]
    means = views.averages(record, own, _warmth(record, runs, block))
    free = [n for n in names if model is None or n not in model]
    given = _between_levels(means, given, free, block, options)
    kept = {n: joined.kept(given[n], fast.model[n], rate) for n in names}
    # -- windows unlike the rest
    steps = joined.of_part(fast, rate, start)
    grown = replace(
        given, channels=kept, record=given.record + tuple(looked_at.process_of(s) for s in steps)
    )
    notes, left = [], [fast.record_unexplained]
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
    # -- the whole record as means
    say.at(60, "the whole record")
    common = tuple(p for p in fast.model.record if p.name == "common_mode")
    slow_given = Model(
        {n: views.averaged(kept[n], block, fs)[0] for n in names}, record=common, rate=rate
    )
    slow = loop.close(
        means, slow_given, progress=partial(say.of, "the whole record", 60, 39), **options
    )
    # -- both together
    lines = joined.lines_of(steps)
    reports, models = {}, {}
    for n in names:
        reports[n], models[n] = joined.channel(
            n, given[n], kept[n], fast.channels[n], slow.channels.get(n), lines, block, record
        )
    steps = joined.of_whole(steps, slow, lines, rate, record.longest / fs)
    grown = replace(
        given,
        channels=models,
        record=given.record + tuple(looked_at.process_of(s) for s in steps),
        rate=fs,
        name=given.name or record.name,
        source="imu-lib gap",
    )
    left.append(slow.record_unexplained)
    say.at(100, "done")
    return LongReport(
        reports,
        steps,
        next((t for t in left if t), None),
        replace(given, channels={n: given[n] for n in names}),
        grown,
        record,
        time.perf_counter() - began,
        model is not None,
        (*_said(record, fast, slow, start, block), *notes),
        views=(fast, slow),
    )


def _at_once(record, model, channels, seed, simulations, jobs, progress) -> Report:
    """A record whose gaps leave no long part: the longest one at the full rate."""
    low, high = views.rows(record, 0, record.longest)
    part = replace(record.part(low, high), notes=record.notes)
    options = {"channels": channels, "seed": seed, "simulations": simulations}
    found = loop.close(part, model, jobs=jobs, progress=progress, **options)
    used = (
        f"The longest part without a gap of more than 10 samples was used, "
        f"{units.duration(part.duration)} of {units.duration(record.duration)}."
    )
    return replace(found, notes=(used, *found.notes))


def _names(record, channels):
    wanted = record.channel_names if channels is None else channels
    for name in channels or ():
        if name not in record:
            raise ValueError(f"`channels` has {name!r}, which the record lacks")
    names = [n for n in wanted if n not in record.flat]
    if not names:
        raise InputError(
            f"{record.source}: no channel says anything of its noise (none ever changes); check the "
            "logger."
        )
    return names


def _with_bases(model, fast, scans, rate) -> Model:
    """The given model; a channel that it lacks has what the part at the full rate was started
    from, with the slow processes that the likelihood chooses for the block means.
    """
    found = {}
    for s in scans:
        if s.name in fast.channels and (model is None or s.name not in model):
            base = fast.channels[s.name].result.base
            quick = [t for t in base.terms if not views.is_slow(t, rate)]
            found[s.name] = Sum((*quick, *_slow_terms(s.means, rate)), base.stages)
    if model is None:
        return Model(found, rate=fast.record.rate)
    return replace(model, channels={**model.channels, **found})


def _between_levels(means, given: Model, free, block: int, options) -> Model:
    """The model without the Gauss-Markov processes that two levels explain better, of the channels
    `free` whose slow processes nobody gave: the spectrum of both is the same.
    """
    bare = {}
    for n in free:
        entry = given[n]
        slow = [
            t for t in entry.terms if isinstance(t, GaussMarkov) and views.is_slow(t, means.rate)
        ]
        if slow:
            bare[n] = Sum(tuple(t for t in entry.terms if t not in slow), entry.stages)
    if not bare:
        return given
    begun = {n: views.averaged(entry, block, means.rate * block)[0] for n, entry in bare.items()}
    found = loop.close(
        means, Model(begun, rate=means.rate), channels=list(bare), **options | {"simulations": 0}
    )
    levels = {
        n: bare[n]
        for n, c in found.channels.items()
        if any(s.effect == Telegraph.name for s in c.result.steps)
    }
    return replace(given, channels={**given.channels, **levels})


def _slow_terms(means, rate):
    """The slow processes of the sum that the likelihood chooses for a series of block means."""
    stats = likelihood.Statistics.of([means], rate, exclude_lines=True)
    fit = likelihood.choose(stats.between(0.0, 0.2 * rate), None).fit
    return [t for t in fit.model.terms if views.is_slow(t, rate)]


def _warmth(record, runs, block):
    """Block means of the temperature, or None."""
    if record.temperature is None:
        return None
    from imu_lib.stream import Keep, Means

    kept = Keep()
    means = Means(block, [kept])
    for x in record.pieces("temperature", runs):
        means.feed(x)
    out = kept.values
    return ensemble.filled(out) if np.isfinite(out).any() else None


class _Told:
    """Progress over the stages, in hundredths."""

    def __init__(self, progress):
        self.progress = progress

    def at(self, done, text):
        if self.progress is not None:
            self.progress(done, 100, text)

    def of(self, stage, first, share, done, total, text):
        self.at(first + round(share * done / total), f"{stage}: {text}")


def _said(record, fast, slow, start, block) -> list[str]:
    """What was looked at, and what the two views say themselves."""
    out = []
    used, covered = record.longest / record.rate, record.duration
    if covered - used > 1.0:
        out.append(
            f"The longest part without a gap of more than 10 samples was used, {used / 3600:.4g} of "
            f"{covered / 3600:.4g} h."
        )
    out.append(
        f"The record was looked at twice: {fast.record.duration / 60:.3g} min at the full rate from "
        f"{units.duration(start)} on, which are most like the rest, and all of it as means of "
        f"{block} samples; the gap of a step is that of the view that shows it."
    )
    return out + [*fast.notes, *(n for n in slow.notes if n not in fast.notes)]
