"""`imu-lib outages` on drives as they come: other units, another rate, late stamps, a reference that
jumps, models that lose the drive; each remedy that a message names is tried.
"""

import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imu_lib import preset
from imu_lib.cli.main import main
from imu_lib.drive_effects import DriveEffect
from imu_lib.errors import InputError
from imu_lib.navigation import (
    earth,
    fix_faults,
    fix_frames,
    models,
    reference,
    simulation,
    trajectory,
    turin,
    unfit,
)
from imu_lib.navigation.statistics import paired
from imu_lib.record import CHANNELS
from imu_lib.units import DEG

PAPER = preset("3dm-gx3-25-2013")
EIGHT = ",".join(f"{start}:20" for start in range(60, 220, 20))
FAST = ("--model", "preset:3dm-gx3-25-2013", "--models", "18AV", "--windows", "150:30,190:30")


@pytest.fixture(scope="module")
def drive():
    whole = turin.drive(1)
    path = trajectory.Trajectory(whole.position, whole.angles, 0.0, 240.0)
    return simulation.simulate_drive(path, PAPER, np.random.default_rng(8), name="drawn")


def run(tmp_path, drive, *flags, expect=0):
    file, out = tmp_path / "drive.npz", tmp_path / "out.json"
    drive.save(file)
    assert main(["outages", str(file), *FAST, "--json", str(out), *flags]) in (
        (0, None) if expect == 0 else (expect,)
    )
    return json.loads(out.read_text()) if expect == 0 else None


def as_stated(tmp_path, drive, *flags, **more):
    """Without the search for a time error, a dozen runs of the filter: where that is not asked."""
    return run(tmp_path, drive, "--as-stated", *flags, **more)


def _errors(content):
    return content["models"]["18AV"]["against"]["reference"]["max"]


def test_the_table_and_the_json_say_whether_to_believe(tmp_path, drive, capsys):
    content = as_stated(tmp_path, drive, "--models", "18AV,18AV+scale")
    model = content["models"]["18AV+scale"]
    assert 0.8 < model["nis"] < 1.2 and model["ranked"]
    assert model["rejected"] == {"position": 0.0, "velocity": 0.0}
    assert 0.2 < model["error_over_predicted"] < 3.0
    assert set(model["estimates"]) == {f"{s}_scale {a}" for s in ("accel", "gyro") for a in "xyz"}
    printed = capsys.readouterr().out
    for column in ("predicted sigma", "error/predicted", "NIS", "rejected", "accel_scale x"):
        assert column in printed


def test_late_stamps_are_told_and_the_remedy_works(tmp_path, drive, capsys):
    late = drive.with_(gnss_time=np.asarray(drive.gnss_time) + 0.5)
    before = run(tmp_path, late, "--windows", EIGHT)
    (said,) = [n for n in before["notes"] if "--latency" in n]
    flags = said.split("run again with ")[1].rstrip(".").split()
    # the filter knows the offset to a hundredth or so at one fix a second
    assert flags[0] == "--latency" and float(flags[1]) == pytest.approx(0.5, abs=0.04)
    after = run(tmp_path, late, "--windows", EIGHT, *flags)
    assert not any("--latency" in n for n in after["notes"])
    straight = as_stated(tmp_path, drive, "--windows", EIGHT)
    lost, given_back, right = (np.array(_errors(c)) for c in (before, after, straight))
    # window by window: less than half as a geometric mean, beyond what chance does to eight pairs
    pair = paired(given_back, lost, ("after", "before"))
    assert pair.better == "after" and pair.ratio < 0.5 and pair.high < 1.0
    # and in each what right stamps give, to half of the 6 m that the filter predicts
    assert np.all(np.abs(given_back - right) < 3.0)


@pytest.mark.parametrize("offset", [18.0, -18.0])
def test_seconds_between_gps_time_and_utc_are_told(tmp_path, drive, offset):
    late = drive.with_(gnss_time=np.asarray(drive.gnss_time) + offset)
    (said,) = [n for n in run(tmp_path, late)["notes"] if "--latency" in n]
    assert float(said.split("--latency ")[1].rstrip(".")) == pytest.approx(offset, abs=0.04)


def test_a_turned_case_is_told_and_the_model_file_holds_it(tmp_path, drive):
    turn = Rotation.from_euler("ZYX", [130.0, 25.0, -40.0], degrees=True)
    back = {k: turn.inv().apply(np.array(getattr(drive, k))) for k in ("gyro", "accel")}
    turned = drive.with_(**back)
    notes = as_stated(tmp_path, turned)["notes"]
    told = [float(n) for n in re.findall(r"(?:roll|pitch|yaw) (-?\d+)", notes[0])]
    # from fixes at one a second, smoothed over two
    assert told == pytest.approx([-40.0, 25.0, 130.0], abs=3.0) and "imu-lib gap" in notes[0]
    angles = dict(zip(("yaw", "pitch", "roll"), np.radians([130.0, 25.0, -40.0])))
    PAPER.with_drive((DriveEffect("mounting", angles),)).save(tmp_path / "model.json")
    content = as_stated(tmp_path, turned, "--model", str(tmp_path / "model.json"))
    assert not any("turned" in n for n in content["notes"])
    assert np.max(_errors(content)) < 30.0


def test_a_model_file_says_what_is_held_of_the_drive(tmp_path, drive):
    late = drive.with_(gnss_time=np.asarray(drive.gnss_time) + 0.5)
    effect = DriveEffect("gnss_time_offset", {"offset": 0.5})
    PAPER.with_drive((effect,)).save(tmp_path / "model.json")
    content = run(tmp_path, late, "--model", str(tmp_path / "model.json"), "--models", "15AV,18AV")
    assert not any("--latency" in n for n in content["notes"])
    assert len(content["models"]) == 3


def test_units_other_than_the_formats(tmp_path, drive, capsys):
    degrees = drive.with_(gyro=np.asarray(drive.gyro) / DEG)
    as_stated(tmp_path, degrees, expect=2)
    error = capsys.readouterr().err
    assert "--gyro-unit deg/s" in error and "Traceback" not in error
    converted = as_stated(tmp_path, degrees, "--gyro-unit", "deg/s")
    straight = as_stated(tmp_path, drive)
    assert _errors(converted) == pytest.approx(_errors(straight), rel=1e-6)
    in_g = drive.with_(accel=np.asarray(drive.accel) / 9.80665)
    as_stated(tmp_path, in_g, expect=2)
    assert "--accel-unit g" in capsys.readouterr().err
    in_g = as_stated(tmp_path, in_g, "--accel-unit", "g")
    assert in_g["models"].keys() == converted["models"].keys()


def test_velocities_in_other_axes_or_units_are_not_ranked_upon(tmp_path, drive, capsys):
    velocity = np.asarray(drive.gnss_velocity)
    for wrong, said in (
        (velocity[:, [1, 0, 2]] * [1.0, 1.0, -1.0], "east, north, up"),
        (3.6 * velocity, "they are in km/h; divide gnss_velocity by 3.6"),
    ):
        bad = drive.with_(gnss_velocity=wrong)
        run(tmp_path, bad, expect=2)
        error = capsys.readouterr().err
        assert said in error and "--no-velocity" in error
    alone = as_stated(tmp_path, bad, "--no-velocity")
    assert alone["models"]["18AV"]["ranked"] and not any("velocities" in n for n in alone["notes"])


def test_degrees_and_minutes_read_as_degrees_are_not_put_on_the_velocities(tmp_path, drive, capsys):
    run(tmp_path, drive.with_(gnss_position=_as_minutes(drive)), expect=2)
    error = capsys.readouterr().err
    assert "divide the minutes by 60" in error and "--no-velocity" not in error


def _as_minutes(drive):
    """Positions in ddmm.mmmm that were read as degrees."""
    angles = np.asarray(drive.gnss_position)[:, :2] / DEG
    whole = np.floor(angles)
    minutes = (whole + 0.6 * (angles - whole)) * DEG
    return np.column_stack([minutes, np.asarray(drive.gnss_position)[:, 2]])


def test_fixes_as_files_get_them_wrong_are_told(drive):
    position, v = np.asarray(drive.gnss_position), np.asarray(drive.gnss_velocity)
    speed, course = np.hypot(v[:, 0], v[:, 1]), np.arctan2(v[:, 1], v[:, 0]) % (2.0 * np.pi)
    for said, changes in (
        ("course, in deg", {"gnss_velocity": np.column_stack([speed, course / DEG, v[:, 2]])}),
        ("course, in rad", {"gnss_velocity": np.column_stack([speed, course, v[:, 2]])}),
        ("sign of the longitudes", {"gnss_position": position * [1.0, -1.0, 1.0]}),
        ("divide the minutes by 60", {"gnss_position": _as_minutes(drive)}),
    ):  # fmt: skip
        assert said in fix_frames.unusable(drive.with_(**changes))
    assert fix_frames.unusable(drive) is None and fix_frames.height_ratio(drive) == 1.0
    feet = drive.with_(gnss_position=position * [1.0, 1.0, 3.2808])
    assert 2.9 < fix_frames.height_ratio(feet) < 3.7  # where `check` names the unit
    with pytest.raises(InputError, match="positions are mirrored"):
        unfit.refuse(drive.with_(gnss_position=position[:, [1, 0, 2]], gnss_velocity=None))
    with pytest.raises(InputError, match="gravity was taken out"):
        unfit.refuse(drive.with_(accel=drive.accel + [0.0, 0.0, 9.8]))


def test_a_log_that_repeats_its_fixes_at_the_rate_of_the_imu_counts_each_once(drive):
    time = drive.time[(drive.time >= drive.gnss_time[0]) & (drive.time <= drive.gnss_time[-1])]
    rows = np.searchsorted(drive.gnss_time, time, side="right") - 1
    position, velocity = drive.gnss_position[rows], drive.gnss_velocity[rows]
    repeated = drive.with_(
        gnss_time=np.array(time), gnss_position=position, gnss_velocity=velocity,
        gnss_position_sd=None, gnss_velocity_sd=None, gnss_fix=None,
    )  # fmt: skip
    assert (~fix_faults.held(repeated)).sum() == len(drive.gnss_time)


def test_ten_samples_a_second_are_not_refused(tmp_path, drive):
    n = len(drive.time) // 10 * 10
    mean = {
        k: np.asarray(getattr(drive, k))[:n].reshape(-1, 10, 3).mean(1) for k in ("gyro", "accel")
    }
    slow = drive.with_(time=np.asarray(drive.time)[:n][9::10], temperature=None, **mean)
    content = as_stated(tmp_path, slow, "--models", "18AV,18AVWD")
    errors = {k: np.median(m["against"]["reference"]["max"]) for k, m in content["models"].items()}
    assert errors["18AVWD"] < 3.0 * errors["18AV"]


def test_levels_follow_the_rate():
    at_100, at_10 = models.levels_at(100.0), models.levels_at(10.0)
    assert at_100 == turin.LEVELS_TABLE_7
    assert all(at_10[c] == max(at_100[c] - 3, 0) for c in at_100)
    assert models.levels_at(200.0)["gyro_x"] == at_100["gyro_x"] + 1


def test_a_reference_that_jumps_is_not_scored_against(tmp_path, drive, capsys):
    time, position = np.asarray(drive.reference_time), np.array(drive.reference_position)
    moved = (time > 160.0) & (time < 185.0)
    position[moved] = earth.shift(position[moved], [60.0, 50.0, 0.0])
    bad = drive.with_(reference_position=position)
    found = reference.look(bad)
    assert "jumps" in found.notes[0] and "78 m" in found.notes[0]
    assert not found.good(150.0, 180.0) and not found.good(170.0, 175.0)
    assert found.good(100.0, 150.0) and found.good(190.0, 220.0)
    assert reference.look(drive).notes == ()
    content = as_stated(tmp_path, bad)
    first, second = content["models"]["18AV"]["against"]["reference"]["max"]
    assert first is None and second < 60.0
    assert any("not scored against the reference" in n for n in content["notes"])


def test_a_model_that_loses_the_drive_is_not_ranked(tmp_path, drive):
    scaled = drive.with_(accel=np.asarray(drive.accel) * 1.15)
    PAPER.save(tmp_path / "model.json")
    content = as_stated(
        tmp_path,
        scaled,
        "--model",
        str(tmp_path / "model.json"),
        "--models",
        "15AV,18AV+scale",
        "--accel-bias",
        "0.1",
        "--gyro-bias",
        "0.001",
    )
    ranked = {n for n, m in content["models"].items() if m["ranked"]}
    assert "18AV+scale" in ranked and "15AV" not in ranked
    assert all({p["better"], p["than"]} <= ranked for p in content["paired"])
    assert all(p["decided"] == (p["high"] < 1.0) for p in content["paired"])
    assert any("15AV rejects" in n and "not ranked" in n for n in content["notes"])


@pytest.mark.parametrize(
    "flags, said",
    [
        (("--speed",), "`speed` (m/s)"),
        (("--lever-arm", "1,2"), "X,Y,Z"),
        (("--models", "18AV+wings"), "unknown addition 'wings'"),
        (("--models", "19AV"), "unknown model '19AV'"),
        (("--columns", "time,gyro_x"), "leave them out"),
        (("--start", "50", "--stop", "20"), "--stop 20"),
        (("--windows", "1e6:30"), "ends after the drive"),
        (("--start", "1e6"), "--start 1000000 would leave too little of the drive, which lasts 2"),
        (("--no-velocity", "--velocity-latency", "1"), "--no-velocity leaves these out"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(tmp_path, drive, capsys, flags, said):
    run(tmp_path, drive, *flags, expect=2)
    error = capsys.readouterr().err
    assert said in error and "Traceback" not in error and "weighing" not in error


def test_every_flag_of_the_drive_is_taken(tmp_path, drive):
    speed = np.hypot(*np.asarray(drive.reference_velocity)[::20, :2].T)
    fast = drive.with_(extra={"speed": speed, "speed_time": np.asarray(drive.time)[::20]})
    plain = as_stated(tmp_path, fast)["models"]["18AV"]["against"]["reference"]["max"]
    known = as_stated(
        tmp_path,
        fast,
        *("--speed", "--road-sd", "0.5", "--scale", "--lever-arm=-0.1,0,0.1"),
        *("--latency", "0.0", "--velocity-latency", "0.01", "--gnss-offset", "1.0"),
    )["models"]["18AV"]
    assert "speed_scale scale" in known["estimates"] and "accel_scale z" in known["estimates"]
    assert np.median(known["against"]["reference"]["max"]) < np.median(plain)


def test_a_bias_left_at_switch_on_is_kept_by_a_model_that_forgets(tmp_path, drive):
    # a Gauss-Markov process forgets it in minutes, an autoregressive one in seconds: 27AR then
    # rejected 44 % of the velocities of a drive with nothing wrong, and was not ranked
    biased = drive.with_(accel=drive.accel + 0.2, gyro=drive.gyro + 0.1 * DEG)
    model = as_stated(tmp_path, biased, "--models", "15AV")["models"]["15AV"]
    assert model["states"] == 21 and model["ranked"]
    assert model["states_added"] == [f"{c} constant" for c in CHANNELS]
    assert model["nis"] < 1.3
