"""Drives: one .npz with the contract's keys, or an IMU file of any static format and a GNSS file
beside it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from imu_lib.archive import load_arrays, numbers
from imu_lib.drive import Drive, from_arrays
from imu_lib.errors import InputError
from imu_lib.readers import drive_units, names
from imu_lib.readers import gnss as gnss_files
from imu_lib.readers.opening import read_raw
from imu_lib.readers.static import of_one
from imu_lib.readers.streams import slow_kind


def _archive(path, rate, gyro_unit, accel_unit, gnss_offset, columns) -> Drive:
    """A drive from an .npz; units and the first fix's time as the call states them."""
    if columns:
        raise InputError(
            f"{path} is an .npz, whose arrays have their names and their time in s: --columns, "
            "--topic and --time-unit say nothing about it; leave them out."
        )
    arrays = load_arrays(path)
    if rate is not None and "time" not in arrays and "gyro" in arrays:
        arrays["time"] = np.arange(len(arrays["gyro"])) / rate
    for kind, flag in (("gyro", gyro_unit), ("accel", accel_unit)):
        if flag and kind in arrays:
            factor, zero, _ = names.stated(flag, kind)
            arrays[kind] = (numbers(arrays[kind], f"{path}, array `{kind}`,") - zero) * factor
    if gnss_offset is not None and "gnss_time" in arrays and np.size(arrays["gnss_time"]):
        time = numbers(arrays["gnss_time"], f"{path}, array `gnss_time`,")
        first = float(np.asarray(arrays.get("time", [0.0]), float).ravel()[0])
        shift = gnss_offset + first - np.nanmin(time)
        arrays["gnss_time"] = time + shift
        if "reference_time" in arrays:
            stamps = numbers(arrays["reference_time"], f"{path}, array `reference_time`,")
            # on the fixes' clock, as a drive's is, unless it does not even meet them there
            if np.nanmin(stamps) <= np.nanmax(time) and np.nanmax(stamps) >= np.nanmin(time):
                arrays["reference_time"] = stamps + shift
    return from_arrays(arrays, str(path))


def read_drive(
    path=None,
    *,
    gnss=None,
    imu=None,
    rate=None,
    gyro_unit=None,
    accel_unit=None,
    time_unit=None,
    columns=None,
    start=None,
    stop=None,
    topic=None,
    trust_units=False,
    gnss_offset: float | None = None,
) -> Drive:
    """A drive from an .npz, or from an IMU file (`path` or `imu`) and a GNSS file (`gnss`: RTKLIB
    .pos or NMEA).

    Both clocks must be absolute (epoch or dates) to be laid over each other; else `gnss_offset` is
    the IMU's time of the first fix, s. start, stop: s from the first IMU sample. InputError names
    what is missing.
    """
    path = path if path is not None else imu
    if path is None:
        raise InputError("Give a drive (.npz), or an IMU file and --gnss FILE.")
    if gnss is None:
        _refuse_what_is_no_drive(path)
        said = columns or topic or time_unit
        drive, stated = _archive(path, rate, gyro_unit, accel_unit, gnss_offset, said), {}
    else:
        raw = read_raw(path, columns=columns, topic=topic)
        record, _ = of_one(
            raw,
            {"gyro": gyro_unit, "accel": accel_unit},
            {"rate": rate, "time_unit": time_unit, "trust": True, "lenient": False},
        )
        drive = _with_fixes(path, raw, record, gnss, gnss_offset)
        stated = {} if trust_units else {kind: raw.unit(kind) for kind in ("gyro", "accel")}
    if not trust_units:
        units, factor = [], []
        for kind, flag, si in (("gyro", gyro_unit, "rad/s"), ("accel", accel_unit, "m/s^2")):
            flag = flag or (stated[kind] if stated.get(kind) in names.UNITS[kind] else si)
            scale, _, unit = names.stated(flag, kind)
            units.append(unit)
            factor.append(scale)
        drive = drive_units.check(drive, *units, tuple(factor))
    if start is not None or stop is not None:
        try:
            part = drive.slice(start, stop)
        except ValueError:
            given = {"--start": start, "--stop": stop}
            flags = [f"{flag} {s:.10g}" for flag, s in given.items() if s is not None]
            raise InputError(
                f"{drive.source}: {' and '.join(flags)} would leave too little of the drive, which "
                f"lasts {drive.time[-1]:.1f} s; choose a longer part of it."
            ) from None
        drive = part
    return drive


def _refuse_what_is_no_drive(path) -> None:
    """InputError where a path without a GNSS file beside it is no archive."""
    if Path(path).is_dir():
        raise InputError(
            f"{path} is a directory; a drive is an .npz, or an IMU file and --gnss FILE."
        )
    with open(path, "rb") as file:
        archive = file.read(2) == b"PK"
    if archive or Path(path).suffix.lower() == ".npz":
        return
    if Path(path).is_file() and gnss_files.is_gnss(path):
        raise InputError(
            f"{path} is a GNSS solution; give the IMU's file first and this one as --gnss."
        )
    raise InputError(
        f"{path} is no drive: without GNSS positions there is nothing to navigate by; add --gnss "
        "FILE (RTKLIB .pos or NMEA)."
    )


def _with_fixes(path, raw, record, gnss, gnss_offset) -> Drive:
    """The record of an IMU and the fixes of a GNSS file on one clock, as a drive."""
    slow = slow_kind(record)
    if slow:
        raise InputError(
            f"{path}: gyro and accelerometer come at rates of their own; a drive needs both in "
            f"every row: resample the {slow} to the rate of the other."
        )
    missing = [k for k in ("gyro", "accel") if not all(f"{k}_{a}" in record for a in "xyz")]
    if missing:
        raise InputError(f"{path} has not all three {missing[0]} axes; a drive needs all six.")
    empty = record.missing()
    if empty.any():
        record = record.take(
            np.flatnonzero(~empty), f"{int(empty.sum()):,} samples without a number left out."
        )
    arrays = gnss_files.read_gnss(gnss)
    zero = arrays["gnss_time"][0] - gnss_offset if gnss_offset is not None else raw.epoch
    if zero is None:
        raise InputError(
            f"{path} does not tell its absolute time, so {gnss} cannot be laid over it; give "
            "--gnss-offset S, the IMU time of the first fix."
        )
    arrays["gnss_time"] = arrays["gnss_time"] - zero
    if arrays["gnss_time"][0] > record.duration or arrays["gnss_time"][-1] < 0:
        raise InputError(
            f"{gnss} and {path} do not overlap in time (the first fix is "
            f"{arrays['gnss_time'][0]:.6g} s after the first IMU sample); "
            "check the clocks, or give --gnss-offset S."
        )
    arrays |= {"time": record.times(), "gyro": record["gyro"], "accel": record["accel"]}
    if record.temperature is not None:
        arrays["temperature"] = record.temperature
    return from_arrays(arrays, f"{path}", record.notes)
