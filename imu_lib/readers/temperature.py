"""A temperature record alone: time and temperature out of any file the readers know."""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import degrees, stamps
from imu_lib.readers.opening import read_raw


class NoTemperature(InputError):
    """The file has no temperature."""


def read_temperature(path) -> tuple[np.ndarray, np.ndarray]:
    """Time (s from the first sample) and temperature (degC), both (n,). NoTemperature where there
    is none, InputError where it is at fault."""
    raw = read_raw(path, signal="temperature")
    if "temperature" not in raw.columns:
        raise NoTemperature(f"{path} has no temperature.")
    if raw.units.get("time", "") is None:
        raw.units["time"] = (
            # the contract's unit; a temperature is often logged once a minute, so its rate tells
            # nothing
            "s"
        )
    found = stamps.settle(raw, None, lenient=True, trust=True)
    raw.units.setdefault("temperature", None)
    x = degrees.celsius(raw, found.keep)
    if x is None:
        raise InputError(f"{path}: its temperature is not in degC; give it in degC, degF or K.")
    time = found.time
    t = np.arange(len(found.keep)) / found.rate if time is None else time
    good = np.isfinite(x) & np.isfinite(t)
    if good.sum() < 2 or (np.diff(t[good]) <= 0).any():
        raise InputError(f"{path}: temperature needs at least two numbers at rising times.")
    return t[good], x[good]
