"""What arrays of a drive cannot be: numbers of another unit or meaning than their key says."""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array

UNWRAPPED = 100.0  # rad: a yaw that counts its turns reaches thirty on a drive about blocks
POLE, ROUND = np.pi / 2 + 1e-9, 2 * np.pi + 1e-9


def numbers(value: Array, key: str) -> None:
    """ValueError where readings (n, 3) are not all numbers."""
    bad = np.flatnonzero(~np.isfinite(value).all(axis=1))
    if bad.size:
        first = value[bad[0]][~np.isfinite(value[bad[0]])][0]
        raise ValueError(
            f"`{key}` is not a number at sample {bad[0]} ({first:g}, {bad.size} such of "
            f"{len(value)}); leave those samples out, their times too: gaps "
            "are bridged"
        )


def position(value: Array | None, key: str) -> None:
    """ValueError where latitude, longitude (rad) and height (m, 3) cannot be that."""
    if value is None:
        return
    good = value[np.isfinite(value).all(axis=1)]
    if not len(good):
        raise ValueError(
            f"`{key}` holds no position that is a number; write latitude, longitude (rad) and "
            "height (m) there"
        )
    lat, lon = np.abs(good[:, :2]).max(axis=0)
    if lat <= POLE and lon <= ROUND:
        return
    said = f"`{key}` has a latitude of {lat:.4g} and a longitude of {lon:.4g}, and both are in rad"
    if lat <= 90.0 and lon <= 360.0:
        raise ValueError(f"{said}: it looks like degrees, multiply them by pi/180")
    metres = (
        "metres from the Earth's centre"
        if np.median(np.abs(good).max(axis=1)) > 3e6
        else ("metres from an origin")
    )
    raise ValueError(
        f"{said}: it looks like {metres}, turn them into latitude and longitude (pymap3d does)"
    )


def attitude(value: Array | None, key: str) -> None:
    """ValueError where roll, pitch and yaw (m, 3) are not in rad."""
    if value is None or not np.isfinite(value).any():
        return
    roll, pitch, yaw = np.nanmax(np.abs(value), axis=0)
    if roll > ROUND or pitch > POLE or yaw > UNWRAPPED:
        raise ValueError(
            f"`{key}` has a roll of {roll:.4g}, a pitch of {pitch:.4g} and a yaw of {yaw:.4g}, and "
            "all are in rad: it looks like degrees, multiply them by pi/180"
        )


def deviations(value: Array | None, key: str) -> None:
    """ValueError where a standard deviation (m, 3) lies below zero."""
    if value is None:
        return
    bad = np.argwhere(value < 0.0)
    if bad.size:
        row, axis = bad[0]
        raise ValueError(
            f"`{key}` is {value[row, axis]:.4g} at row {row}, column {axis}: a standard deviation "
            "does not lie below zero; write nan where none is known"
        )
