"""What is hidden in one student's drive: a car, a sensor and a receiver of their own, and effects
that the filter does not know.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.drive import Drive
from imu_lib.exercise.hidden import rounded
from imu_lib.model import Model
from imu_lib.navigation import earth, simulation, trajectory, tuning

LEAST, MOST = 2, 3  # effects in a drive
RATE, FIXES = 100.0, 5.0  # Hz


@dataclass(frozen=True)
class DriveCase:
    """One student's drive.

    base : the model that the student is given; hidden : ("drive", effect, parameters) of each, SI;
    drive : with the effects, without a reference.
    """

    base: Model
    hidden: tuple[tuple[str, str, dict], ...]
    drive: Drive


def draw(rng: np.random.Generator, *, minutes: float = 8.0) -> DriveCase:
    """A drive of `minutes` around blocks with two or three hidden effects."""
    levels = [low * (high / low) ** rng.random() for low, high in LEVELS]
    base = tuning.vehicle_model(*levels)
    count = int(rng.integers(LEAST, MOST + 1))
    kinds = [list(EFFECTS)[i] for i in rng.choice(len(EFFECTS), count, replace=False)]
    hidden = {kind: _rounded(EFFECTS[kind](rng)) for kind in kinds}
    arm = hidden.get("lever_arm", {}).get("arm", (0.0, 0.0, 0.0))
    late = hidden.get("gnss_time_offset", {}).get("offset", 0.0)
    drive = simulation.simulate_drive(
        _path(rng, minutes),
        base,
        rng,
        rate=RATE,
        imu=simulation.ImuErrors(turn_on_sd=(1e-3, 0.03), lever_arm=tuple(arm)),
        gnss=simulation.GnssErrors(rate=FIXES, position_sd=(0.8, 0.8, 1.5), latency=late),
        name="blind",
    ).slice(0.0, 60.0 * minutes)
    drive = _with_readings(drive, hidden, rng)
    return DriveCase(base, tuple(("drive", k, p) for k, p in hidden.items()), drive)


#: Least and greatest noise of a sensor in a car: N of gyros and accelerometers, K of both, SI.
LEVELS = ((5e-5, 2e-4), (1e-3, 3e-3), (1e-6, 4e-6), (3e-5, 1e-4))


def _path(rng, minutes):
    """Around blocks for somewhat longer than `minutes`."""
    speed = rng.uniform(10.0, 15.0)
    legs = int(np.ceil(60.0 * minutes * speed / 100.0 / 2) * 2) + 4
    steps = rng.choice([-1, 1], legs) * rng.uniform(80.0, 260.0, legs)
    north = np.arange(legs) % 2 == 0
    corners = np.cumsum(np.column_stack([np.where(north, steps, 0), np.where(north, 0, steps)]), 0)
    return trajectory.from_waypoints(corners, speed=speed)


def _with_readings(drive: Drive, hidden: dict, rng) -> Drive:
    """The drive with what acts on readings and fixes, its lever arm untold and no reference."""
    gyro, accel = drive.gyro, drive.accel
    if "gyro_scale" in hidden:
        gyro = gyro * (1.0 + np.array(hidden["gyro_scale"]["scale"]))
    if "accel_scale" in hidden:
        accel = accel * (1.0 + np.array(hidden["accel_scale"]["scale"]))
    if "vibration" in hidden:
        speed = np.linalg.norm(drive.reference_velocity, axis=1)
        density = hidden["vibration"]["N_per_speed"] * speed
        accel = accel.copy()
        accel[:, 2] += density * np.sqrt(RATE) * rng.standard_normal(len(accel))
    position = drive.gnss_position
    if "gnss_outliers" in hidden:
        thrown = rng.random(len(position)) < hidden["gnss_outliers"]["fraction"]
        error = rng.standard_normal(position.shape) * hidden["gnss_outliers"]["scale"]
        position = earth.shift(position, error * thrown[:, None])
    nothing = dict.fromkeys(
        ("reference_time", "reference_position", "reference_velocity", "reference_attitude")
    )
    return drive.with_(
        gyro=gyro, accel=accel, gnss_position=position, lever_arm=np.zeros(3), **nothing
    )


def _sign(rng) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _late(rng) -> dict:
    return {"offset": rng.uniform(0.08, 0.3)}


def _arm(rng) -> dict:
    return {"arm": [_sign(rng) * rng.uniform(0.8, 2.0), _sign(rng) * rng.uniform(0.3, 0.8), 0.0]}


def _accel_scale(rng) -> dict:
    return {"scale": [_sign(rng) * rng.uniform(0.02, 0.05), 0.0, 0.0]}


def _gyro_scale(rng) -> dict:
    return {"scale": [0.0, 0.0, _sign(rng) * rng.uniform(0.02, 0.05)]}


def _vibration(rng) -> dict:
    return {"channel": "accel_z", "N_per_speed": rng.uniform(0.002, 0.006)}


def _outliers(rng) -> dict:
    return {"fraction": rng.uniform(0.02, 0.06), "scale": rng.uniform(15.0, 40.0)}


#: Effect -> its parameters, in the names of a model file's key `drive`.
EFFECTS = {
    "gnss_time_offset": _late,
    "lever_arm": _arm,
    "accel_scale": _accel_scale,
    "gyro_scale": _gyro_scale,
    "vibration": _vibration,
    "gnss_outliers": _outliers,
}


def _rounded(parameters: dict) -> dict:
    return {
        k: [rounded(x) for x in v]
        if isinstance(v, list)
        else v
        if isinstance(v, str)
        else rounded(v)
        for k, v in parameters.items()
    }
