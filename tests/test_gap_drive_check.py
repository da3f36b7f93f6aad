"""What `check` finds on a drive against itself."""

from types import SimpleNamespace

import drive_generator as generator
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imu_lib.drive import from_arrays
from imu_lib.errors import InputError
from imu_lib.gap.drive import admission, left, vehicle
from imu_lib.health.drive import of_drive
from imu_lib.health.driven import disagreements
from imu_lib.navigation import fix_faults, lateness, preparation, windows
from imu_lib.readers import read_drive

RIGHT = generator.make(21, duration=200.0)
STAMPS = RIGHT["gnss_time"]
CASE = Rotation.from_euler("ZYX", [130.0, 25.0, -40.0], degrees=True)


def jumped():
    """Heights of another datum in the second half."""
    return RIGHT["gnss_position"] - np.outer(STAMPS > 100.0, [0.0, 0.0, 46.0])


def repeated():
    """Fixes of a receiver that gives its last solution for twelve seconds."""
    out = {k: RIGHT[k].copy() for k in ("gnss_position", "gnss_velocity")}
    away = np.flatnonzero((STAMPS > 80.0) & (STAMPS < 92.0))
    for values in out.values():
        values[away] = values[away[0]]
    return out


def said(**changes):
    return " ".join(disagreements(from_arrays({**RIGHT, **changes}, "x")))


def test_a_right_drive_says_nothing():
    assert said() == ""


@pytest.mark.parametrize(
    ("word", "changes"),
    [
        ("late", {"gnss_time": RIGHT["gnss_time"] + 2.0}),
        ("forward, right, down", {k: RIGHT[k][:, [1, 0, 2]] * [1, -1, 1] for k in ("gyro", "accel")}),
        ("deg/s", {"gyro": RIGHT["gyro"] * 180 / np.pi}),
        ("multiply `accel` by -1", {"accel": -RIGHT["accel"]}),
        ("multiply `gyro` by -1", {"gyro": -RIGHT["gyro"]}),
        ("Gravity", {"accel": RIGHT["accel"] * 0.96}),
        ("east, north, up", {"gnss_velocity": RIGHT["gnss_velocity"][:, [1, 0, 2]] * [1, 1, -1]}),
        ("too small", {"gnss_position_sd": RIGHT["gnss_position_sd"] * 0.1}),
        ("jumps", {"reference_position": RIGHT["reference_position"]
                   + np.where(np.arange(len(RIGHT["reference_time"])) == 700, 2e-5, 0.0)[:, None]}),
        ("in km/h; divide gnss_velocity by 3.6", {"gnss_velocity": 3.6 * RIGHT["gnss_velocity"]}),
        ("in knots", {"gnss_velocity": RIGHT["gnss_velocity"] / 0.51444}),
        ("their heights by -4", {"gnss_position": jumped()}),
        ("repeat the position", repeated()),
        ("s late in the second: one of the clocks", {"gnss_time": STAMPS + (STAMPS > 100.0)}),
        ("longitude, latitude", {"gnss_position": RIGHT["gnss_position"][:, [1, 0, 2]]}),
        ("heights rise where", {"gnss_velocity": RIGHT["gnss_velocity"] * [1, 1, -1]}),
        ("roll -40, pitch 25", {k: CASE.inv().apply(RIGHT[k]) for k in ("gyro", "accel")}),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(word, changes):
    assert word in said(**changes)


@pytest.mark.parametrize("late", [2.0, -1.5])
def test_the_flag_for_late_fixes_undoes_the_delay(late):
    """`outages --latency S` takes a fix stamped t at t - S: late stamps ask for a positive S."""
    words = said(gnss_time=RIGHT["gnss_time"] + late).split("--latency ")[1]
    assert abs(float(words.split(",")[0]) - late) < 0.2


def test_units_and_signs_are_asked_for_and_not_explained():
    drive = from_arrays(generator.make(9, duration=240.0), "x")
    admission.check(drive)
    upside = np.array([1.0, 1.0, -1.0])
    for word, changes in {
        "--gyro-unit deg/s": {"gyro": np.degrees(drive.gyro)},
        "multiply `gyro`": {"gyro": -drive.gyro},
        "--accel-unit g": {"accel": drive.accel / 9.81},
        "third column": {"gnss_velocity": drive.gnss_velocity * upside},
        "never moves faster": {
            "gnss_position": np.repeat(drive.gnss_position[:1], len(drive.gnss_time), axis=0),
            "gnss_velocity": 0.0 * drive.gnss_velocity,
            "reference_velocity": None,
        },
    }.items():
        with pytest.raises(InputError, match=word):
            admission.check(drive.with_(**changes))


def test_fixes_are_found_that_are_most_of_a_minute_late():
    drive = from_arrays(generator.make(9, duration=240.0), "x")
    late, likeness, _ = lateness.best_match(drive.with_(gnss_time=drive.gnss_time + 40.0))
    assert abs(late - 40.0) < 0.2 and likeness > 0.7


def test_a_gyro_that_is_not_connected_hides_no_late_stamps():
    # its correlation was a division by zero, and the accelerations' was lost in it
    drive = from_arrays(generator.make(9, duration=240.0), "x")
    dead = drive.with_(gyro=np.full_like(drive.gyro, 0.01))
    late, likeness, _ = lateness.best_match(dead.with_(gnss_time=drive.gnss_time + 3.0))
    assert abs(late - lateness.best_match(dead)[0] - 3.0) < 0.05 and likeness > 0.5


def test_a_noise_that_no_sensor_has_is_said(monkeypatch):
    monkeypatch.setattr(left.readings, "shows", lambda *_: False)  # the readings are quiet
    state, after = SimpleNamespace(problem=None), SimpleNamespace(right=True)
    parameters = {"channel": "gyro_x", "process": "white_noise", "name": "N", "from": 1e-4}
    found = [{"effect": "bias_model", "parameters": {**parameters, "to": 2e-3}}]
    assert left.absurd(found, state, after) is None
    found[0]["parameters"]["to"] = 2e-2
    assert "200 times" in left.absurd(found, state, after)


def test_fixes_that_only_repeat_the_last_are_not_used():
    drive = from_arrays({**RIGHT, **repeated()}, "x")
    prepared = preparation.prepare(drive)
    away = (prepared.fixes.time > 80.5) & (prepared.fixes.time < 92.0)
    assert not away.any() and any("repeat the position" in n for n in prepared.notes)
    # nobody drops the fixes of a car that stands
    still = {k: RIGHT[k].copy() for k in ("gnss_position", "gnss_velocity")}
    for values in still.values():
        values[STAMPS < 15.0] = values[0]
    assert not fix_faults.held(from_arrays({**RIGHT, **still}, "x")).any()


def test_stamps_that_jitter_are_no_missing_samples():
    rng = np.random.default_rng(4)
    time = RIGHT["time"] + rng.uniform(-0.004, 0.004, RIGHT["time"].size)
    notes = preparation.prepare(from_arrays({**RIGHT, "time": time}, "x")).notes
    assert not any("missing" in n for n in notes)
    kept = rng.random(time.size) > 0.02
    holes = {k: RIGHT[k][kept] for k in ("time", "gyro", "accel", "temperature")}
    (said,) = [n for n in preparation.prepare(from_arrays({**RIGHT, **holes}, "x")).notes]
    assert int(said.split()[0]) == np.flatnonzero(kept)[-1] + 1 - kept.sum()


def test_outages_begin_where_fixes_in_bursts_end():
    kept = STAMPS % 10.0 < 1.0
    burst = {k: v[kept] for k, v in RIGHT.items() if k.startswith("gnss_")}
    drive = from_arrays({**RIGHT, **burst}, "x")
    found = windows.regular_windows(drive, duration=20.0, settle=37.0)
    assert len(found) >= 4 and not any(windows.broken(drive, w) for w in found)


def test_fixes_over_a_second_of_a_drive_are_no_drive():
    few = {k: v[:3] for k, v in RIGHT.items() if k.startswith("gnss_")}
    drive = from_arrays({**RIGHT, **few}, "x")
    said = windows.uncovered(drive)
    assert said.startswith("3 fixes, from ") and said in of_drive(drive).findings
    with pytest.raises(InputError, match="3 fixes, from .* give the whole GNSS solution"):
        windows.regular_windows(drive)
    assert not windows.uncovered(from_arrays(RIGHT, "x"))


def test_an_offset_brings_fixes_and_reference_of_one_file_to_the_clock_of_the_imu(tmp_path):
    path, late = tmp_path / "drive.npz", dict(RIGHT)
    for key in ("gnss_time", "reference_time"):
        late[key] = RIGHT[key] + 5000.0
    np.savez(path, **late)
    drive = read_drive(path, gnss_offset=STAMPS[0] - RIGHT["time"][0])
    assert drive.gnss_time == pytest.approx(STAMPS, abs=1e-6)
    assert drive.reference_time == pytest.approx(RIGHT["reference_time"], abs=1e-6)
    np.savez(path, **{**late, "reference_time": RIGHT["reference_time"]})
    drive = read_drive(path, gnss_offset=STAMPS[0] - RIGHT["time"][0])
    assert drive.reference_time == pytest.approx(RIGHT["reference_time"], abs=1e-6)


@pytest.mark.parametrize("angles", [(0.1, 0.2, 0.3), (-0.7, 0.44, 2.27), (0.0, 0.0, -3.0)])
def test_mounting_is_exact_at_any_angle(angles):
    rng, count = np.random.default_rng(1), 600
    tilt = rng.normal(0.0, 0.02, (count, 2))
    yaw = np.cumsum(rng.normal(0.0, 0.05, count))
    vehicle_to_ned = Rotation.from_euler("ZYX", np.column_stack([yaw, tilt]))
    case = vehicle_to_ned * Rotation.from_euler("ZYX", angles[::-1])
    path = {
        "time": np.arange(float(count)), "velocity": vehicle_to_ned.apply([15.0, 0.0, 0.0]),
        "attitude": case.as_euler("ZYX")[:, ::-1],
    }  # fmt: skip
    found, sd = vehicle.mounting(SimpleNamespace(path=path), np.full(3, 0.003))
    # roll by the median of 540 rolls of 0.02 rad
    assert found == pytest.approx(angles, abs=0.005) and np.all(sd < 0.03)
