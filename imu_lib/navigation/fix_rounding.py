"""Positions printed with few digits: a latitude of 1e-7 rad is 0.6 m.

What a receiver states is the error of what it computed; the file holds that rounded, with an error
of its own, uniform within a step (variance step^2/12: Bennett, Bell System Tech. J. 27, 1948).
"""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive

from . import earth

LEAST = 0.02  # m: finer steps are less than errors of the best receivers
NEAR = 0.03  # of a step, by which values may lie off the grid
FEWEST = 20  # different values that show a grid, where hardly any is met twice


def steps(drive: Drive) -> Array:
    """Steps north, east and down on which a drive's positions lie, m (3,); 0 where on none."""
    position = np.asarray(drive.gnss_position, float)
    position = position[np.isfinite(position).all(axis=1)]
    if len(position) < FEWEST:
        return np.zeros(3)
    origin = np.median(position, axis=0)
    out = np.zeros(3)
    for k in range(3):
        unit = np.zeros(3)
        unit[k] = 1e-6 if k < 2 else 1.0
        meter = abs(earth.meters(origin + unit, origin)[k]) / unit[k]
        out[k] = meter * _grid(position[:, k] - position[0, k], LEAST / meter)
    return out


def variance(steps: Array) -> Array:
    """Variance of rounding, m^2 and (m/s)^2 (6,), of positions on these steps and velocities on
    none.
    """
    return np.append(np.square(steps) / 12.0, np.zeros(3))


def _grid(x: Array, least: float) -> float:
    """Step of the grid that x (n,) lies on, not below `least`, or 0. Hardly a value is met twice on
    the move, so that `faults.grid`, which asks for readings that come back, would see no grid.
    """
    level = np.unique(x)
    apart = np.diff(level)
    apart = apart[apart > 0.1 * least]  # the last digit of a float is no step
    if apart.size < (FEWEST if level.size > 0.5 * x.size else 4):
        return 0.0
    for part in (1, 2, 3):
        unit = float(apart.min()) / part
        for reach in (1e2, 1e4, np.inf):  # a step known by few of it is not known for many
            times = np.rint(x / unit)
            near = np.abs(times) <= reach
            if np.any(times[near]):
                unit = float(x[near] @ times[near] / (times[near] @ times[near]))
        if unit >= least and np.mean(np.abs(x / unit - np.rint(x / unit)) < NEAR) > 0.99:
            return unit
    return 0.0
