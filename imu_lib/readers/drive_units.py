"""Are a drive's units possible? What the gyros turn about the vertical is held against how the
course of the fixes turns: that holds at any rate and on any road, where noise in a moving car tells
nothing.
"""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.readers.possible import check_units
from imu_lib.units import DEG

EARTH = 6_378_137.0  # m; a sphere will do
SPAN = 2.0  # s over which turns are taken
SLOWEST = 2.0  # m/s: below this a course is no direction
LEAST_TURN = 0.02  # rad/s, root mean square while moving
ALIKE = 2.5  # factor within which two turn rates are the same


def turn_ratio(drive: Drive) -> float | None:
    """Turn rate of the course over that of the gyros about the vertical, root mean squares while
    the drive moves; None where it does not turn enough to tell.
    """
    time, velocity = _velocity(drive)
    if time.size < 20:
        return None
    grid = np.arange(max(time[0], drive.time[0]), min(time[-1], drive.time[-1]), 0.5 * SPAN)
    if grid.size < 20:
        return None
    east, north = (np.interp(grid, time, velocity[:, k]) for k in (1, 0))
    course = np.unwrap(np.arctan2(east, north))
    down = -np.median(drive.accel, axis=0)
    felt = np.asarray(drive.gyro) @ (down / max(np.linalg.norm(down), 1e-12))
    angle = np.interp(grid, drive.time[1:], np.cumsum(felt[1:] * np.diff(drive.time)))
    shown, turned = (course[2:] - course[:-2]) / SPAN, (angle[2:] - angle[:-2]) / SPAN
    fast = np.hypot(east, north) > SLOWEST
    good = fast[2:] & fast[1:-1] & fast[:-2] & (np.abs(shown) < 1.0)
    if good.sum() < 20:
        return None
    shown, turned = shown[good], turned[good] - np.median(turned[good])
    size, own = np.sqrt(np.mean(shown**2)), np.sqrt(np.mean(turned**2))
    return float(size / own) if size > LEAST_TURN and own > 0.0 else None


def _velocity(drive):
    """Times (k,) and horizontal velocities (k, 2) of the fixes, m/s, over a second or more."""
    time, velocity = drive.gnss_time, drive.gnss_velocity
    if velocity is not None:
        good = np.isfinite(velocity).all(axis=1)
        if good.sum() > 20:
            return time[good], velocity[good, :2]
    step = max(int(np.ceil(1.0 / np.median(np.diff(time)))), 1)
    position = drive.gnss_position
    north = EARTH * position[:, 0]
    east = EARTH * np.cos(position[:, 0]) * np.unwrap(position[:, 1])
    moved = np.column_stack([x[step:] - x[:-step] for x in (north, east)])
    gap = time[step:] - time[:-step]
    good = np.isfinite(moved).all(axis=1) & (gap < 5.0 * SPAN)
    return 0.5 * (time[step:] + time[:-step])[good], (moved / gap[:, None])[good]


def check(drive: Drive, gyro_unit="rad/s", accel_unit="m/s^2", factor=(1.0, 1.0)) -> Drive:
    """The drive, with a note where a unit is unusual; InputError where a stated unit is impossible,
    with the likely one.
    """
    imu = drive.imu()
    ratio = turn_ratio(drive)
    units = {"gyro": gyro_unit, "accel": accel_unit}
    if ratio is not None:
        for other, scale in (("rad/s", 1.0), ("deg/s", DEG), ("deg/h", DEG / 3600.0)):
            if other != gyro_unit and _alike(ratio, scale / factor[0]):
                raise InputError(
                    f"{drive.source}: the course of the fixes turns {ratio:.3g} times as fast as "
                    f"the rates stated in {gyro_unit} say; correct --gyro-unit or the header: "
                    f"--gyro-unit {other}, or --trust-units if it is right."
                )
        if 1.0 / ALIKE < ratio < ALIKE:
            units.pop("gyro")
    checked = check_units(imu, units, dict(zip(("gyro", "accel"), factor)), strict=False)
    return drive.with_(notes=drive.notes + checked.notes[len(imu.notes) :])


def _alike(a, b):
    return 1.0 / ALIKE < a / b < ALIKE
