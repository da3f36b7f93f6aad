"""Attitude: quaternions and direction cosines between body (forward-right-down) and
north-east-down.

`q` is scalar first and turns body vectors into the navigation frame, as does the matrix `c`; Euler
angles are roll, pitch, yaw (rad, z-y-x).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from imu_lib.arrays import Array, ArrayLike


@njit(cache=True)
def rotate_body(q, rotation):
    """In place: q becomes q times the small turn `rotation` (rotation vector in the body frame,
    rad).
    """
    angle2 = rotation[0] ** 2 + rotation[1] ** 2 + rotation[2] ** 2
    half = (
        0.5 - angle2 / 48.0
        if angle2 < 1e-4
        else math.sin(0.5 * math.sqrt(angle2)) / math.sqrt(angle2)
    )
    c = (
        1.0 - angle2 / 8.0 + angle2 * angle2 / 384.0
        if angle2 < 1e-4
        else math.cos(0.5 * math.sqrt(angle2))
    )
    x, y, z = half * rotation[0], half * rotation[1], half * rotation[2]
    a, b, d, e = q[0], q[1], q[2], q[3]
    q[0] = a * c - b * x - d * y - e * z
    q[1] = a * x + b * c + d * z - e * y
    q[2] = a * y - b * z + d * c + e * x
    q[3] = a * z + b * y - d * x + e * c


@njit(cache=True)
def rotate_frame(q, x, y, z):
    """In place: q becomes the small turn (x, y, z), rad in the navigation frame, times q; then
    unit length again.
    """
    angle2 = x * x + y * y + z * z
    half = (
        0.5 - angle2 / 48.0
        if angle2 < 1e-4
        else math.sin(0.5 * math.sqrt(angle2)) / math.sqrt(angle2)
    )
    c = (
        1.0 - angle2 / 8.0 + angle2 * angle2 / 384.0
        if angle2 < 1e-4
        else math.cos(0.5 * math.sqrt(angle2))
    )
    x, y, z = half * x, half * y, half * z
    a, b, d, e = q[0], q[1], q[2], q[3]
    q[0] = c * a - x * b - y * d - z * e
    q[1] = c * b + x * a + y * e - z * d
    q[2] = c * d - x * e + y * a + z * b
    q[3] = c * e + x * d - y * b + z * a
    n = 1.0 / math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    q[0] *= n
    q[1] *= n
    q[2] *= n
    q[3] *= n


@njit(cache=True)
def fill_matrix(q, c):
    """In place: the direction cosines of q, body to navigation, into c (3, 3)."""
    a, b, d, e = q[0], q[1], q[2], q[3]
    c[0, 0] = a * a + b * b - d * d - e * e
    c[0, 1] = 2.0 * (b * d - a * e)
    c[0, 2] = 2.0 * (b * e + a * d)
    c[1, 0] = 2.0 * (b * d + a * e)
    c[1, 1] = a * a - b * b + d * d - e * e
    c[1, 2] = 2.0 * (d * e - a * b)
    c[2, 0] = 2.0 * (b * e - a * d)
    c[2, 1] = 2.0 * (d * e + a * b)
    c[2, 2] = a * a - b * b - d * d + e * e


def quaternion(euler: ArrayLike) -> Array:
    """Quaternion of roll, pitch, yaw: ndarray, shape (..., 3) rad to shape (..., 4)."""
    half = 0.5 * np.asarray(euler, float)
    (cr, cp, cy), (sr, sp, sy) = np.moveaxis(np.cos(half), -1, 0), np.moveaxis(np.sin(half), -1, 0)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def euler(q: ArrayLike) -> Array:
    """Roll, pitch, yaw of quaternions: ndarray, shape (..., 4) to shape (..., 3), rad, yaw in
    (-pi, pi].
    """
    a, b, d, e = np.moveaxis(np.asarray(q, float), -1, 0)
    roll = np.arctan2(2.0 * (d * e + a * b), a * a - b * b - d * d + e * e)
    pitch = np.arcsin(np.clip(2.0 * (a * d - b * e), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (b * d + a * e), a * a + b * b - d * d - e * e)
    return np.stack([roll, pitch, yaw], axis=-1)


def matrix(angles: ArrayLike) -> Array:
    """Direction cosines, body to navigation, of roll, pitch, yaw (2013 paper, Eq. 25): shape (...,
    3) to (..., 3, 3).
    """
    (cr, cp, cy), (sr, sp, sy) = (
        np.moveaxis(f(np.asarray(angles, float)), -1, 0) for f in (np.cos, np.sin)
    )
    rows = [
        [cp * cy, -cr * sy + sr * sp * cy, sr * sy + cr * sp * cy],
        [cp * sy, cr * cy + sr * sp * sy, -sr * cy + cr * sp * sy],
        [-sp, sr * cp, cr * cp],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def skew(v: Array) -> Array:
    """Cross-product matrix of a vector: ndarray, shape (3,) to (3, 3)."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def wrap(angle: ArrayLike) -> Array:
    """Angle into (-pi, pi], rad."""
    return -((-np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi)
