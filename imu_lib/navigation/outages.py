"""GPS outages: GNSS is withheld over windows, and the horizontal error of each model is followed
until it comes back.

Each outage stands alone: the filter has GNSS up to its start, then runs on without. That is what
withholding one window in
a run of its own gives, for hundreds of windows at the price of one run and their seconds.
"""

from dataclasses import dataclass, replace

import numpy as np
from tqdm import tqdm

from imu_lib.drive import Drive
from imu_lib.errors import InputError

from . import earth, measurement, reference
from .filter import LooselyCoupled, Solution
from .free import GROUPS
from .preparation import Gnss
from .statistics import improvement, paired
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
#: A model that rejects a larger share of the fixes than this is lost: it is not ranked.
LOST = 0.2

AGAINST = ("full_gnss", "reference")


@dataclass(frozen=True)
class ModelOutages:
    """One model over all windows.

    states : number of filter states; time (w,) of (k,) s since the window's start; error :
    {"full_gnss": (w,) of (k,), "reference": ...}, m;
    sigma : (w,) of (k,), m, the filter's own horizontal standard deviation (root of the sum of the
    two variances);
    path (w,) of (k, 3), positions; solution : the full-GNSS run
    """

    states: int
    time: tuple
    error: dict
    sigma: tuple
    path: tuple
    solution: Solution

    def max(self, against="full_gnss"):
        """Maximum horizontal error of each window, (w,), m; NaN where the reference is not fit."""
        return np.array([e.max() for e in self.error[against]])

    @property
    def nis(self):
        """Mean normalised innovation squared of the fixes used, per degree of freedom: 1 where the
        filter is honest.
        """
        i = self.solution.innovations
        return float(i.nis.sum() / max(i.freedom.sum(), 1))

    @property
    def rejected(self):
        """Share of the positions and of the velocities that failed the innovation test."""
        i, out = self.solution.innovations, {}
        for k, part in enumerate(("position", "velocity")):
            offered = np.isfinite(i.value[:, 3 * k]).sum()
            failed = (i.bits & (measurement.REJECTED_POSITION << k)) > 0
            out[part] = float(failed.sum() / offered) if offered else 0.0
        return out

    @property
    def lost(self):
        """Whether it rejects so many fixes that its errors say nothing of its error model."""
        return max(self.rejected.values()) > LOST

    def over_predicted(self, against="full_gnss"):
        """Root mean square of the errors at the windows' ends over the predicted sigma: 1 where the
        filter is honest.
        """
        ratio = np.array([e[-1] / s[-1] for e, s in zip(self.error[against], self.sigma)])
        ratio = ratio[np.isfinite(ratio)]
        return float(np.sqrt(np.mean(ratio**2))) if ratio.size else float("nan")

    def mean(self, against="full_gnss"):
        """Mean horizontal error of each window, (w,), m."""
        return np.array([e.mean() for e in self.error[against]])


@dataclass(frozen=True)
class OutageStudy:
    """The comparison: windows, models by name (ModelOutages), notes."""

    windows: tuple
    models: dict
    notes: tuple = ()

    @property
    def against(self):
        """What errors are taken against: "full_gnss", and "reference" where the drive has one."""
        return tuple(next(iter(self.models.values())).error)

    def errors(self, name, *, what="max", against="full_gnss"):
        """Maximum or mean error of a model in each window, (w,), m."""
        return getattr(self.models[name], what)(against)

    def improvement(self, better, worse, *, how, what="max", against="full_gnss"):
        """See `statistics.improvement`, per cent."""
        return improvement(
            self.errors(better, what=what, against=against),
            self.errors(worse, what=what, against=against),
            how=how,
        )

    @property
    def ranked(self):
        """Names of the models that follow the fixes."""
        return tuple(n for n, m in self.models.items() if not m.lost)

    def paired(self, *, what="max", against="full_gnss"):
        """All pairs of models that follow the fixes, the best (smallest mean log error) first, on
        the windows that can be scored.
        """
        errors = {n: self.errors(n, what=what, against=against) for n in self.ranked}
        good = np.isfinite(list(errors.values())).all(axis=0) if errors else np.zeros(0, bool)
        if good.sum() < 2:
            return ()
        errors = {n: e[good] for n, e in errors.items()}
        order = sorted(errors, key=lambda n: np.log(np.maximum(errors[n], 1e-3)).mean())
        return tuple(
            paired(errors[a], errors[b], (a, b))
            for i, a in enumerate(order)
            for b in order[i + 1 :]
        )

    @property
    def scored_against(self):
        """ "reference" where at least half of the windows can be scored against it, else
        "full_gnss".
        """
        if "reference" not in self.against:
            return "full_gnss"
        errors = self.errors(next(iter(self.models)), against="reference")
        return "reference" if np.isfinite(errors).mean() >= 0.5 else "full_gnss"

    def to_json(self):
        """The content of `imu-lib outages --json`: errors horizontal, m."""
        against = self.scored_against
        return {
            "windows": [
                {"start": w.start, "duration": w.duration, "mean_speed": w.mean_speed}
                for w in self.windows
            ],
            "models": {name: self._of(name, against) for name in self.models},
            "paired": [p.to_json() for p in self.paired(against=against)],
            "paired_against": against,
            "notes": list(self.notes),
        }

    def estimates(self, name):
        """What a model estimated of the drive: name of the state -> value and sd at the end."""
        return {
            state: {"value": value, "sd": sd}
            for state, (value, sd) in self.models[name].solution.estimates().items()
            if state.split(" ")[0] in GROUPS
        }

    def _of(self, name, against):
        model = self.models[name]
        return {
            "states": model.states,
            "against": {
                a: {"max": model.max(a).tolist(), "mean": model.mean(a).tolist()}
                for a in model.error
            },
            "predicted_sigma": [float(s[-1]) for s in model.sigma],
            "error_over_predicted": model.over_predicted(against),
            "nis": model.nis,
            "rejected": model.rejected,
            "ranked": not model.lost,
            "estimates": self.estimates(name),
        }


def compare(
    drive: Drive,
    models,
    windows,
    *,
    gnss: Gnss | None = None,
    heading=None,
    strict=True,
    progress=False,
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
    progress : show a bar on standard error; notes : said before the study's own

    Raises
    ------
    InputError
        If a window lies outside the drive, or no GNSS or whole IMU data are there to start it.
    """
    windows = tuple(
        w if isinstance(w, Window) else Window(float(w[0]), float(w[1])) for w in windows
    )
    windows = tuple(w if np.isfinite(w.mean_speed) else measure(drive, w) for w in windows)
    if not windows:
        raise InputError("no outage window is given")
    for w in windows:
        if w.start + w.duration > drive.time[-1] + 1e-6:
            raise InputError(
                f"the outage from {w.start:g} s for {w.duration:g} s ends after the drive, which lasts {drive.time[-1]:.1f} s"
            )
        if broken(drive, w):
            raise InputError(
                f"the outage from {w.start:g} s for {w.duration:g} s has a hole in the IMU data, or no fix before it; choose another"
            )
    engines, solutions, notes = {}, {}, list(notes)
    bar = tqdm(models.items(), desc="models", disable=not progress, leave=False)
    for name, model in bar:
        bar.set_postfix_str(name)
        engines[name] = LooselyCoupled(drive, model, gnss=gnss, heading=heading, **options)
        solutions[name] = engines[name].solve(moments=sorted({w.start for w in windows}))
        about = [
            f"{name}: {n}" if "innovation" in n or "widened" in n else n
            for n in solutions[name].notes
        ]
        notes += [n for n in about if n not in notes]
    ready = [w for w in windows if all(_moment(solutions[n], w, engines[n]) for n in models)]
    if len(ready) < len(windows):
        first = next(w for w in windows if w not in ready)
        if strict or not ready:
            raise InputError(
                f"the filter has not started at {first.start:g} s, where an outage begins; choose a later one"
            )
        notes.append(
            f"{len(windows) - len(ready)} windows left out: the filter had not started, the first at {first.start:g} s."
        )
    trust = reference.look(drive)
    done = {n: _coasted(drive, engines[n], solutions[n], ready, trust) for n in models}
    study = OutageStudy(tuple(ready), done, tuple(notes))
    return replace(study, notes=(*study.notes, *_warnings(study, trust)))


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
                f"{int(bad.sum())} of {bad.size} outages are not scored against the reference, which is not fit there"
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
                f"{name} rejects {100 * share:.0f} % of the {part} fixes: it has lost the drive and is not ranked."
            )
            continue
        ratio = model.over_predicted(against)
        if ratio > 2.0 or ratio < 0.5:
            notes.append(
                f"{name}: errors are {ratio:.2g} times what the filter predicts; its sigma is not to be believed."
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
    )
