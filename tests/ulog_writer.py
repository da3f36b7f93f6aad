"""A PX4 log of the messages that hold an IMU, by the format's definition (header, format, subscription
and data messages)."""

from __future__ import annotations

import struct

import numpy as np

COMBINED = (
    "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;"
)
ONE = "uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;"


def _message(kind: bytes, payload: bytes) -> bytes:
    return struct.pack("<Hc", len(payload), kind) + payload


def write(path, stamp, gyro, accel, *, apart=False):
    """stamp (n,) us; gyro and accel (n, 3). apart: as `sensor_gyro` and `sensor_accel`."""
    out = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1))
    out += _message(b"B", bytes(40))
    names = {"sensor_gyro": ONE, "sensor_accel": ONE} if apart else {"sensor_combined": COMBINED}
    for name, fields in names.items():
        out += _message(b"F", f"{name}:{fields}".encode())
    for number, name in enumerate(names):
        out += _message(b"A", struct.pack("<BH", 0, number) + name.encode())
    for t, w, a in zip(stamp.tolist(), np.asarray(gyro, "f4"), np.asarray(accel, "f4")):
        if apart:
            for number, x in enumerate((w, a)):
                out += _message(b"D", struct.pack("<HQQ3f", number, t, t - 300, *x))
        else:
            out += _message(b"D", struct.pack("<HQ3fIi3fI", 0, t, *w, 4000, 0, *a, 4000))
    path.write_bytes(bytes(out))
