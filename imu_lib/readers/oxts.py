"""A drive of the KITTI data set as it is unpacked: a folder with `timestamps.txt` and `data/`, a
file of one row for each sample.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw

WIDTH = 30
#: Column (from 0) of the body's specific force and rates: forward, left, up.
ACCEL, GYRO = (11, 12, 13), (17, 18, 19)


def folder(path: Path) -> Path | None:
    """The folder with the stamps of such a drive, None where `path` is none."""
    for inner in (path, path / "oxts"):
        if (inner / "timestamps.txt").is_file() and (inner / "data").is_dir():
            return inner
    return None


def read_oxts(path: Path) -> Raw:
    """Stamps, rates and specific force. InputError where stamps and rows differ in number."""
    files = sorted((path / "data").glob("*.txt"))
    stamps = [x for x in (path / "timestamps.txt").read_text().splitlines() if x.strip()]
    if len(files) != len(stamps) or len(files) < 2:
        raise InputError(
            f"{path}: {len(stamps)} stamps and {len(files)} rows in data/; unpack the drive "
            "again, or put the rows into one table."
        )
    try:
        rows = np.array([[float(v) for v in f.read_text().split()] for f in files])
    except ValueError:
        raise InputError(
            f"{path}/data: its rows are no {WIDTH} numbers each; unpack the drive again."
        ) from None
    if rows.ndim != 2 or rows.shape[1] != WIDTH:
        raise InputError(
            f"{path}/data: its rows are no {WIDTH} numbers each; unpack the drive again."
        )
    raw = Raw(str(path), line=lambda row: f"data/{files[row].name}")
    raw.add(
        "date",
        np.array([re.sub(r"(\.\d{9})\d*$", r"\1", s) for s in stamps], dtype=object),
        None,
        "timestamps.txt",
        "the stamps of the drive",
    )
    why = "KITTI's dataformat: forward, left, up"
    raw.add("gyro", rows[:, GYRO], "rad/s", "wx wy wz", why)
    raw.add("accel", rows[:, ACCEL], "m/s^2", "ax ay az", why)
    raw.notes += ("x, y, z are forward, left and up, as KITTI has them.",)
    return raw
