"""A file with the contract's keys is in seconds, however slowly it was logged: said, not refused."""

import numpy as np

from imu_lib.readers import read_record


def test_ten_seconds_a_sample(tmp_path):
    rng = np.random.default_rng(3)
    time = np.r_[np.arange(12) * 10.0, 43_000.0 + np.arange(400) * 10.0]
    accel = rng.normal(0.0, 0.01, (time.size, 3)) + [0.0, 0.0, -9.81]
    np.savez(
        tmp_path / "slow.npz", time=time, gyro=rng.normal(0, 1e-3, (time.size, 3)), accel=accel
    )
    record = read_record(tmp_path / "slow.npz")
    assert abs(record.rate - 0.1) < 1e-9
    assert abs(record.time[12] - 43_000.0) < 1e-6  # the hole stays a hole
    assert any("unusually slow" in note for note in record.notes)
