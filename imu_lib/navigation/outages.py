"""GPS outages: GNSS is withheld over windows, and the horizontal error of each model is followed
until it comes back.

Each outage stands alone: the filter has GNSS up to its start, then runs on without. That is what
withholding one window in
a run of its own gives, for hundreds of windows at the price of one run and their seconds.
"""

from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from imu_lib.drive import Drive
from imu_lib.errors import InputError

from . import earth
from .filter import LooselyCoupled, Solution
from .preparation import Gnss
from .statistics import improvement, paired

AGAINST = ("full_gnss", "reference")


@dataclass(frozen=True)
class Window:
    """An outage: start and duration, s; mean_speed, m/s; turn, rad (how far the heading ranges
    within it).
    """

    start: float
    duration: float
    mean_speed: float = float("nan")
    turn: float = float("nan")


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
        """Maximum horizontal error of each window, (w,), m."""
        return np.array([e.max() for e in self.error[against]])

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

    def paired(self, *, what="max", against="full_gnss"):
        """All pairs of models, the best (smallest mean log error) first."""
        order = sorted(
            self.models,
            key=lambda n: np.log(
                np.maximum(self.errors(n, what=what, against=against), 1e-3)
            ).mean(),
        )
        return tuple(
            paired(
                self.errors(a, what=what, against=against),
                self.errors(b, what=what, against=against),
                (a, b),
            )
            for i, a in enumerate(order)
            for b in order[i + 1 :]
        )

    def to_json(self):
        """The content of `imu-lib outages --json`: errors horizontal, m."""
        against = "reference" if "reference" in self.against else "full_gnss"
        return {
            "windows": [
                {"start": w.start, "duration": w.duration, "mean_speed": w.mean_speed}
                for w in self.windows
            ],
            "models": {
                name: {
                    "states": m.states,
                    "against": {
                        a: {"max": m.max(a).tolist(), "mean": m.mean(a).tolist()} for a in m.error
                    },
                    "predicted_sigma": [float(s[-1]) for s in m.sigma],
                }
                for name, m in self.models.items()
            },
            "paired": [p.to_json() for p in self.paired(against=against)]
            if len(self.windows) > 1
            else [],
            "paired_against": against,
            "notes": list(self.notes),
        }


def windows_from(text):
    """Windows from "START:DURATION,START:DURATION" (s). InputError where it cannot be read."""
    windows = []
    for part in str(text).split(","):
        pieces = part.split(":")
        try:
            start, duration = (float(p) for p in pieces)
        except ValueError:
            raise InputError(
                f"--windows: {part.strip()!r} is not START:DURATION in seconds (as in 180:30,420:60)"
            ) from None
        if not (np.isfinite(start) and np.isfinite(duration) and duration > 0.0 and start >= 0.0):
            raise InputError(
                f"--windows: {part.strip()!r} must start at 0 s or later and last longer than 0 s"
            )
        windows.append(Window(start, duration))
    return tuple(windows)


def regular_windows(drive: Drive, *, duration=30.0, every=30.0, settle=120.0, moving=1.0):
    """Windows of `duration` s, one each `every` s, from `settle` s after the first motion on;
    those slower than `moving` m/s on the mean are left out.
    """
    if duration <= 0.0 or every <= 0.0:
        raise ValueError("`duration` and `every` must be above zero")
    speed_time, speed = speeds(drive)
    moved = np.flatnonzero(speed > 3.0)
    if not moved.size:
        raise InputError(
            f"{drive.name or 'the drive'} never moves faster than 3 m/s: there is nothing to compare in an outage"
        )
    starts = np.arange(
        np.ceil(speed_time[moved[0]] + settle),
        min(drive.time[-1], drive.gnss_time[-1]) - duration,
        every,
    )
    windows = [measure(drive, Window(float(s), float(duration))) for s in starts]
    kept = tuple(w for w in windows if not w.mean_speed < moving and not broken(drive, w))
    if not kept:
        raise InputError(
            f"no window of {duration:g} s fits: the drive must last {settle:g} s after its first motion and go on moving"
        )
    return kept


def broken(drive: Drive, window):
    """Whether the IMU data or the fixes around the window have a hole of more than a second."""
    end = window.start + window.duration
    inside = drive.time[(drive.time >= window.start - 5.0) & (drive.time <= end + 0.5)]
    before = drive.gnss_time[
        (drive.gnss_time >= window.start - 5.0) & (drive.gnss_time <= window.start)
    ]
    return (
        inside.size < 2
        or np.diff(inside).max() > 1.0
        or inside[0] > window.start
        or inside[-1] < end - 0.1
        or before.size == 0
    )


def speeds(drive: Drive):
    """Horizontal speed over time, (k,) s and (k,) m/s, from the reference, the fixes' velocities,
    or their positions.
    """
    if drive.reference_velocity is not None:
        return drive.reference_time, np.hypot(
            drive.reference_velocity[:, 0], drive.reference_velocity[:, 1]
        )
    if drive.gnss_velocity is not None and np.isfinite(drive.gnss_velocity).any():
        good = np.isfinite(drive.gnss_velocity).all(axis=1)
        return drive.gnss_time[good], np.hypot(*drive.gnss_velocity[good, :2].T)
    good = np.isfinite(drive.gnss_position).all(axis=1)
    time, position = drive.gnss_time[good], drive.gnss_position[good]
    step = max(int(round(2.0 / np.median(np.diff(time)))), 1)
    return 0.5 * (time[step:] + time[:-step]), earth.horizontal(
        position[step:], position[:-step]
    ) / (time[step:] - time[:-step])


def measure(drive: Drive, window):
    """The window with its mean speed and, where the drive has a reference or velocities, how far
    the heading turns.
    """
    time, speed = speeds(drive)
    inside = (time >= window.start) & (time <= window.start + window.duration)
    if not inside.any():
        return window
    velocity = (
        drive.reference_velocity if drive.reference_velocity is not None else drive.gnss_velocity
    )
    turn = float("nan")
    if velocity is not None and len(velocity) == len(time):
        fast = inside & (speed > 2.0)
        turn = (
            float(np.ptp(np.unwrap(np.arctan2(velocity[fast, 1], velocity[fast, 0]))))
            if fast.sum() > 1
            else 0.0
        )
    return Window(window.start, window.duration, float(speed[inside].mean()), turn)


def compare(
    drive: Drive,
    models,
    windows,
    *,
    gnss: Gnss | None = None,
    heading=None,
    strict=True,
    progress=False,
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
    progress : show a bar on standard error

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
    engines, solutions, notes = {}, {}, []
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
    done = {n: _coasted(drive, engines[n], solutions[n], ready) for n in models}
    return OutageStudy(tuple(ready), done, tuple(notes))


def _moment(solution, window, engine):
    return next(
        (
            (m, i)
            for m in solution.moments
            for i in np.flatnonzero(np.abs(m.time - window.start) < 1.5 / engine.prepared.rate)
        ),
        None,
    )


def _coasted(drive, engine, solution, windows):
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
            errors["reference"].append(earth.horizontal(position, truth))
    return ModelOutages(
        engine.states,
        tuple(times),
        {a: tuple(e) for a, e in errors.items()},
        tuple(sigmas),
        tuple(paths),
        solution,
    )
