"""Fixes and speeds as the kernel takes them in one run, and what is carried over a hole between two
runs.
"""

import numpy as np

from imu_lib.arrays import Array

from .earth import horizontal
from .states import SensorStates
from .structures import FixTable, SpeedTable


def fix_table(stretch, begin, end, fixes, zero):
    """The fixes of a run from epoch `begin` to `end` of a stretch, and their rows.

    fixes : preparation.Fixes, or None for none; zero : s, first IMU sample
    returns : FixTable, ndarray of rows
    """
    if fixes is None:
        none, whole = np.zeros(0), np.zeros(0, np.int64)
        return FixTable(whole, none, none, np.zeros((0, 6)), np.zeros((0, 6)), whole), whole
    epoch = np.searchsorted(stretch.time, fixes.time - 1e-9).astype(np.int64)
    rows = np.flatnonzero((epoch > begin) & (epoch <= end))
    epoch, time = epoch[rows], fixes.time[rows]
    table = FixTable(
        epoch,
        stretch.time[epoch] - time,
        time - zero,
        fixes.value[rows],
        fixes.variance[rows],
        fixes.use[rows],
    )
    return table, rows


def speed_table(stretch, begin, end, speed) -> SpeedTable:
    """The speeds of a run (speed : preparation.Speed, or None)."""
    if speed is None:
        none = np.zeros(0)
        return SpeedTable(np.zeros(0, np.int64), none, none)
    epoch = np.searchsorted(stretch.time, speed.time - 1e-9).astype(np.int64)
    rows = np.flatnonzero((epoch > begin) & (epoch <= end) & np.isfinite(speed.value))
    value = np.asarray(speed.value, float)[rows]
    return SpeedTable(epoch[rows], value, np.full(rows.size, float(speed.sd) ** 2))


def parked(stretch, fixes, last, angles):
    """The heading before a hole in the data, where the car stood before it and stands at the same
    place after it; else None.

    last (16,) the navigation state before; angles : quaternions (k, 4) to the vehicle's angles
    """
    after = (fixes.time >= stretch.time[0]) & (fixes.use & 1 > 0)
    velocity = fixes.value[after, 3:5][:1]
    stood = np.hypot(*last[3:5]) < 0.5
    if (
        not after.any()
        or not stood
        or np.hypot(*velocity[0]) > 0.5
        or horizontal(fixes.value[after, :3][0], last[:3]) > 5.0
    ):
        return None
    return float(angles(last[None, 6:10])[0, 2])


def over(sensors: SensorStates, steps: int) -> tuple[Array, Array]:
    """Transition and noise (m, m) of the sensor states over so many steps, by doubling: the noise
    of 2k steps is that of k, carried on, and that of k.
    """
    power, total = sensors.transition.copy(), sensors.noise.copy()
    out_s, out_q = np.eye(len(total)), np.zeros_like(total)
    while steps:
        if steps & 1:
            out_q = power @ out_q @ power.T + total
            out_s = power @ out_s
        total = power @ total @ power.T + total
        power = power @ power
        steps >>= 1
    return out_s, out_q


def across(sensors, rate, x, p, gap):
    """Sensor states (m,) and their covariance carried over a hole in the data, `gap` s."""
    transition, noise = over(sensors, max(int(round(gap * rate)), 0))
    return transition @ x, transition @ p @ transition.T + noise
