"""The windows of an outage comparison: given, or one after the other along a drive."""

from dataclasses import dataclass

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError

from . import earth

BEFORE = 5.0  # s before an outage in which a fix must lie
COVERED = 0.5  # of the drive's time: fixes over less are not the whole solution


@dataclass(frozen=True)
class Window:
    """An outage: start and duration, s; mean_speed, m/s; turn, rad (how far the heading ranges
    within it).
    """

    start: float
    duration: float
    mean_speed: float = float("nan")
    turn: float = float("nan")


def windows_from(text):
    """Windows from "START:DURATION,START:DURATION" (s). InputError where it cannot be read."""
    windows = []
    for part in str(text).split(","):
        pieces = part.split(":")
        try:
            start, duration = (float(p) for p in pieces)
        except ValueError:
            raise InputError(
                f"--windows: {part.strip()!r} is not START:DURATION in seconds (as in "
                "180:30,420:60)"
            ) from None
        if not (np.isfinite(start) and np.isfinite(duration) and duration > 0.0 and start >= 0.0):
            raise InputError(
                f"--windows: {part.strip()!r} must start at 0 s or later and last longer than 0 s"
            )
        windows.append(Window(start, duration))
    return tuple(windows)


def overlapping(drive: Drive):
    """InputError where no fix lies within the time of the IMU."""
    first, last = drive.time[0], drive.time[-1]
    fixes = np.asarray(drive.gnss_time)
    if np.any((fixes >= first) & (fixes <= last)):
        return
    apart = max(fixes[0] - last, first - fixes[-1])
    raise InputError(
        f"{drive.called}: the fixes ({fixes[0]:.6g} to "
        f"{fixes[-1]:.6g} s) and the IMU ({first:.6g} to {last:.6g} s) "
        f"do not overlap: they lie {apart:.4g} s apart; bring both to one clock: --gnss-offset S, "
        "the IMU's time of the first fix, in s from its first sample."
    )


def uncovered(drive: Drive) -> str:
    """A sentence where the fixes cover less than half of the drive; "" where they cover more."""
    first, last = float(drive.time[0]), float(drive.time[-1])
    fixes = np.asarray(drive.gnss_time)[np.isfinite(drive.gnss_position).all(axis=1)]
    fixes = fixes[(fixes >= first) & (fixes <= last)]
    if fixes.size and np.ptp(fixes) >= COVERED * (last - first):
        return ""
    when = f", from {fixes[0]:.4g} to {fixes[-1]:.4g} s," if fixes.size else ""
    return (
        f"{fixes.size} fixes{when} cover {np.ptp(fixes) if fixes.size else 0.0:.3g} s of the "
        f"{last - first:.4g} s of the drive: give the whole GNSS solution, or cut the drive to "
        "the time that it covers."
    )


def _covered(drive, duration):
    """InputError where no window fits because the fixes cover too little of the drive."""
    if lacking := uncovered(drive):
        raise InputError(f"no window of {duration:g} s fits: {lacking}")


def regular_windows(drive: Drive, *, duration=30.0, every=30.0, settle=120.0, moving=1.0):
    """Windows of `duration` s, one each `every` s, from `settle` s after the first motion on;
    those slower than `moving` m/s on the mean are left out.
    """
    if duration <= 0.0 or every <= 0.0:
        raise ValueError("`duration` and `every` must be above zero")
    overlapping(drive)
    speed_time, speed = speeds(drive)
    moved = np.flatnonzero(speed > 3.0)
    if not moved.size:
        _covered(drive, duration)
        raise InputError(
            f"{drive.name or 'the drive'} never moves faster than 3 m/s: there is nothing to "
            "compare in an outage"
        )
    first, last = np.ceil(speed_time[moved[0]] + settle), min(drive.time[-1], drive.gnss_time[-1])
    starts = np.arange(first, last - duration, every)
    if not starts.size:
        _covered(drive, duration)
        raise InputError(
            f"{drive.called}: no window of {duration:g} s fits: the first would begin at "
            f"{first:.4g} s, "
            f"{settle:g} s after the first motion, and the fixes and the IMU end at {last:.4g} s; "
            "name outages of your own (--windows START:DURATION,...), or give a longer drive"
        )
    starts = _from_fixes(drive, starts, duration)
    windows = [measure(drive, Window(float(s), float(duration))) for s in starts]
    kept = tuple(w for w in windows if not w.mean_speed < moving and not broken(drive, w))
    if windows and not kept and all(broken(drive, w) for w in windows):
        raise InputError(
            f"no window of {duration:g} s fits: none has whole IMU data and a fix in the "
            f"{BEFORE:g} s before it; give a shorter --duration"
        )
    if not kept:
        raise InputError(
            f"no window of {duration:g} s fits: the drive must go on moving from {settle:g} s "
            "after its first motion on"
        )
    return kept


def _from_fixes(drive, starts, duration):
    """The starts, those without a fix in the seconds before them at the last fix, if that is after
    the window before: fixes may come in bursts.
    """
    fixes, out = np.asarray(drive.gnss_time), []
    for start in starts:
        k = int(np.searchsorted(fixes, start, "right")) - 1
        last = float(fixes[k]) if k >= 0 else start
        if start - last > BEFORE and (not out or last >= out[-1] + duration):
            start = last
        out.append(start)
    return np.array(out)


def broken(drive: Drive, window):
    """Whether the IMU data or the fixes around the window have a hole of more than a second."""
    end = window.start + window.duration
    inside = drive.time[(drive.time >= window.start - 5.0) & (drive.time <= end + 0.5)]
    before = drive.gnss_time[
        (drive.gnss_time >= window.start - BEFORE) & (drive.gnss_time <= window.start)
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
