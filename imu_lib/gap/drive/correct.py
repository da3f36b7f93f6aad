"""A drive put right for what is held: the inverse of what the effects do to readings and stamps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.navigation import earth
from imu_lib.navigation.axes import IDENTITY, to_body

from . import columns


def value(theta: Array, effect: str) -> Array:
    """The held values of an effect's columns, (k,)."""
    return theta[columns.of(effect)]


def cross_coupling(six: Array) -> Array:
    """X of the model file's matrix xy xz yx yz zx zy."""
    xy, xz, yx, yz, zx, zy = six
    return np.array([[0.0, xy, xz], [yx, 0.0, yz], [zx, zy, 0.0]])


def axes_put_right(drive: Drive, permutation: Sequence[str]) -> Drive:
    """The drive with its readings in the axes of the body."""
    if tuple(permutation) == IDENTITY:
        return drive
    c = to_body(permutation)
    return drive.with_(gyro=drive.gyro @ c.T, accel=drive.accel @ c.T)


def turned(drive: Drive, angles: Array) -> Drive:
    """The readings turned from the case's axes into the vehicle's: roll, pitch, yaw in rad."""
    if not np.any(angles):
        return drive
    c = Rotation.from_euler("ZYX", np.asarray(angles, float)[::-1])
    return drive.with_(gyro=c.apply(drive.gyro), accel=c.apply(drive.accel))


def corrected(drive: Drive, theta: Array, moved_at: float = np.inf) -> Drive:
    """The drive with the columns' values taken out (all but the velocity's own offset); moved_at :
    of `State`.
    """
    if not np.any(theta):
        return drive
    eye = np.eye(3)
    a = eye + np.diag(value(theta, "accel_scale"))
    a = a + cross_coupling(value(theta, "accel_misalignment"))
    g = eye + np.diag(value(theta, "gyro_scale"))
    g = g + cross_coupling(value(theta, "gyro_misalignment"))
    m = value(theta, "gyro_g_sensitivity").reshape(3, 3)
    force = np.linalg.solve(a, (drive.accel - value(theta, "accel_bias")).T).T
    rate = np.linalg.solve(g, (drive.gyro - value(theta, "gyro_bias") - force @ m.T).T).T
    offset = value(theta, "gnss_time_offset")[0]
    clock = value(theta, "imu_clock")[0]
    arm = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm)
    return drive.with_(
        time=drive.time[0] + (drive.time - drive.time[0]) / (1.0 + clock),
        gyro=rate,
        accel=force,
        gnss_time=drive.gnss_time - offset,
        gnss_position=_put_back(drive, theta, (offset, moved_at)),
        lever_arm=arm + value(theta, "lever_arm"),
    )


def _put_back(drive: Drive, theta: Array, known: tuple[float, float]) -> Array:
    """Positions of the fixes (m, 3) without the displacement that is held after a part of the
    drive, or from one time on; known : s, by which they are late, and that time by their stamps.
    """
    offset, moved_at = known
    out = np.array(drive.gnss_position, float)
    since = {columns.MOVED: moved_at - offset}
    for part, effect in columns.DISPLACED_AFTER.items():
        since[effect] = drive.time[0] + columns.DISPLACED[part] * drive.duration
    for effect, begin in since.items():
        moved = value(theta, effect)
        if np.any(moved):
            after = drive.gnss_time - offset > begin
            out[after] = earth.shift(out[after], -moved)
    return out


def velocity_shift(theta: Array) -> float:
    """By how much the velocities' stamps are late beyond the positions', s."""
    offset, velocity = value(theta, "gnss_time_offset")
    return float(velocity - offset)
