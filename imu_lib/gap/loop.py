"""The workflow on a record: what is on all of it, then every channel, then the gap before and
after.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from imu_lib.ensembles import ensemble
from imu_lib.gap import axes, gauge, knock_jumps, left_beside
from imu_lib.gap.channel import ChannelResult, analyse
from imu_lib.gap.found import ChannelReport, Report
from imu_lib.gap.parallel import each
from imu_lib.gap.prepared import Prepared, prepared
from imu_lib.gap.preprocess import OfRecord
from imu_lib.gap.steps import Step
from imu_lib.gap.tilt_jumps import as_tilts
from imu_lib.model import Model
from imu_lib.processes import Sum
from imu_lib.record import Record

#: Called with (done, total, text).
Progress = Callable[[int, int, str], object]


def close(
    record: Record,
    model: Model | None = None,
    *,
    channels: Sequence[str] | None = None,
    seed: int = 0,
    simulations: int = ensemble.SIZE,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Report:
    """Find where simulations of `model` and `record` disagree, name what is missing, add it, and
    measure the gap again.

    Parameters
    ----------
    record : Record
        A static record.
    model : Model, optional
        What the record is compared with, its parameters held. None: a model is fitted first.
    channels : sequence of str, optional
        Which channels; all of the record where not given. One that the model does not have is
        started from a fit of its own.
    seed : int
    simulations : int
        Size of the ensembles; 0 leaves the gap index out.
    jobs : int, optional
        Processes; 2 where there are two cores.
    progress : callable, optional
        Called with (done, total, text).

    Raises
    ------
    ValueError
        If `channels` names one that the record lacks or that does not move.
    InputError
        If less than 2000 samples are left without faults, or no channel says anything of its noise.
    """
    started = time.perf_counter()
    jobs = jobs or min(2, os.cpu_count() or 1)
    about = prepared(record, model, channels)
    told = _Told(progress, len(about.raw) + 1 + (4 if simulations else 0))
    told.one("coherence")
    results = _named(about, seed, jobs, told)
    base, grown = _models(about, results)
    results = left_beside.on_record(axes.agreed(results), about.left)
    results = knock_jumps.with_causes(results, about)
    reports = {name: ChannelReport(result) for name, result in results.items()}
    if simulations:
        reports = gauge.measured(
            reports, about, simulations, seed, jobs, lambda _: told.one("simulations")
        )
    # the jumps stay in the models of their channels, which the gap is measured with
    results, moved = as_tilts({name: r.result for name, r in reports.items()}, about)
    reports = {name: replace(reports[name], result=result) for name, result in results.items()}
    seconds = time.perf_counter() - started
    # at the rate that the clock really has
    steps, whole = [*about.steps, *moved], about.pace.record.duration
    return _report(about, reports, steps, (base, grown), seconds, whole)


def _report(
    about: Prepared,
    reports: dict[str, ChannelReport],
    steps: list[Step],
    models: tuple[Model, Model],
    seconds: float,
    whole: float,
) -> Report:
    ready = about.ready
    return Report(
        reports,
        steps,
        ready.doubt or about.left,
        *models,
        ready.record,
        seconds,
        about.model is not None,
        (*about.said, *ready.notes),
        (ready.start, ready.stop),
        others=ready.others,
        whole=whole,
        invisible=_invisible(about),
        absent=about.gone,
        lost=ready.lost,
    )


def _invisible(about: Prepared) -> tuple[dict[str, str], ...]:
    """What nothing in the record tells of."""
    why = about.pace.invisible
    return ({"effect": "rate_error", "parameter": "ratio", "why": why},) if why else ()


class _Told:
    """How far it is, to whom it may concern."""

    def __init__(self, progress: Progress | None, total: int) -> None:
        self.progress, self.total, self.done = progress, total, 0

    def one(self, text: str) -> None:
        """One more of all is done."""
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.total, text)


def _named(about: Prepared, seed: int, jobs: int, told: _Told) -> dict[str, ChannelResult]:
    """What every channel lacks, by name in the order of the record."""
    work = [(about, name, seed) for name in about.raw]
    if jobs > 1:  # a process is sent its own channel only
        work = [(about.alone(name), name, seed) for name in about.raw]
    results: dict[str, ChannelResult] = {}
    for name, result in each(_channel, work, jobs):
        results[name] = result
        told.one(f"{name}: {', '.join(s.effect for s in result.steps) or 'nothing'}")
    return {name: results[name] for name in about.raw}


def _channel(about: Prepared, name: str, seed: int) -> tuple[str, ChannelResult]:
    return name, analyse(
        name,
        about.raw[name],
        about.fs,
        about.base(name),
        temperature=about.temperature,
        seed=seed,
        of_record=OfRecord(
            about.noise[name],
            about.filtered,
            about.known.get(name),
            about.nameless.get(name, ""),
            name in about.bands,
        ),
    )


def _base(about: Prepared, name: str, result: ChannelResult) -> Sum:
    """The model that a channel started from, with what of it the record does not have."""
    whole = about.lacking(name)
    return result.base if whole is None else whole


def _models(about: Prepared, results: dict[str, ChannelResult]) -> tuple[Model, Model]:
    """The model that it started from, and the grown one."""
    base = Model(
        channels={n: _base(about, n, r) for n, r in results.items()},
        record=about.as_given,
        rate=about.fs,
    )
    grown = Model(
        channels={n: r.model for n, r in results.items()},
        record=about.given + about.processes,
        rate=about.fs,
        name=(about.model.name if about.model is not None else "") or about.ready.record.name,
        source="imu-lib gap",
    )
    return base, grown
