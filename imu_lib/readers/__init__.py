"""Files into records: whatever an IMU's log looks like, one call, and no unit guessed.

record = read_record("static.csv", gyro_unit="deg/s", accel_unit="g")
record = read_record(gyro="gyro.txt", accel="accel.txt", gyro_unit="rad/s", accel_unit="m/s^2")
drive = read_drive("drive.npz")
"""

from __future__ import annotations

from imu_lib.readers.drives import read_drive
from imu_lib.readers.static import Reading, read, read_counted, read_raw, read_record
from imu_lib.readers.temperature import NoTemperature, read_temperature

__all__ = [
    "NoTemperature",
    "Reading",
    "read",
    "read_temperature",
    "read_counted",
    "read_drive",
    "read_raw",
    "read_record",
]
