"""Records and drives: validation, gaps, what is handed to estimators."""

import pickle

import numpy as np
import pytest

from imu_lib import timing
from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.record import Record


def six(n=1000, seed=1):
    return dict(
        zip(
            ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"),
            np.random.default_rng(seed).normal(size=(6, n)),
        )
    )


def test_a_record_is_immutable_and_travels():
    channels = six()
    record = Record(channels, 100.0, name="a")
    channels["gyro_x"][0] = 99.0  # the caller's array stays the caller's
    assert record["gyro_x"][0] != 99.0
    with pytest.raises(ValueError):
        record["gyro_x"][0] = 1.0
    with pytest.raises(TypeError):
        record.channels["gyro_x"] = record["gyro_y"]
    again = pickle.loads(pickle.dumps(record))
    assert (
        np.array_equal(again["accel"], record["accel"])
        and again.rate == 100.0
        and again.name == "a"
    )


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"channels": {}}, "channels"),
        ({"channels": {"speed": np.ones(9)}}, "speed"),
        ({"channels": {"gyro_x": np.ones(1)}}, "two"),
        ({"channels": {"gyro_x": np.ones(9), "gyro_y": np.ones(8)}}, "gyro_y"),
        ({"channels": {"gyro_x": np.r_[np.ones(8), np.inf]}}, "infinite value at sample 8"),
        ({"channels": {"gyro_x": np.full(9, np.nan)}}, "no number"),
        ({"rate": 0.0}, "rate"),
        ({"rate": np.nan}, "rate"),
        ({"time": np.r_[0.0, 1.0, 1.0, 3:9]}, "sample 2"),
        ({"time": np.ones(8)}, "time"),
        ({"temperature": np.ones(8)}, "temperature"),
    ],
)
def test_what_is_no_record_is_refused_by_name(change, says):
    good = {"channels": {"gyro_x": np.ones(9)}, "rate": 100.0}
    with pytest.raises(ValueError, match=says):
        Record(**{**good, **change})


def test_access_and_slices():
    record = Record(six(), 100.0)
    assert record["gyro"].shape == (1000, 3) and record.duration == 10.0
    part = record.slice(2.0, 5.0)
    assert part.n == 300 and np.array_equal(part["accel_z"], record["accel_z"][200:500])
    with pytest.raises(KeyError, match="gyro_x"):
        Record({"gyro_x": np.ones(9)}, 1.0)["gyro"]
    with pytest.raises(ValueError, match="fewer than two"):
        record.slice(20.0, 30.0)


def with_losses(lost, n=20_000, rate=100.0, jitter=0.0, seed=2):
    """Slots that remain, and their stamps."""
    slot = np.setdiff1d(np.arange(n), lost)
    noise = np.random.default_rng(seed).uniform(-jitter, jitter, len(slot)) / rate
    noise[0] = 0.0
    return slot, slot / rate + noise


@pytest.mark.parametrize(
    "jitter", [0.0, 0.2]
)  # fifths of an interval: stamps keep their order and the steps their medians
def test_every_missing_sample_is_found(jitter):
    lost = np.r_[500, 3000:3004, 3010, 9000:9900]
    slot, time = with_losses(lost, jitter=jitter)
    x = np.sin(slot / 50.0)
    record = Record({"gyro_x": x}, timing.measured_rate(time), time)
    assert record.rate == pytest.approx(
        100.0, rel=1e-4
    )  # jitter of 2 ms over 200 s moves the rate by less
    assert np.array_equal(record.slots(), slot)
    assert [g.missing for g in record.gaps()] == [1, 4, 1, 900]
    even = record.uniform()
    assert (
        even.n == 20_000
        and np.isnan(even["gyro_x"][lost]).all()
        and np.array_equal(even["gyro_x"][slot], x)
    )
    whole = record.continuous(fill=10)
    assert (
        whole.n == 20_000 - 9900 and not whole.missing().any()
    )  # short gaps bridged, cut at the long one
    assert len(whole.notes) == 3
    assert record.longest_stretch().n == 20_000 - 9900


def test_late_stamps_are_no_lost_samples():
    rng = np.random.default_rng(3)
    n = 20_000
    late = np.where(rng.random(n) < 0.02, rng.exponential(0.03, n), 0.0)
    time = np.maximum.accumulate(np.arange(n) / 100.0 + late) + 1e-9 * np.arange(n)
    record = Record({"gyro_x": rng.normal(size=n)}, timing.measured_rate(time), time)
    assert record.gaps() == () and record.rate == pytest.approx(100.0, rel=1e-4)


def test_rate_of_stamps_with_random_losses():
    rng = np.random.default_rng(4)
    slot = np.sort(rng.choice(105_000, 100_000, replace=False))  # one in twenty lost
    time = (slot - slot[0]) / 99.7
    assert timing.measured_rate(time) == pytest.approx(99.7, rel=1e-6)
    assert np.array_equal(timing.slots(time, 99.7), slot - slot[0])


def test_coarse_clock_is_spread():
    time = np.floor(np.arange(500) / 5.0)  # five samples a second, stamps of whole seconds
    spread, repeats = timing.spread_repeats(time)
    assert repeats == 400 and np.allclose(np.diff(spread), 0.2)


def test_nan_breaks_the_longest_stretch():
    x = np.ones(100)
    x[30:60] = np.nan
    record = Record({"gyro_x": x}, 10.0)
    assert record.longest_stretch().n == 40 and record.continuous(fill=5).n == 40
    assert record.continuous(fill=30).n == 100


def drive_arrays(n=500, m=20):
    rng = np.random.default_rng(5)
    return {
        "time": np.arange(n) / 100.0,
        "gyro": rng.normal(scale=1e-3, size=(n, 3)),
        "accel": rng.normal(scale=1e-2, size=(n, 3)) - [0, 0, 9.8],
        "gnss_time": np.linspace(0.1, 4.9, m),
        "gnss_position": np.column_stack([np.full(m, 0.78), np.full(m, 0.13), np.full(m, 250.0)]),
    }


def test_drive_round_trip_and_unknown_keys(tmp_path):
    arrays = drive_arrays() | {"lever_arm": np.array([1.0, 0.0, -1.0]), "odometer": np.arange(4.0)}
    np.savez(tmp_path / "d.npz", **arrays)
    drive = Drive.load(tmp_path / "d.npz")
    drive.save(tmp_path / "e.npz")
    again = Drive.load(tmp_path / "e.npz")
    assert np.array_equal(again.gyro, arrays["gyro"]) and np.array_equal(
        again.extra["odometer"], arrays["odometer"]
    )
    assert np.array_equal(again.lever_arm, arrays["lever_arm"]) and not again.has_reference
    part = drive.slice(1.0, 3.0)
    assert part.time[0] == 1.0 and len(part.time) == 200 and (part.gnss_time >= 1.0).all()


def test_fixes_out_of_order_are_put_right(tmp_path):
    arrays = drive_arrays()
    order = np.r_[0:10, 9, 12, 11, 10, 13:20]  # one repeated, three swapped
    arrays["gnss_time"], arrays["gnss_position"] = (
        arrays["gnss_time"][order],
        arrays["gnss_position"][order],
    )
    arrays["gnss_position"][3] = np.nan
    np.savez(tmp_path / "d.npz", **arrays)
    drive = Drive.load(tmp_path / "d.npz")
    assert (
        len(drive.gnss_time) == 19
        and (np.diff(drive.gnss_time) > 0).all()
        and "gnss_time" in drive.notes[0]
    )


def _with(**changes):
    return lambda: drive_arrays() | changes


@pytest.mark.parametrize(
    ("arrays", "says"),
    [
        (
            lambda: {k: v for k, v in drive_arrays().items() if k != "gnss_position"},
            "no `gnss_position`",
        ),
        (_with(gnss_position=np.tile([45.0, 7.0, 250.0], (20, 1))), "degrees"),
        (_with(gyro=np.ones((499, 3))), "gyro"),
        (_with(gyro=np.full((500, 3), np.nan)), "not a number at sample 0"),
        (_with(time=np.zeros(500)), "rising"),
        (_with(gnss_velocity=np.zeros((19, 3))), "gnss_velocity"),
        (_with(reference_position=np.zeros((5, 3))), "reference_time"),
    ],
)
def test_what_is_no_drive_is_refused(tmp_path, arrays, says):
    np.savez(tmp_path / "d.npz", **arrays())
    with pytest.raises(InputError, match=says):
        Drive.load(tmp_path / "d.npz")
