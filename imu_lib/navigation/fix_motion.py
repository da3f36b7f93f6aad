"""What the fixes alone say of the motion, beside what was felt.

A vehicle that keeps its nose along its path feels (dv/dt, v dc/dt, -g) and turns at (0, 0, dc/dt)
with speed v and course c. Both follow from the fixes, smoothed, and are held against the readings:
for the order of the axes (`axes`) and the time of the fixes (`lateness`).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from imu_lib.drive import Drive

from . import earth

STEP = 0.2  # s of the common grid
WIDTH = 2.0  # s of smoothing


@dataclass(frozen=True)
class Motion:
    """On a grid: time, expected force and rate (n, 3), smoothed readings (n, 6), moving (n,)."""

    time: np.ndarray
    expected: np.ndarray
    readings: np.ndarray
    moving: np.ndarray


def motion(drive: Drive) -> Motion | None:
    """What the fixes say of the motion, beside the readings; None where there is too little."""
    position = np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1)
    if good.sum() < 30:
        return None
    fix_time = np.asarray(drive.gnss_time)[good]
    if np.median(np.diff(fix_time)) > WIDTH:  # between fixes further apart nobody knows the turns
        return None
    low, high = max(drive.time[0], fix_time[0]), min(drive.time[-1], fix_time[-1])
    grid = np.arange(low + WIDTH, high - WIDTH, STEP)
    if grid.size < 100:
        return None
    width = int(WIDTH / STEP)
    velocity = None
    if drive.gnss_velocity is not None:
        v = np.asarray(drive.gnss_velocity, float)
        fine = np.isfinite(v).all(axis=1) & ~contradicted(drive)
        if fine.sum() > 0.5 * good.sum():
            t = np.asarray(drive.gnss_time)[fine]
            velocity = np.column_stack([np.interp(grid, t, c) for c in v[fine].T])
            velocity = uniform_filter1d(velocity, width + 1, axis=0)
    if velocity is None:
        ned = earth.meters(position[good], position[good][0])
        ned = np.column_stack([np.interp(grid, fix_time, c) for c in ned.T])
        ned = uniform_filter1d(ned, width + 1, axis=0)
        velocity = np.gradient(ned, STEP, axis=0)
        velocity = uniform_filter1d(velocity, width + 1, axis=0)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    acceleration = np.gradient(velocity, STEP, axis=0)
    course = np.arctan2(velocity[:, 1], velocity[:, 0])
    ahead = acceleration[:, 0] * np.cos(course) + acceleration[:, 1] * np.sin(course)
    aside = -acceleration[:, 0] * np.sin(course) + acceleration[:, 1] * np.cos(course)
    moving = uniform_filter1d((speed > 3.0).astype(float), width + 1) > 0.99
    turn = np.where(moving, aside / np.maximum(speed, 1.0), 0.0)
    g = earth.gravity(position[good][0, 0], position[good][0, 2])
    zero = np.zeros_like(speed)
    expected = np.column_stack([zero, zero, turn, ahead, aside, zero - g])
    window = max(int(WIDTH * drive.rate), 1)
    both = np.column_stack([drive.gyro, drive.accel])
    smooth = uniform_filter1d(both, window, axis=0)
    readings = np.column_stack([np.interp(grid, drive.time, c) for c in smooth.T])
    hole = np.interp(grid, drive.time[:-1], np.diff(drive.time)) < 0.5
    return Motion(grid, expected, readings, moving & hole)


def changes(felt: np.ndarray) -> bool:
    """Whether a sensor has felt anything; one that is not connected is like nothing."""
    return bool(np.std(felt) > 1e-9 * np.abs(felt).max())


def contradicted(drive: Drive):
    """Which velocities (m,) are not those at which the positions move: another solution's, or with
    axes that change from fix to fix.
    """
    time, v = np.asarray(drive.gnss_time), np.asarray(drive.gnss_velocity, float)
    position = np.asarray(drive.gnss_position, float)
    out = np.zeros(time.size, bool)
    before = np.searchsorted(time, time - 0.5 * WIDTH)
    after = np.minimum(np.searchsorted(time, time + 0.5 * WIDTH), time.size - 1)
    span = time[after] - time[before]
    known = np.isfinite(position[before] + position[after]).all(axis=1)
    k = np.flatnonzero(known & (span > 0.5 * WIDTH) & (span < 2.0 * WIDTH))
    moved = earth.meters(position[after[k]], position[before[k]])[:, :2] / span[k, None]
    apart = np.linalg.norm(moved - v[k, :2], axis=1)
    usual = np.nanmedian(apart) if k.size else 0.0  # noise of the positions, late stamps
    out[k] = apart > max(4.0, 4.0 * min(usual, 2.0)) + 0.2 * np.linalg.norm(moved, axis=1)
    return out
