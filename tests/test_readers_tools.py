"""Logs as widely used tools and sketches write them: each opens with its flags and is right."""

import pickle

import pytest
import tool_logs
from strange_logs import ACCEL, GYRO, SI, I, T, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError
from imu_lib.readers import names

LOGS = tool_logs.texts()


@pytest.mark.parametrize("name", LOGS)
def test_opens_and_is_right(tmp_path, name):
    content, flags, rate = LOGS[name]
    record = same(opened(tmp_path / name, content, flags), rate)
    one = {
        n: 3 for n in ("rotation.txt", "marks.txt", "serial_numbers.csv", "user_beside.csv")
    }.get(name, 6)
    assert len(record.channel_names) == one
    assert not any("lose decimals" in n for n in record.notes)


def test_files_of_arrays_open(tmp_path):
    for path, flags, rate in tool_logs.binaries(tmp_path):
        if path.name == "three.npy":  # one matrix of one sensor
            found = readers.read(accel=path, accel_unit="m/s^2", rate=100)
            assert (found.record["accel"] == ACCEL).all()
            continue
        record = same(opened(path, path.read_bytes(), flags), rate)
        assert len(record.channel_names) == 6, path.name


@pytest.mark.parametrize(
    "heading",
    "gyroAngleX accAngleX acc_angle_x_deg ang_acc_x gyro_err_x gyro_residual_x gyro_x_valid acc_x_saturated gyro_noise_x sf_gx "
    "gyro_scale_x accel_scale_x gyro_rms_x acc_x_diff gps_accel_x".split(),  # fmt: skip
)
def test_what_only_sounds_like_a_reading_is_none(heading):
    assert names.meaning(heading).quantity is None
    # nor is it taken where nothing else is that axis
    read = [h for h in ("gx", "gy", "gz") if not heading.lower().endswith(("gx", "g_x"))]
    assert all(names.meaning(h).quantity == "gyro" for h in read)


def test_what_stands_between_the_rows_is_said(tmp_path):
    content, flags, _ = LOGS["complaints.csv"]
    notes = opened(tmp_path / "a.csv", content, flags).record.notes
    assert any("of words between the rows" in n and "line 7" in n for n in notes)


def test_a_hole_between_whole_seconds_and_their_milliseconds(tmp_path):
    """The clock's seconds are the time beside its milliseconds, which alone would close a hole."""
    ms = I * 10 + 250 + 3010 * (I >= 200)
    clocks = [f"2026/03/14,10:21:{33 + m // 1000:02d}" for m in ms]
    text = table("Date,Time,Millis,gx,gy,gz,ax,ay,az", clocks, ms % 1000, GYRO, ACCEL)
    (gap,) = opened(tmp_path / "a.csv", text, SI).record.gaps()
    assert gap.duration == pytest.approx(3.02)


def test_a_temperature_called_t_of_the_sensor(tmp_path):
    text = table("time,gx,gy,gz,ax,ay,az,T_imu", T, GYRO, ACCEL, 24.5 + 0.1 * (I % 3))
    record = opened(tmp_path / "a.csv", text, SI).record
    assert record.temperature.mean() == pytest.approx(24.6, abs=0.01)
    rising = table("T_imu,gx,gy,gz,ax,ay,az", T, GYRO, ACCEL)
    assert opened(tmp_path / "a.csv", rising, SI).record.rate == pytest.approx(100)


def test_the_columns_to_name_have_a_time_that_moves(tmp_path):
    """The remedy for two gyros leaves out a stamp that stands still."""
    head = "fix_timestamp(s),time(s),gyro_x,gyro_y,gyro_z,w_x,w_y,w_z"
    path = tmp_path / "a.csv"
    path.write_text(table(head, T * 0 + 1e9, T, GYRO, GYRO + 1))
    with pytest.raises(InputError, match="--columns '-,time") as error:
        readers.read(path, gyro_unit="rad/s")
    columns = str(error.value).split("--columns '")[1].split("'")[0]
    assert readers.read(path, gyro_unit="rad/s", columns=columns).record.rate == pytest.approx(100)


def test_what_cannot_be_opened_says_what_it_is(tmp_path):
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({"gyro": GYRO}))
    with pytest.raises(InputError, match="pickle"):
        readers.read(path)
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{k * 10},{k % 3},0.1,0.2,9.8\n" for k in I))
    with pytest.raises(InputError, match="0, 1, 2 by turns"):
        readers.read(path)
    path.write_text("".join(" ".join(map(str, row)) + "\n" for row in ACCEL.round(4)) * 2)
    with pytest.raises(InputError, match="--rate HZ"):
        readers.read(path)
