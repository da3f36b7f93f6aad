"""The gap before and after: ensembles of every channel's models, and their index against the
measurement.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.ensembles import ensemble, furthest
from imu_lib.ensembles.battery import battery
from imu_lib.gap.channel import ChannelResult
from imu_lib.gap.effects.resolution import printed
from imu_lib.gap.found import ChannelReport
from imu_lib.gap.grown import FITTED
from imu_lib.gap.parallel import each
from imu_lib.gap.prepared import Prepared
from imu_lib.processes import Sum

#: Gap index after the last step beyond which something is left that has no name; that of a right
#: model scatters by 0.06 about 1.
MAX_GAP_INDEX = 1.35
#: Part of an ensemble for the models on the way to the last: they are shown, and nothing hangs on
#: them.
PASSING = 0.25


#: (channel, place in its chain or what part it is for), and the batteries of its simulations.
Key = tuple[str, int | str]
Rows = dict[Key, list[ensemble.Battery]]


@dataclass(frozen=True)
class Job:
    """A model, or several that stand for what is uncertain in it, to be simulated from sample
    `start` on: `key` is (channel, place in its chain or what part it is for), `level` the mean
    before the electronics.
    """

    key: Key
    models: list[Sum]
    start: int
    beside: ensemble.Beside
    level: float
    passing: bool = False


def measured(
    reports: dict[str, ChannelReport],
    about: Prepared,
    simulations: int,
    seed: int,
    jobs: int,
    tick: Callable[[int], None],
) -> dict[str, ChannelReport]:
    """The reports (by channel) with gap indices: before, after each step, after all, and on the
    part that was held out.
    """
    work = [job for name, report in reports.items() for job in _jobs(name, report, about)]
    rows = _simulated(work, about, simulations, seed, jobs, tick)
    return {name: _gauged(report, name, about, rows) for name, report in reports.items()}


def _jobs(name: str, report: ChannelReport, about: Prepared) -> list[Job]:
    """What is simulated of a channel."""
    r, x = report.result, about.raw[name]
    digits, cut = _digits(r, x), int(FITTED * len(x))
    given = ensemble.Beside(about.held_noise(name), about.held_shaking(name), digits)
    found = ensemble.Beside(about.noise[name], about.shaking_of(name), digits)
    chain = [r.base, *r.between, r.model] if r.steps else [r.base]
    whole = about.lacking(name)
    same = (found.shared, found.vibrations) == (given.shared, given.vibrations)
    if whole is not None or not same:  # once as given, once beside and with what the record has
        chain = [r.base if whole is None else whole, *chain]

    def job(
        key: int | str,
        models: list[Sum],
        start: int,
        beside: ensemble.Beside,
        passing: bool = False,
    ) -> Job:
        level = ensemble.behind_mean(
            models[0], r.mean, len(x), about.fs, about.temperature, beside.shared
        )
        return Job((name, key), models, start, beside, level, passing)

    out = [
        job(i, [m], 0, found if i else given, 0 < i < len(chain) - 1) for i, m in enumerate(chain)
    ]
    if r.steps:
        out.append(job("held before", [chain[0]], cut, given))
        if r.refit:
            out.append(job("held after", r.refit, cut, found))
    return out


def _digits(result: ChannelResult, x: Array) -> float | None:
    """Step of the file's number format, where it is too fine to be the sensor's own grid."""
    coarse = result.model.find("resolution") is not None or result.model.rounding is not None
    return None if coarse else printed(x[~np.isnan(x)])


def _simulated(
    work: list[Job],
    about: Prepared,
    simulations: int,
    seed: int,
    jobs: int,
    tick: Callable[[int], None],
) -> Rows:
    """Batteries of the simulations of every job, by its key."""
    n = len(next(iter(about.raw.values())))
    lost = {name: np.isnan(x) if np.isnan(x).any() else None for name, x in about.raw.items()}
    seeds = [[seed, 7919, i] for i in range(simulations)]
    share = max(1, simulations // (2 * jobs))
    rows: Rows = {job.key: [] for job in work}
    tasks = []
    for i in range(0, simulations, share):
        these = [job for job in work if not job.passing or i < PASSING * simulations]
        models = [(j.models, j.start, n, j.beside, lost[j.key[0]]) for j in these]
        levels = [j.level for j in these]
        of_all = (n, about.fs, seeds[i : i + share], about.temperature, levels, about.filtered)
        tasks.append(([j.key for j in these], models, *of_all))
    for i, (keys, made) in enumerate(each(_ensemble, tasks, jobs)):
        for key, batteries in zip(keys, made):
            rows[key] += batteries
        tick(i + 1)
    return rows


def _ensemble(keys: list[Key], *args: Any) -> tuple[list[Key], list[list[ensemble.Battery]]]:
    return keys, ensemble.simulate(*args)


def _gauged(report: ChannelReport, name: str, about: Prepared, rows: Rows) -> ChannelReport:
    """The report of a channel with its gap indices, against the `rows` of simulations."""
    x, r = ensemble.filled(about.raw[name]), report.result
    whole = battery(x, about.fs, about.temperature)
    places = [k for k in rows if k[0] == name and not isinstance(k[1], str)]
    chain = [ensemble.index(whole, rows[k]) for k in places]
    after, steps = chain[-1], r.steps
    told = _far(after, whole, rows[places[-1]], (len(x), about.fs))
    if steps:
        values = [c.value for c in chain][-len(steps) - 1 :]
        steps = [
            replace(s, gap_before=a, gap_after=b) for s, a, b in zip(steps, values[:-1], values[1:])
        ]
    return replace(
        report,
        result=replace(r, steps=steps, unexplained=r.unexplained or told),
        before=chain[0],
        after=after,
        held_out=_held_out(name, x, about, rows),
        batteries={"measured": whole, "before": rows[(name, 0)], "after": rows[places[-1]]},
    )


def _far(
    after: ensemble.Index,
    measured: ensemble.Battery,
    rows: list[ensemble.Battery],
    of: tuple[int, float],
) -> str | None:
    """A sentence where the grown model is still further off than a right one would be; `of` are the
    number of samples and their rate.
    """
    if after.value <= MAX_GAP_INDEX:
        return None
    domain = max(after.domains, key=lambda d: after.domains[d])
    return (
        f"simulations of the grown model: gap index {after.value:.2f}, most in the domain "
        f"{domain} ({after.domains[domain]:.2f}): {furthest.sentence(domain, measured, rows, *of)}"
    )


def _held_out(name: str, x: Array, about: Prepared, rows: Rows) -> dict[str, float] | None:
    """Gap indices before and after on the part of the samples `x` that was not fitted."""
    if (name, "held after") not in rows:
        return None
    cut, warmth = int(FITTED * len(x)), about.temperature
    part = battery(x[cut:], about.fs, None if warmth is None else warmth[cut:])
    return {
        when: round(ensemble.index(part, rows[(name, f"held {when}")]).value, 4)
        for when in ("before", "after")
    }
