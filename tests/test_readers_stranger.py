"""Logs of further kinds: each opens with its flags and gives the sensor's signal, or says why not."""

import re

import numpy as np
import pytest
import stranger_logs
from strange_logs import ACCEL, DEG, GYRO, SI, G, I, T, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError

LOGS, TIMES = stranger_logs.logs(), stranger_logs.times()


@pytest.mark.parametrize("name", LOGS)
def test_opens_and_is_right(tmp_path, name):
    content, flags, rate = LOGS[name]
    found = opened(tmp_path / name, content, flags)
    if name == "no_reading.csv":
        assert int(found.record.missing().sum()) == 5
        assert any("-999" in n for n in found.record.notes)
        return
    record = same(found, rate)
    assert len(record.channel_names) == 6


@pytest.mark.parametrize("head", TIMES)
def test_reads_the_stamps(tmp_path, head):
    stamps, rate, flags = TIMES[head]
    text = table(f"{head},{stranger_logs.SIX}", stamps, GYRO, ACCEL)
    same(opened(tmp_path / "a.csv", text, f"{SI} {flags}"), rate)


def test_text_that_is_no_time_is_named(tmp_path):
    text = table(f"time,{stranger_logs.SIX}", ["soon"] * len(I), GYRO, ACCEL)
    with pytest.raises(InputError, match=r"`time` holds text.*--rate"):
        opened(tmp_path / "a.csv", text, SI)


def test_stamps_that_are_none_are_left_out_by_a_flag(tmp_path):
    """The remedy for stamps that fall, repeat or are no numbers."""
    fall = np.where(I % 50 == 30, T - 0.2, T)
    for stamp in (fall, np.where(I > 200, np.nan, T)):
        text = table(f"time,{stranger_logs.SIX}", stamp, GYRO, ACCEL)
        with pytest.raises(InputError, match="--time-unit none --rate HZ"):
            opened(tmp_path / "a.csv", text, SI)
        same(opened(tmp_path / "a.csv", text, f"{SI} --time-unit none --rate 100"), 100)


@pytest.mark.parametrize("kind", ("gyro", "accel"))
def test_bare_axes_are_of_the_one_sensor_with_a_unit(tmp_path, kind):
    data = GYRO if kind == "gyro" else ACCEL
    flags = "--gyro-unit rad/s" if kind == "gyro" else "--accel-unit m/s^2"
    for head, columns in (("time,z,y,x", data[:, ::-1]), ("", data)):
        found = opened(tmp_path / "a.csv", table(head, T, columns), flags)
        assert np.allclose(found.record[kind], data, rtol=1e-6)
        assert any(f"--{kind}-unit" in n for n in found.record.notes)


def test_the_names_to_paste_keep_the_letters_of_the_columns(tmp_path):
    text = table("time,seconds_elapsed,z,y,x", 16 * 10**17 + I * 10**7, T, GYRO[:, ::-1])
    with pytest.raises(InputError, match="--columns") as error:
        opened(tmp_path / "a.csv", text, "")
    names = re.search(r"as in ((?:[a-z_]+|-)(?:,(?:[a-z_]+|-))+)", str(error.value))[1]
    found = opened(tmp_path / "a.csv", text, f"--columns {names} --gyro-unit rad/s")
    assert np.allclose(found.record["gyro"], GYRO, rtol=1e-6)


def test_an_accelerometer_without_gravity_is_said(tmp_path):
    for offset in (0.0, 0.1):
        free = ACCEL - ACCEL.mean(axis=0) + offset
        head = "time,rotationRateX,rotationRateY,rotationRateZ,userAccelerationX,userAccelerationY,userAccelerationZ"
        found = opened(tmp_path / "a.csv", table(head, T, GYRO, free), SI)
        assert any("no gravity" in n for n in found.record.notes)
        assert len(found.record.channel_names) == 6


def test_what_was_not_taken_is_said(tmp_path):
    content, flags, _ = LOGS["unfiltered_beside.csv"]
    notes = opened(tmp_path / "a.csv", content, flags).record.notes
    assert any("`gyroADC[0]` was taken as the gyro" in n for n in notes)
    text = table("time,gx,gy,gz,foo_1,foo_2,bar", T, GYRO, ACCEL)
    notes = opened(tmp_path / "a.csv", text, "--gyro-unit rad/s").record.notes
    assert any("No column was read as the accelerometer" in n and "`foo_1`" in n for n in notes)


def test_both_scales_are_asked_for_at_once(tmp_path):
    counts = [np.rint(x).astype(int) for x in (GYRO * DEG * 1e4, ACCEL / G * 16384)]
    head = "time [s],gx [lsb],gy [lsb],gz [lsb],ax [lsb],ay [lsb],az [lsb]"
    text = table(head, T, *counts)
    with pytest.raises(InputError, match=r"--gyro-unit counts:C.*--accel-unit counts:C"):
        opened(tmp_path / "a.csv", text, "")


@pytest.mark.parametrize(
    "text, said",
    (
        ("%RAWIMUSA,2200,345600.000;2200,345600.0,00000077,-1,2,3,4,5,6*00000000\n" * 9, "scale"),
        (
            "#INSPVAXA,COM1,0,73.5,FINE,1695,309428.0,0,4e77,1;GOOD,PSRSP,51*0\n" * 9,
            "none of an IMU",
        ),
    ),
)
def test_sentences_without_a_scale_are_refused(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        opened(tmp_path / "a.txt", text, SI)


def test_a_drive_in_a_folder_of_rows(tmp_path):
    (tmp_path / "data").mkdir()
    seconds = [f"2011-09-26 13:02:{5 + k / 100:012.9f}\n" for k in range(60)]
    (tmp_path / "timestamps.txt").write_text("".join(seconds))
    for k in range(60):
        row = np.r_[np.zeros(11), ACCEL[k], np.zeros(3), GYRO[k], np.zeros(10)]
        (tmp_path / "data" / f"{k:010d}.txt").write_text(" ".join(f"{v:.9g}" for v in row))
    record = readers.read_record(tmp_path)
    assert record.rate == pytest.approx(100)
    assert np.allclose(record["gyro"], GYRO[:60]) and np.allclose(record["accel"], ACCEL[:60])
    (tmp_path / "data" / "0000000003.txt").unlink()
    with pytest.raises(InputError, match="60 stamps and 59 rows"):
        readers.read_record(tmp_path)


def test_a_range_in_a_heading_is_no_scale(tmp_path):
    head = "time [s],gx (500 dps),gy (500 dps),gz (500 dps)"
    text = table(head, T, GYRO * DEG)
    with pytest.raises(InputError, match="--gyro-unit deg/s if that is the range"):
        opened(tmp_path / "a.csv", text, "")
    same(opened(tmp_path / "a.csv", text, "--gyro-unit deg/s"), 100)


def test_names_that_their_units_contradict_are_asked_about(tmp_path):
    text = table("t [s],acc_x [deg/s],acc_y [deg/s],acc_z [deg/s]", T, GYRO * DEG)
    with pytest.raises(InputError, match="a unit of the other; say what each column is"):
        opened(tmp_path / "a.csv", text, "")
    flags = "--columns time[s],gyro_x[deg/s],gyro_y[deg/s],gyro_z[deg/s]"
    same(opened(tmp_path / "a.csv", text, flags), 100)
