"""Monte-Carlo over the same processes, or the same cluster, as a fleet's records: fleets drawn from
a model, coverage of intervals, drives.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from imu_lib import scheduler
from imu_lib.fleet.manifest import Entry
from imu_lib.fleet.summary import draw
from imu_lib.model import Model
from imu_lib.writers import write_record


def monte_carlo(task, runs, *arguments, seed=0, workers=None, address=None, progress=None) -> list:
    """`task(generator, *arguments)` for `runs` independent generators, results in their order.

    Parameters
    ----------
    task : callable
        Of a module; its first argument is a `numpy.random.Generator` that depends on `seed` and the
        run's number alone, so that the results are the same however many workers there are.
    runs : int
    workers, address
        As for `scheduler.run`.
    progress : callable, optional
        Called with each run's number as it ends.
    """
    seeds = np.random.SeedSequence(seed).spawn(runs)
    tasks = [(task, one, arguments) for one in seeds]
    return scheduler.every(_seeded, tasks, workers=workers, address=address, progress=progress)


def _seeded(task, seed, arguments):
    return task(np.random.default_rng(seed), *arguments)


def simulate(
    model: Model, folder, *, sensors, dates, hours, rate, seed, day=0.0, growth=0.0
) -> list[Entry]:
    """Records of a fleet drawn from a fleet model, one file a sensor and date.

    Parameters
    ----------
    model : Model
        With the key `spread`, as `summary` makes it.
    folder : path
    sensors : int
    dates : sequence of str
        YYYY-MM-DD.
    hours, rate : float
        Of a record, Hz.
    seed : int
    day : float
        Scatter of the coefficients' logarithm from date to date.
    growth : float
        Change of the coefficients' logarithm a year.

    Returns
    -------
    list of Entry
    """
    out = []
    first = np.datetime64(dates[0])
    for number in range(sensors):
        rng = np.random.default_rng([seed, number])
        unit = draw(model, rng)
        name = f"unit{number:03d}"
        for date in dates:
            years = (np.datetime64(date) - first).astype(float) / 365.25
            today = _scaled(unit, np.exp(growth * years + day * rng.standard_normal()))
            record = today.simulate_record(round(hours * 3600 * rate), rate, rng)
            path = Path(folder) / f"{name}_{date}.npz"
            write_record(record, path)
            out.append(Entry(path.name, str(path), name, date, ()))
    return out


def _scaled(model, factor):
    """Every amplitude of the noises times a factor."""
    channels = {}
    for channel, entry in model.channels.items():
        values = {}
        for label, index, name in entry.labels():
            process = list(entry)[index]
            kind = next(p.kind for p in process.parameters if p.name == name)
            if kind == "amplitude" and not process.deterministic:
                values[label] = getattr(process, name) * factor
        channels[channel] = entry.with_values(values)
    return model.with_channels(channels)


def coverage(model: Model, *, runs, hours, rate, **options) -> pd.DataFrame:
    """How often the intervals of `characterise` hold the coefficients of the model that the records
    were drawn from, with Clopper and Pearson's 95 % interval; `options` as for `monte_carlo`.

    Returns
    -------
    DataFrame
        channel, coefficient (of the likelihood), runs that show it, held, share, low, high.
    """
    found = monte_carlo(_held, runs, model, hours, rate, **options)
    rows = pd.DataFrame([row for run in found for row in run])
    out = []
    for (channel, coefficient), own in rows.groupby(["channel", "coefficient"], sort=False):
        held, count = int(own.held.sum()), len(own)
        interval = stats.binomtest(held, count).proportion_ci(0.95)
        out.append((channel, coefficient, count, held, held / count, interval.low, interval.high))
    names = ["channel", "coefficient", "runs", "held", "share", "low", "high"]
    return pd.DataFrame(out, columns=names)


def _held(rng, model, hours, rate):
    from imu_lib.characterise import characterise

    record = model.simulate_record(round(hours * 3600 * rate), rate, rng)
    result = characterise(record, workers=1)
    rows = []
    for channel, found in result.channels.items():
        truth = {
            label: getattr(list(model[channel])[index], name)
            for label, index, name in model[channel].labels()
        }
        for label, estimate in found.likelihood.items():
            if label in truth and estimate.shown:
                rows.append(
                    {
                        "channel": channel,
                        "coefficient": label,
                        "held": estimate.covers(truth[label]),
                    }
                )
    return rows


def drives(path, model: Model, filters, windows, *, runs, **options) -> pd.DataFrame:
    """Outages of `runs` drives along one path, each with a unit of the fleet (or with the model as
    it is, where it has no spread), under several filter models.

    Parameters
    ----------
    path : imu_lib.navigation.trajectory.Trajectory
    model : Model
    filters : mapping of name to Model or FilterModel
    windows : sequence of (start s, duration s)
    options
        As for `monte_carlo`.

    Returns
    -------
    DataFrame
        run, filter, window, error: the largest horizontal error against the truth, m.
    """
    found = monte_carlo(_driven, runs, path, model, dict(filters), tuple(windows), **options)
    return pd.DataFrame(
        [
            (run, name, window, float(error))
            for run, errors in enumerate(found)
            for name, of_windows in errors.items()
            for window, error in enumerate(of_windows)
        ],
        columns=["run", "filter", "window", "error"],
    )


def _driven(rng, path, model, filters, windows):
    from imu_lib.navigation import outages, simulation

    unit = draw(model, rng) if "spread" in model.extra else model
    drive = simulation.simulate_drive(path, unit, rng)
    study = outages.compare(drive, filters, windows, strict=False)
    return {name: study.errors(name, against="reference") for name in study.ranked}
