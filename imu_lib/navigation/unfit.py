"""What no filter can use as it stands: a drive refused in one sentence, with the remedy."""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.readers.drive_units import ALIKE, turn_ratio
from imu_lib.units import DEG

from . import axes, fix_frames, turns, windows

GRAVITY = (5.0, 16.0)  # m/s^2, what a moving car feels in the median


def refuse(drive: Drive) -> None:
    """InputError where fixes and IMU do not overlap, or one of them is in other axes, signs or
    units than a drive's.
    """
    windows.overlapping(drive)
    if wrong := fix_frames.unusable(drive) or _readings(drive):
        raise InputError(f"{drive.called}: {wrong}")


def _readings(drive):
    felt = float(np.median(np.linalg.norm(drive.accel, axis=1)))
    if not GRAVITY[0] < felt < GRAVITY[1]:
        return (
            f"the accelerometers read {felt:.3g} in the median, where a car feels 9.8 m/s^2: give "
            "their unit (--accel-unit g or mg), or multiply `accel`; where gravity was taken out, "
            "take the readings with it."
        )
    if sensor := axes.reversed_sensor(turns.in_time(drive)):
        return axes.REVERSED[sensor]
    ratio = turn_ratio(drive)
    if ratio is not None and ratio < DEG * ALIKE:
        return (
            f"the gyros turn {1.0 / ratio:.3g} times as fast as the course of the fixes: give "
            "their unit (--gyro-unit deg/s), or multiply `gyro` by pi/180."
        )
    return None
