"""PX4 flight logs (`.ulg`) through `pyulog` (optional): gyro in rad/s and accelerometer in m/s^2
by the message's definition, stamps in us since boot.
"""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw

MAGIC = b"ULog\x01\x12\x35"
MESSAGES = ("sensor_combined", "sensor_gyro", "sensor_accel")


def read_ulog(path, *, topic: str | None = None) -> Raw:
    """`sensor_combined`, or `sensor_gyro` with `sensor_accel` where the log has those (or `topic`,
    one of the messages). InputError where there is none of them.
    """
    try:
        from pyulog import ULog
    except ImportError:
        raise InputError(
            f"{path} is a PX4 log, which needs the package pyulog: pip install pyulog."
        ) from None
    try:
        log = ULog(str(path), None)
    except Exception as error:  # a damaged log fails deep inside the parser, each in its own way
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise InputError(
            f"{path} is damaged ({type(error).__name__}: {str(error)[:70]}); copy it again."
        ) from None
    found = {d.name: d.data for d in reversed(log.data_list)}  # the first instance of each
    raw = Raw(str(path), has_topics=True)
    if topic is not None and topic not in found:
        raise InputError(f"{path} has no message {topic}; it has {', '.join(sorted(found)[:12])}.")
    chosen = topic or next((m for m in MESSAGES if m in found), None)
    if chosen == "sensor_combined":
        data = found[chosen]
        raw.add(
            "time",
            data["timestamp"].astype(np.int64),
            "us",
            "timestamp",
            "us since boot by the log's definition",
        )
        _axes(raw, data, "gyro", "gyro_rad[{}]", "rad/s", chosen)
        _axes(raw, data, "accel", "accelerometer_m_s2[{}]", "m/s^2", chosen)
    elif "sensor_gyro" in found or "sensor_accel" in found:
        _apart(raw, found, topic)
    else:
        raise InputError(
            f"{path} has no sensor_combined, sensor_gyro or sensor_accel; it has "
            f"{', '.join(sorted(found)[:12]) or 'no messages'}."
        )
    used = (chosen,) if chosen == "sensor_combined" else MESSAGES[1:]
    for name in sorted(found):
        if name not in used:
            raw.skip(name, "not an IMU's message")
    if raw.rows() < 2:
        raise InputError(
            f"{path}: its {chosen} has {raw.rows()} messages; at least two are needed."
        )
    return raw


def _axes(raw, data, kind, name, unit, message):
    for i, axis in enumerate("xyz"):
        key = name.format(i)
        if key in data:
            raw.add(
                f"{kind}_{axis}",
                np.asarray(data[key], dtype=float),
                unit,
                f"{message}.{key}",
                f"{unit} by the message's definition",
            )


def _apart(raw, found, topic):
    """Gyro and accelerometer as messages of their own: rows of one table in the order of their
    stamps, each with one of them.
    """
    there = [m for m in MESSAGES[1:] if m in found and topic in (None, m)]
    stamp = np.concatenate(
        [found[m].get("timestamp_sample", found[m]["timestamp"]) for m in there]
    ).astype(np.int64)
    order = np.argsort(stamp, kind="stable")
    raw.add("time", stamp[order], "us", "timestamp", "us since boot by the log's definition")
    first = 0
    for message in there:
        data = found[message]
        n = len(data["timestamp"])
        kind, unit = ("gyro", "rad/s") if message == "sensor_gyro" else ("accel", "m/s^2")
        for axis in "xyz":
            x = np.full(len(stamp), np.nan)
            x[first : first + n] = data[axis]
            raw.add(
                f"{kind}_{axis}",
                x[order],
                unit,
                f"{message}.{axis}",
                f"{unit} by the message's definition",
            )
        first += n
