"""Printed messages, wristbands, cameras and data sets: what opens is right, the rest is asked about."""

import re

import numpy as np
import printed_logs
import pytest
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, T, clock, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError
from imu_lib.readers import calendar

LOGS, ASKING = printed_logs.logs(), printed_logs.asking()


@pytest.mark.parametrize("name", LOGS)
def test_opens_and_is_right(tmp_path, name):
    content, flags, rate = LOGS[name]
    record = same(opened(tmp_path / name, content, flags), rate)
    assert len(record.channel_names) == (3 if name == "camera.csv" else 6)


@pytest.mark.parametrize("name", ASKING)
def test_asks_and_opens_with_the_answer(tmp_path, name):
    content, flags, said, answer, rate = ASKING[name]
    with pytest.raises(InputError, match=re.escape(said)):
        opened(tmp_path / name, content, flags)
    if rate:
        same(opened(tmp_path / name, content, f"{flags} {answer}"), rate)


def test_rows_of_a_sensor_that_nothing_names_are_read_one_at_a_time(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(ASKING["untold.csv"][0])
    found = readers.read(gyro=path, gyro_unit="rad/s", topic="sensor_id=4")
    assert np.allclose(found.record["gyro"], GYRO, rtol=1e-6) and found.record.rate == 100


def test_the_columns_to_paste_take_the_stamp_that_moves_with_the_rows(tmp_path):
    """A receiver's second beside the sensor's own stamps is no time of every row."""
    heads = "locationTimestamp(s),gyroTimestamp(s)," + ",".join(f"{n}_{a}" for n in ("imu1_gyro", "imu2_gyro") for a in "xyz")  # fmt: skip
    text = table(heads, 1.7e9 + I // 100, T + 5.5, GYRO, GYRO + 0.1)
    with pytest.raises(InputError, match="--columns '-,time") as error:
        opened(tmp_path / "a.csv", text, "")
    named = re.search(r"--columns '([^']+)'", str(error.value))[1]
    same(opened(tmp_path / "a.csv", text, f"--gyro-unit rad/s --columns {named}"), 100)


def test_axes_that_state_units_of_their_own_are_read_in_them(tmp_path):
    heads = "time [s],gx [rad/s],gy [deg/s],gz [mdps],ax [m/s^2],ay [g],az [mg]"
    columns = [GYRO[:, 0], DPS[:, 1], DPS[:, 2] * 1e3, ACCEL[:, 0], IN_G[:, 1], IN_G[:, 2] * 1e3]
    text = table(heads, T, *columns)
    found = opened(tmp_path / "a.csv", text, "")
    assert len(same(found, 100).channel_names) == 6
    assert sum("each was read in its own" in n for n in found.record.notes) == 2


def test_one_axis_in_g_among_two_in_si_is_refused(tmp_path):
    """The sensor stands tilted, so that one axis holds much of gravity."""
    tilted = np.c_[ACCEL[:, 0] + 6.0, ACCEL[:, 1], ACCEL[:, 2] * 0.79]
    tilted[:, 0] /= 9.80665
    text = table("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", T, tilted)
    with pytest.raises(InputError, match="with its x axis in g it would be gravity"):
        opened(tmp_path / "a.csv", text, "")


def test_two_refusals_are_told_at_once(tmp_path):
    text = table("time [s],gx [deg/s],gy [deg/s],gz [deg/s],ax [g],ay [g],az [g]", T, GYRO * 40, ACCEL)  # fmt: skip
    with pytest.raises(InputError) as error:
        opened(tmp_path / "a.csv", text, "")
    assert "--accel-unit m/s^2" in str(error.value)
    text = table("time [s],gx [rad/s],gy [rad/s],gz [rad/s],ax [g],ay [g],az [g]", T, DPS, ACCEL)
    with pytest.raises(InputError, match="--accel-unit m/s.2.*--gyro-unit deg/s"):
        opened(tmp_path / "a.csv", text, "")


def test_copies_without_stamps_are_said(tmp_path):
    rows = np.sort(np.r_[I, I[::4]])
    text = table("gx,gy,gz,ax,ay,az", GYRO[rows], ACCEL[rows])
    notes = opened(tmp_path / "a.csv", text, f"{SI} --rate 100").record.notes
    assert any("repeat the row before in every channel" in n for n in notes)
    notes = opened(tmp_path / "a.csv", table("gx,gy,gz,ax,ay,az", GYRO, ACCEL), f"{SI} --rate 100").record.notes  # fmt: skip
    assert not any("repeat the row" in n for n in notes)


def test_values_along_x_y_z_are_no_abscissa(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(table("Time,  X_value, Y_value, Z_value", T, ACCEL))
    found = readers.read(accel=path, accel_unit="m/s^2")
    assert len(same(found, 100).channel_names) == 3
    with pytest.raises(InputError, match="time,accel_x,accel_y,accel_z"):
        readers.read(path)


def test_which_sensor_and_its_units_are_asked_for_at_once(tmp_path):
    text = "time_s,device,gx,gy,gz\n" + "".join(
        f"{k / 100},{d},{GYRO[k, 0]},0.1,0.2\n" for k in I for d in ("left", "right")
    )
    with pytest.raises(InputError, match="--topic 'device=left'.*--gyro-unit"):
        opened(tmp_path / "a.csv", text, "")


def test_lists_and_texts_of_a_parquet_file(tmp_path):
    import pandas as pd

    frame = pd.DataFrame({"time": printed_logs.CLOCK, "gyro": list(map(list, GYRO)), "accel": list(map(list, ACCEL))})  # fmt: skip
    frame.to_parquet(tmp_path / "a.parquet")
    found = readers.read(tmp_path / "a.parquet", gyro_unit="rad/s", accel_unit="m/s^2")
    assert len(same(found, 100).channel_names) == 6


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%f"])
def test_moments_written_alike_are_the_same_by_either_way(tmp_path, monkeypatch, form):
    """Over midnight and the end of February: all at once, and one by one."""
    stamps = clock((23, 59, 58), form=form)
    text = table("time,gx,gy,gz", stamps, GYRO)
    quick = opened(tmp_path / "a.csv", text, "--gyro-unit rad/s").record
    monkeypatch.setattr(calendar, "_plain", lambda date: None)
    slow = opened(tmp_path / "a.csv", text, "--gyro-unit rad/s").record
    assert quick.rate == slow.rate and (quick.times() == slow.times()).all()
    assert same(opened(tmp_path / "a.csv", text, "--gyro-unit rad/s"), 100) is not None


@pytest.mark.parametrize(
    ("encoding", "heads"),
    [
        ("gb18030", "时间(s),加速度{}(g),角速度{}(°/s)"),
        ("big5", "時間(s),加速度{}(g),角速度{}(deg/s)"),
        ("cp932", "時間(s),加速度{}(g),角速度{}(deg/s)"),
        ("cp949", "시간(s),가속도{}(g),각속도{}(deg/s)"),
        ("cp1251", "Время с,Ускорение {} (g),Угл. скорость {} (°/с)"),
        ("koi8_r", "Время с,Ускорение {} (g),Угловая скорость {} (град/с)"),
        ("latin-1", "Zeit (s),Beschleunigung {} (g),Gyro {} (°/s)"),
    ],
)
def test_the_encoding_is_that_in_which_the_words_are_known(tmp_path, encoding, heads):
    time, accel, gyro = heads.split(",")
    named = ",".join([time, *(h.format(a) for h in (accel, gyro) for a in "XYZ")])
    path = tmp_path / "a.csv"
    path.write_bytes(table(named, T, IN_G, DPS).encode(encoding))
    assert len(same(readers.read(path), 100).channel_names) == 6


def test_a_remedy_that_leaves_columns_out_says_so(tmp_path):
    text = table("stand(s),ax (g),ay (g),az (g),foo1,foo2,foo3", T, IN_G, DPS)
    with pytest.raises(InputError, match="--columns.*leaves out `foo1`, `foo2`, `foo3`"):
        opened(tmp_path / "a.csv", text, "")


def test_whole_microseconds_lose_no_decimals(tmp_path):
    micros = I * 10_000
    micros[5:30:9] += 40  # a clock that is late now and then, and never in the last quarter
    found = opened(tmp_path / "a.csv", table("micros,gx_dps,gy_dps,gz_dps", micros, DPS), "")
    assert not any("lose decimals" in n for n in found.record.notes)


def test_three_columns_that_nothing_names_may_be_either_sensor(tmp_path):
    with pytest.raises(
        InputError, match="time,gyro_x.*or time,accel_x,accel_y,accel_z with --accel"
    ):
        opened(tmp_path / "a.csv", table("millis,adc_x,adc_y,adc_z", I * 10, GYRO), "")


def test_units_behind_a_heading(tmp_path):
    text = table("t_s,wx_degph,wy_degph,wz_degph,fx_mps2,fy_mps2,fz_mps2", T, DPS * 3600, ACCEL)
    assert len(same(opened(tmp_path / "a.csv", text, ""), 100).channel_names) == 6
    text = table("t_s,wx_rps,wy_rps,wz_rps", T, GYRO)
    with pytest.raises(InputError, match="--gyro-unit rad/s or --gyro-unit rev/s"):
        opened(tmp_path / "a.csv", text, "")
    same(opened(tmp_path / "a.csv", text, "--gyro-unit rad/s"), 100)


def test_a_sensor_that_may_be_left_out_is_warned_of(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(table("t_s,foo1,foo2,foo3,ax_mps2,ay_mps2,az_mps2", T, GYRO, ACCEL))
    with pytest.warns(UserWarning, match="no column was read as the gyro; `foo1`"):
        readers.read_record(path)


@pytest.mark.parametrize("form", ["1.001,25", "1,001.25", "1'001.25"])
def test_marks_between_thousands_are_left_out(tmp_path, form):
    thousands, decimal = form[1], form[5]
    swap = str.maketrans({",": thousands, ".": decimal})
    rows = [";".join(f"{v:,.4f}".translate(swap) for v in (10.0 * k, *(1e3 * IN_G[k]))) for k in I]
    text = "\n".join(["Zeit [ms];ax [mg];ay [mg];az [mg]", *rows]) + "\n"
    found = opened(tmp_path / "a.csv", text, "")
    assert len(same(found, 100).channel_names) == 3
    assert any("thousands" in n for n in found.record.notes)


def test_neighbours_that_changed_places_are_put_back(tmp_path):
    rows = I.copy()
    for k in (20, 50, 51, 90):
        rows[[k, k + 1]] = rows[[k + 1, k]]
    text = table("t_s,gx_dps,gy_dps,gz_dps", T[rows], DPS[rows])
    found = opened(tmp_path / "a.csv", text, "")
    assert same(found, 100) is not None
    assert any("put back by their stamps" in n for n in found.record.notes)
