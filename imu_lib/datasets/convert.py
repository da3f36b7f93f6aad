"""From the originals of the public records to the files the readers open: SI, the contract's
keys.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from imu_lib import beside, units
from imu_lib.errors import InputError
from imu_lib.readers.binary import read_mat
from imu_lib.readers.rdata import read_rdata

RATE = 100.0


def _save(path: Path, **arrays):
    with beside.whole(path) as part, open(part, "wb") as file:
        np.savez_compressed(file, **arrays)


def _matrix(path, columns: int) -> np.ndarray:
    """The one matrix of an .rda file with at least `columns` columns."""
    found = [np.atleast_2d(v.T).T for v in read_rdata(path).values()]
    found = [v for v in found if v.ndim == 2 and v.shape[0] > 1000 and v.shape[1] >= columns]
    if len(found) != 1:
        raise InputError(f"{path} holds {len(found)} matrices of {columns} columns instead of one.")
    return found[0]


def as_is(originals, targets):
    """Text that the readers open with the options of the registry."""
    for original, target in zip(originals, targets):
        with beside.whole(target) as part:
            shutil.copyfile(original, part)


def rdata_six(originals, targets):
    """gyro deg/s, then accelerometer g; no time stamps: nominal rate."""
    x = _matrix(originals[0], 6)
    _save(
        targets[0],
        time=np.arange(len(x)) / RATE,
        gyro=(x[:, :3] * units.DEG_PER_S).astype(np.float32),
        accel=(x[:, 3:6] * units.G).astype(np.float32),
    )


def rdata_one(originals, targets):
    """One gyro axis, rad/s."""
    x = _matrix(originals[0], 1)[:, 0]
    _save(targets[0], time=np.arange(len(x)) / RATE, gyro_x=x)


def hipnuc_static(originals, targets):
    """accReading g, gyroReading deg/s."""
    raw = read_mat(originals[0])
    gyro, accel = (
        np.column_stack([raw.columns[f"{k}_{a}"] for a in "xyz"]) for k in ("gyro", "accel")
    )
    _save(
        targets[0],
        time=np.arange(len(gyro)) / RATE,
        gyro=(gyro * units.DEG_PER_S).astype(np.float32),
        accel=(accel * units.G).astype(np.float32),
    )


def mpu9150(originals, targets):
    """Text: accelerometer m/s^2, then gyro rad/s."""
    x = np.loadtxt(originals[0], ndmin=2)
    _save(targets[0], time=np.arange(len(x)) / RATE, gyro=x[:, 3:6], accel=x[:, :3])


def imu_tk(originals, targets):
    """Two texts, accelerometer and gyro: time s, then unsigned counts of three axes."""
    accel, gyro = (np.loadtxt(p, ndmin=2) for p in originals)
    _save(targets[0], time=accel[:, 0], accel_counts=accel[:, 1:4], gyro_counts=gyro[:, 1:4])


CONVERSIONS = {f.__name__: f for f in (as_is, rdata_six, rdata_one, hipnuc_static, mpu9150, imu_tk)}
