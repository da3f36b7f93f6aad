"""When the course of the fixes turns as the gyros do, whatever the axes of the sensor."""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive

from . import earth

STEP = 0.1  # s, of the comparison
FARTHEST = 90.0  # s
USUAL = 15.0  # s: a match further away has to be better
FAR = 3.0  # s beyond which nothing else can be told of a drive before it is put right


def late(drive: Drive) -> float | None:
    """Offset of the stamps, s (positive: late), to about a tenth of a second, at which the course
    of the fixes turns as the gyros do; None where the drive does not turn enough to tell.
    """
    grid = np.arange(drive.time[0], drive.time[-1], STEP)
    if grid.size < 60.0 / STEP:
        return None
    down = -np.median(drive.accel, axis=0)
    felt = np.asarray(drive.gyro) @ (down / np.linalg.norm(down))
    angle = np.concatenate([[0.0], np.cumsum(felt[1:] * np.diff(drive.time))])
    turn = np.gradient(np.interp(grid, drive.time, angle), STEP)
    turn = _smooth(turn - np.median(turn), 2.0)
    shown, good = _course_rate(drive, grid)
    if good.sum() < 300 or np.std(shown[good]) < 0.02:
        return None
    lags = np.arange(-FARTHEST, FARTHEST + 0.5 * STEP, STEP)
    match = np.array([_match(np.interp(grid - lag, grid, turn), shown, good) for lag in lags])
    best = int(np.argmax(match))
    others = np.abs(lags - lags[best]) > 4.0
    least = 0.6 if abs(lags[best]) < USUAL else 0.7
    if match[best] < least or match[best] < match[others].max() + 0.1:
        return None
    if 0 < best < lags.size - 1:
        a, b, c = match[best - 1 : best + 2]
        return float(lags[best] + 0.5 * STEP * (a - c) / (a - 2.0 * b + c))
    return None


def _match(turn, shown, good):
    x, y = turn[good], shown[good]
    return float(x @ y / np.sqrt((x @ x) * (y @ y) + 1e-30))


def _smooth(x, span):
    n = max(int(round(span / STEP)), 1)
    return np.convolve(x, np.full(n, 1.0 / n), mode="same")


def _course_rate(drive, grid):
    """Turn rate of the course on a grid, over 2 s, and where it is known."""
    velocity, time = drive.gnss_velocity, np.asarray(drive.gnss_time)
    if velocity is not None and np.isfinite(velocity).all(axis=1).mean() > 0.5:
        v, t = np.asarray(velocity)[:, :2], time
    else:
        moved = earth.meters(drive.gnss_position[1:], drive.gnss_position[:-1])[:, :2]
        v, t = moved / np.diff(time)[:, None], 0.5 * (time[1:] + time[:-1])
    keep = np.isfinite(v).all(axis=1)
    v, t = v[keep], t[keep]
    east, north = np.interp(grid, t, v[:, 1]), np.interp(grid, t, v[:, 0])
    course = np.unwrap(np.arctan2(east, north))
    half = int(round(1.0 / STEP))
    rate = np.zeros(grid.size)
    rate[half:-half] = (course[2 * half :] - course[: -2 * half]) / (2 * half * STEP)
    slow = np.hypot(east, north) < 2.0
    near = np.interp(grid, t, np.arange(t.size))
    hole = np.diff(t, append=t[-1] + 9.0)[near.astype(int)] > 3.0
    bad = np.convolve(slow | hole, np.ones(4 * half + 1), mode="same") > 0.5
    return rate, ~bad & (np.abs(rate) < 1.5)


def in_time(drive: Drive) -> Drive:
    """The drive with fixes that are seconds late or early brought to their time."""
    offset = late(drive)
    if offset is None or abs(offset) < FAR:
        return drive
    return drive.with_(gnss_time=np.asarray(drive.gnss_time) - offset)
