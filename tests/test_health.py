"""What `check` sees: each defect put in is found, and a sound record has none."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from imu_lib import health, units
from imu_lib.cli.main import main
from imu_lib.health import driven
from imu_lib.record import Record

N, RATE = 120_000, 100.0


def sound(seed=1, **change):
    """Twenty minutes of a plausible six-axis sensor at rest; `change` alters channels."""
    rng = np.random.default_rng(seed)
    x = {f"gyro_{a}": 0.01 + rng.normal(scale=3e-3, size=N) for a in "xyz"}
    x |= {
        f"accel_{a}": rng.normal(scale=1e-2, size=N) - (units.G if a == "z" else 0) for a in "xyz"
    }
    for name, function in change.items():
        x[name] = function(x[name])
    return Record(x, RATE)


def test_a_sound_record_has_nothing_to_object_to():
    found = health.of_record(sound())
    assert (
        found.findings == ()
        and found.motion.state == "at rest"
        and found.motion.gravity == pytest.approx(units.G, rel=1e-3)
    )
    assert found.channels["gyro_x"].noise == pytest.approx(
        3e-3 / RATE**0.5, rel=0.01
    )  # 120,000 samples tell it to 0.3 %
    assert found.channels["gyro_x"].resolution is None


@pytest.mark.parametrize("lsb", [8.7266e-4, 2.4e-3])
def test_resolution(lsb):
    found = health.of_record(
        sound(
            gyro_y=lambda x: np.round(x / lsb) * lsb,
            accel_x=lambda x: np.float32(np.round(x / 0.003) * 0.003),
        )
    )
    assert found.channels["gyro_y"].resolution == pytest.approx(lsb, rel=1e-9)
    assert found.channels["accel_x"].resolution == pytest.approx(
        0.003, rel=1e-5
    )  # single precision
    assert found.findings == ()


def frozen(x):
    x = x.copy()
    x[5000:5400] = x[5000]
    return x


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"gyro_x": lambda x: np.clip(x, -1, 0.014)}, "gyro_x piles up"),
        (
            {"accel_y": frozen},
            "accel_y repeats its value in 399 samples (0.33 %), from 50.01 to 53.99 s, up to 400",
        ),
        (
            {"gyro_z": lambda x: np.where(np.arange(N) % 1000 == 7, np.nan, x)},
            "120 values are missing (NaN) on gyro_z",
        ),
        ({"accel_x": lambda x: np.round(x / 0.05) * 0.05}, "rounding hides"),
        ({"gyro_x": lambda x: x + 0.3 * (np.arange(N) > 100_000)}, "partly moving"),
        ({"accel_z": lambda x: x + units.G}, "no gravity"),
        ({"gyro_y": lambda x: x * 1e-3, "gyro_x": lambda x: x * 1e-3}, "rarely go together"),
    ],
)
def test_each_defect_is_found(change, says):
    found = health.of_record(sound(**change))
    assert any(says in sentence for sentence in found.findings), found.findings


def test_slow_drift_is_rest_and_handling_is_not():
    drift = health.of_record(sound(gyro_x=lambda x: x + 2e-3 * np.sin(np.arange(N) / 2e4)))
    assert drift.motion.state == "at rest"
    turn = np.where((np.arange(N) > 60_000) & (np.arange(N) < 60_300), 0.5, 0.0)
    found = health.of_record(
        sound(gyro_x=lambda x: x + turn, accel_x=lambda x: x + 3.0 * (np.arange(N) > 60_150))
    )
    assert found.motion.moving_share > 0
    assert found.motion.rest_stop <= 600.0 or found.motion.rest_start >= 603.0


def test_of_a_drive(data_dir, capsys, tmp_path):
    out = tmp_path / "c.json"
    assert main(["check", str(data_dir / "drive/span_c.npz"), "--json", str(out)]) == 0
    text, told = capsys.readouterr().out, json.loads(out.read_text())
    assert (
        "1: 867, 4: 821, 5: 45" in text
        and told["gnss"]["fixes"] == 1733
        and told["gnss"]["reference"]
        and told["motion"]["state"] == "moving"
    )


@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("adis16405_1", 0.05 * units.DEG_PER_S),
        ("hipnuc_ch104", 0.01 * units.DEG_PER_S),
        ("mpu6050_10min", units.DEG_PER_S / 131),
    ],
)
def test_of_real_records(data_dir, name, step):
    from imu_lib.readers import read_record

    found = health.of_record(read_record(data_dir / f"static/{name}.npz"))
    # somebody was at the table in the first seconds of one of them
    state = "touched" if name == "adis16405_1" else "at rest"
    assert found.motion.state == state and found.channels["gyro_x"].resolution == pytest.approx(
        step, rel=1e-3
    )
    assert found.clock.bursts == (name == "mpu6050_10min")


def test_the_ends_of_a_coarse_grid_are_not_clipped():
    rng = np.random.default_rng(3)
    for step in (0.01, 0.02, 0.2):  # thirty levels to two
        x = np.rint(rng.standard_t(4, 20_000) * 0.03 / step) * step
        assert health.channels.of_channel("gyro_x", x, 100.0, ()).saturated == 0
    cut = np.clip(np.rint(rng.normal(0, 0.1, 20_000) / 0.01) * 0.01, -0.2, 0.2)
    assert health.channels.of_channel("gyro_x", cut, 100.0, ()).saturated > 500


def test_a_clipped_channel_is_told_in_its_unit():
    record = sound()
    x = np.clip(record.channels["gyro_x"], None, np.quantile(record.channels["gyro_x"], 0.95))
    told = health.of_record(Record({**record.channels, "gyro_x": x}, record.rate)).findings
    assert any(s.startswith("gyro_x piles up") and "deg/s): clipped" in s for s in told)


def test_too_few_samples_are_said_and_no_channel_is_called_stuck():
    from imu_lib.errors import InputError
    from imu_lib.gap.fault_masking import ready

    record = Record({c: x[:3] for c, x in sound().channels.items()}, 100.0)
    assert any("at least 100 are needed" in s for s in health.of_record(record).findings)
    with pytest.raises(InputError, match="3 samples are too few"):
        ready(record)


def test_a_copy_with_the_sign_reversed_is_said_so():
    from imu_lib.gap.fault_masking import ready

    x = dict(sound().channels)
    x["accel_y"] = -x["accel_x"] + 0.1
    assert "sign reversed" in ready(Record(x, 100.0)).left_out["accel_y"]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_bias_of_the_vertical_accelerometer_has_the_sign_of_the_file(sign):
    """An accelerometer that reads -9.46 where it should read -9.81 has a bias of +0.35."""
    accel = np.tile([0.0, 0.0, -sign * 9.46], (2000, 1)) + 1e-3 * sound()["accel_x"][:2000, None]
    drive = SimpleNamespace(
        time=np.arange(2000) / 100.0,
        rate=100.0,
        accel=accel,
        gyro=np.zeros((2000, 3)),
        gnss_position=np.array([[0.8, 0.2, 100.0]]),
    )
    (told,) = driven._weight(drive)
    assert f"a bias of {'+-'[sign < 0]}0.35 m/s^2 on the accelerometer's z" in told
