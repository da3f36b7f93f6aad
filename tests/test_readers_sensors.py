"""Several sensors in one table, axes named by their direction, and stamps of other kinds."""

import re

import numpy as np
import pytest
import strange_logs
from test_readers_kinds import opened, same

from imu_lib.errors import InputError


def _rows(head, *columns, end=""):
    return strange_logs.table(head, *columns) + end


def test_rows_of_several_sensors_are_asked_for(tmp_path):
    """Two sensors in turn, 37 us apart: the sentence names the column, and each answer that it gives
    opens with that sensor's readings at its rate.
    """
    n = strange_logs.N
    stamp = np.repeat(strange_logs.I * 10_000, 2) + np.tile([0, 37], n)
    gyro, accel = np.repeat(strange_logs.GYRO, 2, axis=0), np.repeat(strange_logs.ACCEL, 2, axis=0)
    for labels, column in (([0, 1], "I"), (["left", "right"], "sensor"), ([1, 2], "IMU ID")):
        text = _rows(
            f"type,TimeUS,{column},GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
            ["IMU"] * (2 * n),
            stamp,
            labels * n,
            gyro + np.tile([0.0, 1.0], n)[:, None],
            accel,
        )
        with pytest.raises(InputError, match=f"`{column}` tells 2 sensors apart") as error:
            opened(tmp_path / "two.csv", text, strange_logs.SI)
        one, two, every = re.findall(r"--topic '[^']+'", str(error.value))
        record = same(opened(tmp_path / "two.csv", text, f"{strange_logs.SI} {one}"), 100)
        assert any("rows of other sensors" in note for note in record.notes)
        other = opened(tmp_path / "two.csv", text, f"{strange_logs.SI} {two}").record
        assert np.allclose(other["gyro_x"], strange_logs.GYRO[:, 0] + 1, atol=1e-6)
        merged = opened(
            tmp_path / "two.csv", text, f"{strange_logs.SI} --trust-units {every}"
        ).record
        assert any("unusual" in note or "bursts" in note for note in merged.notes)
    plain = _rows("time_s,gx,gy,gz", strange_logs.T, strange_logs.GYRO)
    with pytest.raises(InputError, match="no column that tells"):
        opened(tmp_path / "one.csv", plain, "--gyro-unit rad/s --topic I=0")


def _asked_and_answered(folder, names, question):
    """Two gyros and an accelerometer under these names: asked for, and the answer opens one."""
    text = _rows(
        ",".join(["time_s", *names]),
        strange_logs.T,
        strange_logs.GYRO,
        strange_logs.GYRO + 1,
        strange_logs.ACCEL,
    )
    with pytest.raises(InputError, match=question) as error:
        opened(folder / "two.csv", text, strange_logs.SI)
    answer = re.search(r"--columns '[^']+'", str(error.value))[0]
    record = same(opened(folder / "two.csv", text, f"{strange_logs.SI} {answer}"), 100)
    assert len(record.channel_names) == 6


@pytest.mark.parametrize("names", ["{k}{i}_{a}", "{k}{a}{i}", "{k}_{a}_{i}", "{k}{i}{a}"])
def test_numbered_sensors_are_asked_for_and_the_answer_is_one_of_them(tmp_path, names):
    pick = [names.format(k="g", a=a, i=i) for i in (1, 2) for a in "xyz"]
    pick += [names.format(k="a", a=a, i=1) for a in "xyz"]
    _asked_and_answered(tmp_path, pick, "would be gyro_")


@pytest.mark.parametrize(
    "head, flags",
    [
        ("t [s],Roll rate [rad/s],Pitch rate [rad/s],Yaw rate [rad/s],Long acc [m/s^2],Lat acc [m/s^2],Vert acc [m/s^2]", ""),
        ("time_s,rollrate [rad/s],pitchrate [rad/s],yawrate [rad/s],a_long [m/s^2],a_lat [m/s^2],a_vert [m/s^2]", ""),
        ("time_s,gyro_fwd,gyro_right,gyro_down,acc_fwd,acc_right,acc_down", strange_logs.SI),
        ("time_s,gyro_roll,gyro_pitch,gyro_yaw,accel_x,accel_y,accel_z", strange_logs.SI),
        ("t,p,q,r,ax,ay,az", strange_logs.SI),
        ("t,P (rad/s),Q (rad/s),R (rad/s),ax (m/s2),ay (m/s2),az (m/s2)", ""),
    ],
)  # fmt: skip
def test_axes_named_by_their_direction(tmp_path, head, flags):
    text = _rows(head, strange_logs.T, strange_logs.GYRO, strange_logs.ACCEL)
    assert len(same(opened(tmp_path / "a.csv", text, flags), 100).channel_names) == 6


def test_words_of_direction_that_are_no_sensor(tmp_path):
    """An accuracy in m, an attitude and a quaternion are not read as an axis."""
    head = "time_s,qw,p,q,r,gyro_yaw [deg],vert acc [m],ax,ay,az"
    zero = strange_logs.T * 0
    text = _rows(head, strange_logs.T, *[zero + 1] * 6, strange_logs.ACCEL)
    found = opened(tmp_path / "a.csv", text, "--accel-unit m/s^2").record
    assert found.channel_names == ("accel_x", "accel_y", "accel_z")


def test_intervals_are_added_up(tmp_path):
    for head, step in (
        ("dt_ms", 10), ("dt [s]", 0.01), ("delta_t_us", 10_000), ("dt", 0.01), ("Time since last sample (us)", 10_000),
    ):  # fmt: skip
        text = _rows(f"{head},gx,gy,gz", strange_logs.T * 0 + step, strange_logs.GYRO)
        record = same(opened(tmp_path / "dt.csv", text, "--gyro-unit rad/s"), 100)
        assert any("added up" in note for note in record.notes)
    none = _rows("dt_ms,gx,gy,gz", strange_logs.T * 0, strange_logs.GYRO)
    same(opened(tmp_path / "dt.csv", none, "--gyro-unit rad/s --rate 100"), 100)
    hole = strange_logs.T * 0 + 10.0
    hole[0] = -1.0
    hole[50] = 60.0
    text = _rows("dt_ms,gx,gy,gz", hole, strange_logs.GYRO)
    gaps = opened(tmp_path / "dt.csv", text, "--gyro-unit rad/s").record.gaps()
    assert [g.missing for g in gaps] == [5]


def test_the_newest_row_first(tmp_path):
    back, clock = slice(None, None, -1), strange_logs.clock((10, 0, 0))
    for stamp in (strange_logs.T[back], clock[back], [f"2026-03-14 {c}" for c in clock[back]]):
        text = _rows("time,gx,gy,gz", stamp, strange_logs.GYRO[back])
        found = opened(tmp_path / "back.csv", text, "--gyro-unit rad/s")
        assert any("newest row" in note for note in same(found, 100).notes)


def test_one_name_over_a_date_and_a_clock(tmp_path):
    for head in ("Chip Time()", "Date/Time", "timestamp"):
        head = "\t".join([head, "gx(rad/s)", "gy(rad/s)", "gz(rad/s)"])
        day = ["2026-03-14"] * strange_logs.N
        text = strange_logs.table(
            head, day, strange_logs.clock((10, 0, 0)), strange_logs.GYRO, sep="\t"
        )
        same(opened(tmp_path / "chip.txt", text, ""), 100)


def test_ticks_of_a_stated_length(tmp_path):
    text = _rows("time (25us ticks),gx,gy,gz", strange_logs.I * 400, strange_logs.GYRO)
    with pytest.raises(InputError, match="--time-unit ticks:40000") as error:
        opened(tmp_path / "ticks.csv", text, "--gyro-unit rad/s")
    answer = re.search(r"--time-unit ticks:\d+", str(error.value))[0]
    same(opened(tmp_path / "ticks.csv", text, f"--gyro-unit rad/s {answer}"), 100)


@pytest.mark.parametrize("column, flags", [("time_s", ""), ("", "--rate 30000")])
def test_a_rate_that_no_sensor_has_is_said(tmp_path, column, flags):
    stamp = [strange_logs.T / 300] if column else []
    head = ",".join([*([column] if column else []), "gx", "gy", "gz"])
    text = _rows(head, *stamp, strange_logs.GYRO)
    found = opened(tmp_path / "fast.csv", text, f"--gyro-unit rad/s {flags}")
    assert any("unusual for" in note for note in found.record.notes)


@pytest.mark.parametrize("names", ["left_{c} right_{c}", "{c}_A {c}_B", "Wrist {c} Thigh {c}"])
def test_sensors_named_by_their_place_are_asked_for(tmp_path, names):
    one, two = (n.strip() for n in re.match(r"(.*?\S) ?(right.*|\S+_B|Thigh.*)$", names).groups())
    pick = [one.format(c=f"g{a}") for a in "xyz"] + [two.format(c=f"g{a}") for a in "xyz"]
    pick += [one.format(c=f"a{a}") for a in "xyz"]
    _asked_and_answered(tmp_path, pick, "would be accel_x|would be gyro_x")


def test_rows_by_sensor_of_two_devices_are_asked_for(tmp_path):
    n = strange_logs.N
    both = np.stack(
        [strange_logs.ACCEL, strange_logs.GYRO, strange_logs.ACCEL, strange_logs.GYRO + 1], 1
    )
    text = _rows(
        "time_s,dev,type,x,y,z", np.repeat(strange_logs.T, 4), list("aabb") * n, ["acc", "gyr"] * 2 * n,
        both.reshape(-1, 3),
    )  # fmt: skip
    with pytest.raises(InputError, match="--topic 'dev=a'"):
        opened(tmp_path / "long.csv", text, strange_logs.SI)
    same(opened(tmp_path / "long.csv", text, f"{strange_logs.SI} --topic dev=a"), 100)


@pytest.mark.parametrize("sign", ["-", "neg_", "minus "])
def test_a_turned_sign_is_asked_for(tmp_path, sign):
    text = _rows(f"time_s,gx,{sign}gy,gz", strange_logs.T, strange_logs.GYRO)
    with pytest.raises(InputError, match="sign is turned") as error:
        opened(tmp_path / "turned.csv", text, "--gyro-unit rad/s")
    answer = re.search(r"--columns '[^']+'", str(error.value))[0]
    same(opened(tmp_path / "turned.csv", text, f"--gyro-unit rad/s {answer}"), 100)


def test_what_stands_beside_the_readings_is_left_out(tmp_path):
    """Commands, angular accelerations, an accuracy of a receiver, a counter of three bits."""
    more = "roll_rate_cmd,pitch_rate_cmd,angular_acc_x,vert_acc,horiz_acc,index"
    text = _rows(
        f"time_s,gx,gy,gz,{more}", strange_logs.T, strange_logs.GYRO, *[strange_logs.T * 0 + 5] * 5, strange_logs.I % 8
    )  # fmt: skip
    found = same(opened(tmp_path / "beside.csv", text, "--gyro-unit rad/s"), 100)
    assert found.channel_names == ("gyro_x", "gyro_y", "gyro_z")
