"""Simulated drives: true motion, sensor errors from an error model and what a calibration leaves,
GNSS with its own errors.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.drive import Drive
from imu_lib.model import Model
from imu_lib.processes import GaussMarkov, Sum, WhiteNoise
from imu_lib.record import CHANNELS

from . import attitude, earth
from .trajectory import Trajectory


@dataclass(frozen=True)
class ImuErrors:
    """Sensor errors beyond the error model: standard deviations of what each drive draws anew.

    turn_on_sd : bias, gyro rad/s and accelerometer m/s^2; scale_sd, misalignment_sd : gyro and
    accelerometer, dimensionless and rad
    lever_arm : (3,) m, IMU to antenna, body frame
    """

    turn_on_sd: tuple = (0.0, 0.0)
    scale_sd: tuple = (0.0, 0.0)
    misalignment_sd: tuple = (0.0, 0.0)
    lever_arm: tuple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class GnssErrors:
    """GNSS fixes and their errors.

    rate : Hz; position_sd, velocity_sd : white, north-east-down, m and m/s; drift_sd, drift_time :
    m and s, of the Gauss-Markov part of the position error (multipath, atmosphere); latency : s,
    by which time tags are late; wild : share of fixes thrown off by `wild_sd` m
    """

    rate: float = 1.0
    position_sd: tuple = (1.0, 1.0, 2.0)
    velocity_sd: tuple = (0.05, 0.05, 0.1)
    drift_sd: tuple = (0.0, 0.0, 0.0)
    drift_time: float = 60.0
    latency: float = 0.0
    wild: float = 0.0
    wild_sd: float = 50.0


def simulate_drive(
    path: Trajectory,
    model: Model,
    rng,
    *,
    rate=100.0,
    imu: ImuErrors = ImuErrors(),
    gnss: GnssErrors = GnssErrors(),
    motion=None,
    name="simulated",
) -> Drive:
    """A drive along `path`.

    model : error model of the six channels (its realisation is added to the mean rate and specific
    force of each interval)
    motion : (time, dtheta, dvel, truth at `time`) of `true_motion`, to draw many drives along one
    path
    returns : Drive; its reference is the truth, its IMU readings are the means over the intervals
    that they end
    """
    time, dtheta, dvel, truth = true_motion(path, rate) if motion is None else motion
    n = time.size - 1
    errors = model.simulate(n, rate, rng, channels=CHANNELS)
    readings = np.column_stack([dtheta, dvel]) * rate
    draw = rng.standard_normal((3, 6)), rng.standard_normal((2, 3, 3))
    spread = [np.repeat(pair, 3) for pair in (imu.turn_on_sd, imu.scale_sd)]
    out = readings * (1.0 + draw[0][1] * spread[1]) + draw[0][0] * spread[0]
    for sensor in range(2):
        turned = draw[1][sensor] * imu.misalignment_sd[sensor]
        np.fill_diagonal(turned, 0.0)
        part = slice(3 * sensor, 3 * sensor + 3)
        out[:, part] += readings[:, part] @ turned.T
    out += np.column_stack([errors[c] for c in CHANNELS])
    clock = time[1:] - time[1]
    fixes = fixes_along(path, gnss, rng, time[1], np.asarray(imu.lever_arm, float))
    return Drive(
        clock,
        out[:, :3],
        out[:, 3:],
        **fixes,
        reference_time=clock,
        reference_position=truth.position[1:],
        reference_velocity=truth.velocity[1:],
        reference_attitude=truth.attitude[1:],
        lever_arm=np.asarray(imu.lever_arm, float),
        name=name,
        source=f"simulated, {model.name or 'error model given'}",
    )


def true_motion(path: Trajectory, rate=100.0):
    """What `simulate_drive` needs of a path: (time (n+1,), dtheta (n, 3), dvel (n, 3), truth), to
    be shared by many drives.
    """
    time = path.start + np.arange(int((path.stop - path.start) * rate) + 1) / rate
    return (time, *path.increments(time), path.sample(time))


def fixes_along(path: Trajectory, gnss: GnssErrors, rng, start, lever_arm):
    """The drive's GNSS arrays, times from `start`."""
    step = 1.0 / gnss.rate
    time = np.arange(np.ceil((start + 0.5 * step) / step) * step, path.stop - 1e-6, step)
    truth = path.sample(time)
    rate = path.rates(time)[0]
    turn = attitude.matrix(truth.attitude)
    position = earth.shift(truth.position, turn @ lever_arm)
    velocity = truth.velocity + np.einsum("nij,nj->ni", turn, np.cross(rate, lever_arm))
    error = rng.standard_normal((time.size, 3)) * gnss.position_sd
    if np.any(np.asarray(gnss.drift_sd) > 0.0):
        drift = Sum((GaussMarkov(sigma=1.0, correlation_time=gnss.drift_time),))
        error += np.column_stack(
            [sd * drift.simulate(time.size, gnss.rate, rng) for sd in gnss.drift_sd]
        )
    if gnss.wild > 0.0:
        wild = rng.random(time.size) < gnss.wild
        error[wild] += rng.standard_normal((int(wild.sum()), 3)) * gnss.wild_sd
    noise = rng.standard_normal((time.size, 3)) * gnss.velocity_sd
    sd = np.hypot(gnss.position_sd, gnss.drift_sd)
    return dict(
        gnss_time=time - start + gnss.latency,
        gnss_position=earth.shift(position, error),
        gnss_velocity=velocity + noise,
        gnss_position_sd=np.tile(sd, (time.size, 1)),
        gnss_velocity_sd=np.tile(np.asarray(gnss.velocity_sd, float), (time.size, 1)),
    )


def white_only(model: Model) -> Model:
    """The model reduced to its white noise: what is left when every drift is taken away (for tests
    and demonstrations).
    """
    return Model(
        {c: Sum(tuple(t for t in model[c].terms if isinstance(t, WhiteNoise))) for c in CHANNELS},
        rate=model.rate,
        name="white noise only",
    )
