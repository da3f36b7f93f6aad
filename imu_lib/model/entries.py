"""Entries of an error-model file, each fault told with its place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from imu_lib import processes
from imu_lib.errors import InputError
from imu_lib.processes import Process
from imu_lib.units import DEG

#: Bias left at switch-on, standard deviation, where a model does not say: 0.1 deg/s and 0.05 m/s^2.
TURN_ON = {"gyro": 0.1 * DEG, "accel": 0.05}


def turn_on(value: Any, where: str) -> tuple[float, float] | None:
    """(gyro, accelerometer) of the key `turn_on`; what it does not name is the usual one."""
    if value is None:
        return None
    known = isinstance(value, Mapping) and not set(value) - set(TURN_ON)
    pair = [value.get(k, v) for k, v in TURN_ON.items()] if known else []
    if not known or any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in pair):
        raise InputError(
            f"{where}: `turn_on` is an object of two numbers, `gyro` rad/s and `accel` m/s^2, not "
            f"{value!r}"
        )
    if not all(0.0 <= v < np.inf for v in pair):
        raise InputError(f"{where}: `turn_on` holds standard deviations, 0 or above, not {value!r}")
    return float(pair[0]), float(pair[1])


def entries(value: Any, where: str, *, on_record: bool) -> list[Process]:
    """The processes of a list; `on_record`: of those that act on the whole record."""
    if not isinstance(value, list):
        raise InputError(f"{where}: must be a list of processes")
    out = []
    for number, entry in enumerate(value, start=1):
        try:
            out.append(processes.from_json(entry, on_record=on_record))
        except InputError as error:
            raise InputError(f"{where}, entry {number}: {error}") from None
    return out
