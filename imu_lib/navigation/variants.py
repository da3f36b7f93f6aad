"""What may be added to an error model in a filter, by name: `18AV+scale+road`.

Each says what is known of the vehicle or estimated of the drive; none changes the error model.
"""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect
from imu_lib.errors import InputError

from .filter_model import FilterModel
from .free import priors
from .preparation import Speed

#: m/s across the vehicle's axis: tyres slip, axes are not where they are thought to be
ROAD_SD = 0.3
#: m/s, of wheel speeds, besides their scale factor
SPEED_SD = 0.2
OUTLIERS = {"fraction": 0.02, "scale": 20.0}
#: name -> (groups of states, what it is)
STATES = {
    "scale": (("accel_scale", "gyro_scale"), "scale factors"),
    "misalignment": (("accel_misalignment", "gyro_misalignment"), "cross-coupling of the axes"),
    "g": (("gyro_g_sensitivity",), "the gyros' sensitivity to acceleration"),
    "time": (("gnss_time_offset", "velocity_offset"), "lateness of the fixes"),
    "lever": (("lever_arm",), "the antenna's place"),
    "clock": (("imu_clock",), "the rate of the IMU's clock"),
    "mounting": (("mounting",), "the case's turn against the vehicle, with the road"),
}
NAMES = (*STATES, "road", "speed", "robust")


def split(name):
    """(model, additions) of a name like 18AV+scale+road. InputError for an unknown addition."""
    base, *extras = (part.strip() for part in name.split("+"))
    for extra in extras:
        if extra not in NAMES:
            raise InputError(f"{name}: unknown addition {extra!r}; they are {', '.join(NAMES)}")
    return base, tuple(extras)


def varied(model: FilterModel, extras, drive: Drive, *, name=None, road_sd=ROAD_SD) -> FilterModel:
    """A filter model with additions, for a drive."""
    free, changes = dict(model.free), {}
    for extra in extras:
        groups, _ = STATES.get(extra, ((), ""))
        if drive.gnss_velocity is None:
            groups = tuple(g for g in groups if g != "velocity_offset")
        free |= priors(*groups)
        if extra in ("road", "mounting"):
            changes["constraint_sd"] = road_sd
        elif extra == "speed":
            changes["speed"] = wheel_speed(drive)
            free |= priors("speed_scale")
        elif extra == "robust" and model.held.get("gnss_outliers") is None:
            changes["effects"] = (*model.effects, DriveEffect("gnss_outliers", OUTLIERS))
    return model.with_(name=name or model.name, free=free, **changes)


def wheel_speed(drive: Drive) -> Speed:
    """The wheels' speed that a drive's file holds: `speed` m/s with `speed_time` s, or one value
    per IMU sample. InputError where there is none.
    """
    value = np.asarray(drive.extra.get("speed", ()), float).ravel()
    if not value.size:
        raise InputError(
            f"{drive.name or 'the drive'} has no wheel speed: it needs the arrays `speed` (m/s) "
            "and `speed_time` (s)"
        )
    time = np.asarray(drive.extra.get("speed_time", drive.time), float).ravel()
    if time.size != value.size:
        raise InputError(
            f"{drive.name or 'the drive'}: `speed` has {value.size} values and its times are "
            f"{time.size}"
        )
    order = np.argsort(time, kind="stable")
    good = order[np.isfinite(time[order]) & np.isfinite(value[order])]
    return Speed(time[good], np.abs(value[good]), SPEED_SD)
