"""GPS outages: GNSS is withheld over windows, and the horizontal error of each model is followed
until it comes back.

Each outage stands alone: the filter has GNSS up to its start, then runs on without. That is what
withholding one window in a run of its own gives, for hundreds of windows at the price of one run
and their seconds.
"""

from dataclasses import replace

import numpy as np
from scipy import stats

from imu_lib.drive import Drive
from imu_lib.errors import InputError

from . import earth, reference
from .filter import LooselyCoupled
from .outage_study import ModelOutages, OutageStudy
from .preparation import Gnss
from .side_by_side import each
from .states import sensor_states
from .windows import Window, broken, measure, regular_windows, speeds, windows_from

__all__ = [
    "ModelOutages",
    "OutageStudy",
    "Window",
    "broken",
    "compare",
    "measure",
    "regular_windows",
    "speeds",
    "windows_from",
]


def compare(
    drive: Drive,
    models,
    windows,
    *,
    gnss: Gnss | None = None,
    heading=None,
    strict=True,
    progress=None,
    notes=(),
    **options,
) -> OutageStudy:
    """Compare error models over outages of one drive.

    Parameters
    ----------
    drive : Drive
    models : mapping of name to FilterModel or Model
    windows : sequence of Window, or of (start s, duration s)
    gnss, heading, options : passed to `LooselyCoupled`
    strict : refuse a window that a model cannot start; False leaves it out for all models, and
    says so
    progress : wraps the names of the models to show how far it is, as tqdm does; notes : said
    before the study's own

    Raises
    ------
    InputError
        If a window lies outside the drive, or no GNSS or whole IMU data are there to start it.
    """
    windows = measured(drive, windows)
    moments = sorted({w.start for w in windows})

    def solved(name):
        engine = LooselyCoupled(drive, models[name], gnss=gnss, heading=heading, **options)
        return engine, engine.solve(moments=moments)

    both = [solved(n) for n in progress(models)] if progress else each(solved, models)
    engines, solutions = ({n: b[k] for n, b in zip(models, both)} for k in (0, 1))
    notes = list(notes)
    for name in models:
        about = [
            f"{name}: {n}" if "innovation" in n or "widened" in n else n
            for n in solutions[name].notes
        ]
        notes += [n for n in about if n not in notes]
    ready = [w for w in windows if all(_moment(solutions[n], w, engines[n]) for n in models)]
    notes += _not_ready(windows, ready, strict)
    trust = reference.look(drive)
    coasted = each(lambda n: _coasted(drive, engines[n], solutions[n], ready, trust), models)
    done = dict(zip(models, coasted))
    study = OutageStudy(tuple(ready), done, tuple(notes))
    return replace(study, notes=(*study.notes, *_warnings(study, trust)))


def measured(drive, windows):
    """The windows, measured; InputError where one cannot be asked of the drive."""
    windows = tuple(
        w if isinstance(w, Window) else Window(float(w[0]), float(w[1])) for w in windows
    )
    windows = tuple(w if np.isfinite(w.mean_speed) else measure(drive, w) for w in windows)
    if not windows:
        raise InputError("no outage window is given")
    for w in windows:
        if w.start + w.duration > drive.time[-1] + 1e-6:
            raise InputError(
                f"the outage from {w.start:g} s for {w.duration:g} s ends after the drive, which "
                f"lasts {drive.time[-1]:.1f} s; choose an earlier one"
            )
        if broken(drive, w):
            raise InputError(
                f"the outage from {w.start:g} s for {w.duration:g} s has a hole in the IMU data, "
                "or no fix before it; choose another"
            )
    return windows


def _not_ready(windows, ready, strict):
    """What is said, in a list, of windows that begin before a filter has started; InputError where
    none is left, or where each is wanted.
    """
    if len(ready) == len(windows):
        return []
    first = next(w for w in windows if w not in ready)
    if strict or not ready:
        raise InputError(
            f"the filter has not started at {first.start:g} s, where an outage begins; choose a "
            "later one"
        )
    return [
        f"{len(windows) - len(ready)} windows left out: the filter had not started, the first at "
        f"{first.start:g} s."
    ]


def _warnings(study, trust):
    """What a reader of the errors must know: a reference that is not one, models that are lost,
    covariances that are not believable.
    """
    notes = list(trust.notes) if trust is not None else []
    against = study.scored_against
    if "reference" in study.against:
        bad = ~np.isfinite(study.errors(next(iter(study.models)), against="reference"))
        if bad.any():
            notes.append(
                f"{int(bad.sum())} of {bad.size} outages are not scored against the reference, "
                "which is not fit there"
                + (
                    "."
                    if against == "reference"
                    else ": errors are against the full-GNSS solution."
                )
            )
    for name, model in study.models.items():
        if model.lost:
            part, share = max(model.rejected.items(), key=lambda x: x[1])
            notes.append(
                f"{name} rejects {100 * share:.0f} % of the {part} fixes: it has lost the drive "
                "and is not ranked."
            )
            continue
        ratio, n = model.over_predicted(against), 2 * len(study.windows)
        low, high = (
            stats.chi2.ppf([0.005, 0.995], n) / n
        )  # what an honest filter's few windows give
        if not 0.5 <= ratio <= 2.0 and not low <= ratio**2 <= high:
            notes.append(
                f"{name}: errors are {ratio:.2g} times what the filter predicts; its sigma is not "
                "to be believed."
            )
    if not study.ranked:
        notes.append(
            "No model follows the fixes, so none is ahead: look at their time and units, or give "
            "the heading at the start where it is known (--heading)."
        )
    return notes


def _moment(solution, window, engine):
    return next(
        (
            (m, i)
            for m in solution.moments
            for i in np.flatnonzero(np.abs(m.time - window.start) < 1.5 / engine.prepared.rate)
        ),
        None,
    )


def _coasted(drive, engine, solution, windows, trust):
    times, sigmas, paths, errors = [], [], [], {"full_gnss": []}
    if drive.has_reference:
        errors["reference"] = []
    for w in windows:
        time, position, sd, _ = engine.coast(*_moment(solution, w, engine), w.duration)
        times.append(time - w.start)
        paths.append(position)
        sigmas.append(np.hypot(sd[:, 0], sd[:, 1]))
        errors["full_gnss"].append(earth.horizontal(position, solution.at(time)))
        if drive.has_reference:
            truth = np.column_stack(
                [
                    np.interp(time, drive.reference_time, c)
                    for c in np.asarray(drive.reference_position).T
                ]
            )
            fit = trust.good(w.start, w.start + w.duration)
            errors["reference"].append(earth.horizontal(position, truth) if fit else time * np.nan)
    return ModelOutages(
        engine.states,
        tuple(times),
        {a: tuple(e) for a, e in errors.items()},
        tuple(sigmas),
        tuple(paths),
        solution,
        _added(engine),
    )


def _added(engine):
    """Names of the states that the processes of the error model do not ask for: biases left at
    switch-on that none of them keeps, parameters of the drive, correlated errors of the fixes.
    """
    model = engine.model
    asked = sensor_states(
        engine.held.model(model.model), engine.prepared.rate, flicker=model.flicker
    )
    left, added = list(asked.names), []
    for name in engine.sensors.names:
        if name in left:
            left.remove(name)
        else:
            added.append(name)
    return tuple(added)
