"""The workflow on a record: every channel, then what acts on all, then the gap before and after."""

from __future__ import annotations

import os
import time
from dataclasses import replace

import numpy as np
from joblib import Parallel, delayed

from imu_lib.gap import ensemble, faulty, record_level, shaken
from imu_lib.gap.battery import battery
from imu_lib.gap.channel import ChannelResult, analyse
from imu_lib.gap.effects.resolution import printed
from imu_lib.gap.found import ChannelReport, Report
from imu_lib.gap.grown import FITTED
from imu_lib.model import Model
from imu_lib.record import Record

#: Gap index after the last step beyond which something is left that has no name; that of a right
#: model scatters by 0.06 about 1.
MAX_GAP_INDEX = 1.35


def close(
    record: Record,
    model: Model | None = None,
    *,
    channels=None,
    seed: int = 0,
    simulations: int = ensemble.SIZE,
    jobs: int | None = None,
    progress=None,
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
    names = list(record.channel_names if channels is None else channels)
    for name in names:
        if name not in record:
            raise ValueError(f"`channels` has {name!r}, which the record lacks")
        if channels is not None and not np.nanstd(record.channels[name]) > 0:
            raise ValueError(
                f"`record` does not move in {name}; leave the channel out with `channels`"
            )
    ready = faulty.ready(replace(record, channels={c: record.channels[c] for c in names}), model)
    record, names = ready.record, list(ready.record.channel_names)
    jobs = jobs or min(2, os.cpu_count() or 1)
    tell = progress or (lambda done, total, text: None)
    even = record.uniform()
    fs = even.rate
    raw = shaken.on_levels({name: np.asarray(even.channels[name]) for name in names})
    temperature = None if even.temperature is None else np.array(even.temperature)
    if temperature is not None and np.isnan(temperature).any():
        temperature = ensemble.filled(temperature)
    total = len(names) + 1 + (4 if simulations else 0)
    held = tuple(p for p in model.record if p.name == "common_mode") if model is not None else ()
    shaking, known = shaken.vibrations(record, raw, fs, temperature, model)
    shared, note, coherence_left = record_level.shared_noise(
        {name: x - known.get(name, 0.0) for name, x in raw.items()},
        fs,
        held,
        None if model is None else model.channels,
    )
    tell(1, total, "coherence")
    noise = {name: 0.0 for name in names}
    for process in (*held, *([shared] if shared is not None else [])):
        for name in process.channels:
            if name in noise:
                noise[name] = float(np.hypot(noise[name], process.N))
    # -- the channels
    # ------------------------------------------------------------------------------------------
    filtered = any(p.filtered for p in (*held, *([shared] if shared is not None else [])))
    work = [
        (
            name,
            raw[name],
            fs,
            model[name] if model is not None and name in model else None,
            temperature,
            seed,
            noise[name],
            filtered,
            known.get(name),
        )
        for name in names
    ]
    results, done = {}, 1
    for name, result in _each(_channel, work, jobs):
        results[name] = result
        done += 1
        found = ", ".join(s.effect for s in result.steps) or "nothing"
        tell(done, total, f"{name}: {found}")
    results = {name: results[name] for name in names}
    base = Model(
        channels={n: r.base for n, r in results.items()},
        record=model.record if model is not None else (),
        rate=fs,
    )
    record_steps, extra = list(ready.steps), list(ready.processes)
    new = [f for f in shaking if not f.held]
    record_steps += [shaken.vibration_step(f) for f in new]
    extra += [f.process for f in new]
    if shared is not None:
        record_steps.append(record_level.common_step(shared, note))
        extra.append(shared)
    grown = Model(
        channels={n: r.model for n, r in results.items()},
        record=base.record + tuple(extra),
        rate=fs,
        name=(model.name if model is not None else "") or record.name,
        source="imu-lib gap",
    )
    reports = {name: ChannelReport(r) for name, r in results.items()}
    if simulations:
        reports = _measure(
            reports,
            raw,
            fs,
            temperature,
            noise,
            [f.process for f in shaking],
            model.record if model is not None else (),
            filtered,
            simulations,
            seed,
            jobs,
            lambda i: tell(done + i, total, "simulations"),
        )
    return Report(
        reports,
        record_steps,
        ready.doubt or coherence_left,
        base,
        grown,
        record,
        time.perf_counter() - started,
        model is not None,
        ready.notes,
        (ready.start, ready.stop),
    )


def _channel(name, x, fs, base, temperature, seed, shared, filtered, known):
    return name, analyse(
        name,
        x,
        fs,
        base,
        temperature=temperature,
        seed=seed,
        shared=shared,
        filtered=filtered,
        known=known,
    )


def _of(vibrations, name) -> tuple:
    """The vibrations on one channel alone, those that it feels."""
    return tuple(v for v in (p.of(name) for p in vibrations) if v is not None)


def _digits(result: ChannelResult, x) -> float | None:
    """Step of the file's number format, where it is too fine to be the sensor's own grid."""
    coarse = result.model.find("resolution") is not None or result.model.rounding is not None
    return None if coarse else printed(x[~np.isnan(x)])


def _each(function, work, jobs):
    if jobs == 1 or len(work) == 1:
        for args in work:
            yield function(*args)
        return
    yield from Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes="2M")(
        delayed(function)(*args) for args in work
    )


def _ensemble(these, *args):
    return these, ensemble.simulate(*args)


def _stages_of_model(result: ChannelResult) -> list:
    """Models between the base and the grown one, one more effect in each."""
    return [result.base, *result.between, result.model]


def _measure(
    reports, raw, fs, temperature, noise, shaking, given, filtered, simulations, seed, jobs, tick
):
    """Gap indices of every channel: before, after each step, after all, and on the held-out part."""
    n = len(next(iter(raw.values())))
    cut = int(FITTED * n)
    held = [p for p in given if p.name == "common_mode"]
    held_noise = {c: float(np.sqrt(sum(p.N**2 for p in held if c in p.channels))) for c in raw}
    held_shaking = {c: _of([p for p in given if p.name == "vibration"], c) for c in raw}
    work, keys, levels, passing = [], [], [], set()
    for name, report in reports.items():
        r = report.result
        lost = np.isnan(raw[name])
        lost = lost if lost.any() else None
        chain = _stages_of_model(r) if r.steps else [r.base]
        felt = _of(shaking, name)
        digits = _digits(r, raw[name])
        if noise[name] != held_noise[name] or felt != held_shaking[name]:
            chain = [r.base] + chain
        for i, m in enumerate(chain):
            own = ensemble.Beside(held_noise[name], held_shaking[name], digits)
            if i > 0:
                own = ensemble.Beside(noise[name], felt, digits)
            work.append(([m], 0, n, own, lost))
            keys.append((name, i))
            if 0 < i < len(chain) - 1:
                passing.add((name, i))
            levels.append(ensemble.behind_mean(m, r.mean, n, fs, temperature, own.shared))
            if i == 0 and r.steps:
                work.append(([m], cut, n, own, lost))
                keys.append((name, "held before"))
                levels.append(levels[-1])
        if r.steps:
            if r.refit:
                work.append((r.refit, cut, n, ensemble.Beside(noise[name], felt, digits), lost))
                keys.append((name, "held after"))
                levels.append(
                    ensemble.behind_mean(r.refit[0], r.mean, n, fs, temperature, noise[name])
                )
    seeds = [[seed, 7919, i] for i in range(simulations)]
    share = max(1, simulations // (2 * jobs))
    rows, tasks = {k: [] for k in keys}, []
    for i in range(0, simulations, share):
        # a quarter of an ensemble for the models on the way to the last: they are shown, and
        # nothing hangs on them
        these = [k for k, key in enumerate(keys) if key not in passing or i < simulations / 4]
        tasks.append(
            (
                these,
                [work[k] for k in these],
                n,
                fs,
                seeds[i : i + share],
                temperature,
                [levels[k] for k in these],
                filtered,
            )
        )
    for i, (these, made) in enumerate(_each(_ensemble, tasks, jobs)):
        for k, batteries in zip(these, made):
            rows[keys[k]] += batteries
        tick(i + 1)
    return {
        name: _gauged(report, name, ensemble.filled(raw[name]), fs, temperature, keys, rows, cut)
        for name, report in reports.items()
    }


def _gauged(report, name, x, fs, temperature, keys, rows, cut):
    """The report of a channel with its gap indices, of samples `x` against the `rows` of
    simulations.
    """
    whole, r = battery(x, fs, temperature), report.result
    places = [k for k in keys if k[0] == name and not isinstance(k[1], str)]
    chain = [ensemble.index(whole, rows[k]) for k in places]
    after, unexplained, steps, held_out = chain[-1], r.unexplained, r.steps, None
    if unexplained is None and after.value > MAX_GAP_INDEX:
        domain = max(after.domains, key=after.domains.get)
        unexplained = (
            f"simulations of the grown model: gap index {after.value:.2f}, most in the domain "
            f"{domain} ({after.domains[domain]:.2f})"
        )
    if steps:
        values = [c.value for c in chain][-len(steps) - 1 :]
        steps = [
            replace(s, gap_before=a, gap_after=b) for s, a, b in zip(steps, values[:-1], values[1:])
        ]
    if (name, "held after") in rows:
        part = battery(x[cut:], fs, None if temperature is None else temperature[cut:])
        held_out = {
            when: round(ensemble.index(part, rows[(name, f"held {when}")]).value, 4)
            for when in ("before", "after")
        }
    batteries = {"measured": whole, "before": rows[(name, 0)], "after": rows[places[-1]]}
    return replace(
        report,
        result=replace(r, steps=steps, unexplained=unexplained),
        before=chain[0],
        after=after,
        held_out=held_out,
        batteries=batteries,
    )
