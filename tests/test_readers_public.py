"""The public records and drives open with the units that their sources state."""

import pytest

from imu_lib.errors import InputError
from imu_lib.readers import read_drive, read_record
from imu_lib.readers.plausibility import gravity

RATE, N = 50.0, 600


REAL = {
    "adis16405_1.npz": (1_000_000, 100.0, {}),
    "hipnuc_ch104.npz": (321_253, 100.0, {}),
    "hipnuc_ch104_original.mat": (
        321_253,
        100.0,
        {"rate": 100, "gyro_unit": "deg/s", "accel_unit": "g"},
    ),
    "mpu6050_10min.npz": (65_067, 99.3, {}),
    "mpu6050_raw_counts.csv": (
        44_930,
        100.0,
        {"gyro_unit": "counts:131", "accel_unit": "counts:16384"},
    ),
    "mtig_gyro_x.npz": (500_000, 100.0, {}),
}


@pytest.mark.parametrize("name", REAL)
def test_real_static_records(data_dir, name):
    n, rate, options = REAL[name]
    found = read_record(data_dir / "static" / name, **options)
    assert found.n == n and found.rate == pytest.approx(rate, rel=1e-3)
    if "accel_z" in found:
        assert 8.8 < gravity(found["accel"]) < 10.3  # m/s^2: the MPU-6050 is 8 % off


def test_real_two_files_and_calibration(data_dir):
    found = read_record(
        gyro=data_dir / "static/phone_gyro.txt",
        accel=data_dir / "static/phone_accel.txt",
        gyro_unit="rad/s",
        accel_unit="m/s^2",
    )
    assert found.rate == pytest.approx(5.0, rel=1e-3) and any(
        "do not overlap" in note for note in found.notes
    )
    for i in range(3):
        assert read_record(data_dir / f"calibration/mpu9150_{i}.npz").rate == 100.0
    ferraris = read_record(
        data_dir / "calibration/ferraris_session.csv",
        rate=204.8,
        gyro_unit="deg/s",
        accel_unit="m/s^2",
    )
    assert ferraris.n == 10_376
    with pytest.raises(InputError, match="counts"):
        read_record(data_dir / "calibration/xsens_mti_poses.npz")


def test_real_drives(data_dir):
    gaps = {"span_a": 3, "span_b": 2, "span_c": 0, "kth_car": 1}
    for name, count in gaps.items():
        assert len(read_drive(data_dir / f"drive/{name}.npz").imu().gaps()) == count
