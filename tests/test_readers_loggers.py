"""Clocks, units and headers that mislead: each log opens with its flags, or the call that it asks for works."""

import re

import logger_files
import numpy as np
import pytest
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, table
from stranger_logs import SIX
from test_readers_kinds import opened, same

from imu_lib.errors import InputError
from imu_lib.readers import names, slips

CLOCKS, LOGS = logger_files.clocks(), logger_files.logs()


@pytest.mark.parametrize("kind", CLOCKS)
def test_no_clock_invents_a_rate_or_a_gap(tmp_path, kind):
    head, stamps, rate, lost = CLOCKS[kind]
    text = table(f"{head},{SIX}", stamps, GYRO, ACCEL)
    record = opened(tmp_path / "a.csv", text, SI).record
    assert record.rate == pytest.approx(rate, rel=3e-3)
    assert sum(g.missing for g in record.gaps()) == lost
    assert np.allclose(record["gyro"], GYRO, rtol=1e-6)
    assert np.allclose(record["accel"], ACCEL, rtol=1e-6)


@pytest.mark.parametrize("name", LOGS)
def test_opens_and_is_right(tmp_path, name):
    content, flags, rate = LOGS[name]
    assert len(same(opened(tmp_path / name, content, flags), rate).channel_names) == 6


def test_rows_that_hold_start_and_rate(tmp_path):
    content, flags, rate = logger_files.wristband()
    record = opened(tmp_path / "ACC.csv", content, flags).record
    assert record.rate == rate and record.n == N
    assert np.allclose(record["accel"], ACCEL, rtol=1e-6)


def test_even_losses_without_a_clock_that_explains_them_stay_gaps(tmp_path):
    """Every eighth row lost at 200 Hz: no tick of a computer's clock, no two rows with one stamp."""
    kept = np.flatnonzero(np.arange(2 * N) % 8)[:N]
    record = opened(tmp_path / "a.csv", table(f"t_s,{SIX}", kept / 200, GYRO, ACCEL), SI).record
    assert record.rate == pytest.approx(200) and len(record.gaps()) > 50


def test_a_rate_in_a_line_of_words_does_not_overrule_stamps(tmp_path):
    for line in ("# sampled at 500 Hz", "# low pass at 42 Hz"):
        text = f"{line}\n" + table(f"time [s],{SIX}", T, GYRO, ACCEL)
        same(opened(tmp_path / "a.csv", text, SI), 100)
    with pytest.raises(InputError, match="--rate HZ"):
        opened(tmp_path / "a.csv", "# low pass at 42 Hz\n" + table(SIX, GYRO, ACCEL), SI)


def test_scaled_units_are_asked_for_at_once(tmp_path):
    for words in (("deg/s*100", "g*1000"), ("deg/s x100", "g x1000")):
        head = "time [s]," + ",".join(f"{n} [{words[n[0] == 'a']}]" for n in SIX.split(","))
        text = table(head, T, DPS * 100, IN_G * 1000)
        with pytest.raises(InputError) as error:
            opened(tmp_path / "a.csv", text, "")
        flags = " ".join(re.findall(r"--(?:gyro|accel)-unit counts:\d+", str(error.value)))
        same(opened(tmp_path / "a.csv", text, flags), 100)
    text = table("t_s,gx_dps_x100,gy_dps_x100,gz_dps_x100", T, DPS * 100)
    with pytest.raises(InputError, match="--gyro-unit counts:100"):
        opened(tmp_path / "a.csv", text, "")


def test_counts_that_have_no_sign_are_left_alone(tmp_path):
    counts = np.rint(DPS * 1000 + 32_768).astype(int)  # zero in the middle of the range
    text = table("time,gx,gy,gz", T, counts)
    same(opened(tmp_path / "a.csv", text, "--gyro-unit counts:1000:32768"), 100)


def test_a_unit_says_that_there_is_no_sign_to_give(tmp_path):
    """A rate table at 60 deg/s in thousandths of a degree, all axes above 0."""
    turning = np.rint(DPS * 1000) + [2000, 4000, 60_000]
    text = table("time [s],gx [mdps],gy [mdps],gz [mdps]", T, turning.astype(int))
    record = opened(tmp_path / "a.csv", text, "--trust-units").record
    assert record["gyro_z"].mean() == pytest.approx(np.radians(60), rel=0.02)


def test_a_column_that_rises_is_offered_as_the_time(tmp_path):
    text = table(f"moment_of_it,{SIX}", T + 4, GYRO, ACCEL)
    with pytest.raises(InputError, match="`moment_of_it` rises as a time does") as error:
        opened(tmp_path / "a.csv", text, SI)
    named = re.search(r"--columns '([^']+)'", str(error.value))[1]
    same(opened(tmp_path / "a.csv", text, f"{SI} --columns {named}"), 100)


def test_g_of_x_may_be_a_force(tmp_path):
    text = table("Time [s],G(x),G(y),G(z)", T, IN_G)
    with pytest.raises(InputError, match="gravity in g") as error:
        opened(tmp_path / "a.csv", text, "")
    named = re.search(r"--columns '([^']+)'", str(error.value))[1]
    same(opened(tmp_path / "a.csv", text, f"--columns '{named}'"), 100)
    same(opened(tmp_path / "a.csv", table("Time [s],G(x),G(y),G(z)", T, DPS), "--gyro-unit deg/s"), 100)  # fmt: skip


def test_another_header_in_the_middle_is_said(tmp_path):
    text = table("time,gx,gy,gz", T, GYRO) + table("time,gz,gy,gx", T + 9, GYRO)
    with pytest.raises(InputError, match=f"line {N + 2}: another header"):
        opened(tmp_path / "a.csv", text, "--gyro-unit rad/s")


def test_words_with_a_slip_of_the_pen():
    for word in ("acelerometer", "accelarometer", "gyroscpoe", "tempreature", "timestmap"):
        assert slips.misspelled(word) in slips.WORDS
    for word in ("acceleration", "accelerations", "gyrocompass", "velocities", "tachometer"):
        assert slips.misspelled(word) in (None, "acceleration")
    assert names.meaning("Acelerometer X [g]").canonical == "accel_x"


def test_frames_of_no_usual_number_are_asked_about(tmp_path):
    stamps = [f"10:59:{k // 17:02d}:{k % 17:02d}" for k in I]
    text = table(f"tc,{SIX}", stamps, GYRO, ACCEL)
    with pytest.raises(InputError, match="--time-unit none --rate HZ"):
        opened(tmp_path / "a.csv", text, SI)
    same(opened(tmp_path / "a.csv", text, f"{SI} --time-unit none --rate 17"), 17)


def test_a_plural_is_no_unit():
    for heading in ("timestamps", "Timestamps", "times"):
        assert names.meaning(heading).canonical == "time" and names.meaning(heading).unit is None
    assert names.meaning("timestampms").unit == "ms" and names.meaning("ts").unit is None


def test_any_words_make_a_meaning():
    for heading in ("hour_s", "h rs", "hh", "minute s", "utc hours", "h_s x"):
        assert names.meaning(heading).quantity in (None, "part", "time", "counter")


@pytest.mark.parametrize(
    ("header", "values", "fits"),
    [
        ("deg/s", DPS * 1000, ("mdps", "deg/h")),
        ("rad/s", DPS, ("deg/s",)),
        ("deg/s", DPS * 3600, ("deg/h", "mdps")),
    ],
)
def test_every_unit_that_fits_is_offered_where_the_stated_one_cannot_be(tmp_path, header, values, fits):  # fmt: skip
    text = table(f"time [s],gx [{header}],gy [{header}],gz [{header}],ax [g],ay [g],az [g]", T, values, IN_G)  # fmt: skip
    with pytest.raises(InputError) as error:
        opened(tmp_path / "a.csv", text, "")
    offered = re.findall(r"--gyro-unit (\S+?),? ", str(error.value))
    assert set(fits) <= set(offered) - {"or"} and header not in offered
    for unit in offered:
        if unit != "or":
            assert not any("unit" in n for n in opened(tmp_path / "a.csv", text, f"--gyro-unit {unit}").record.notes if "states" not in n)  # fmt: skip


def test_mg_and_gal_are_both_offered(tmp_path):
    text = table("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", T, IN_G * 1000)
    with pytest.raises(InputError, match="--accel-unit mg or --accel-unit cm/s") as error:
        opened(tmp_path / "a.csv", text, "")
    assert "--accel-unit g" not in str(error.value)


@pytest.mark.parametrize(
    ("worked_on", "own"),
    [
        ("motionRotationRate{} [rad/s]", "gyroRotation{} [rad/s]"),
        ("fused_gyro_{} [rad/s]", "gyro_{} [rad/s]"),
        ("gyro_calibrated_{} [rad/s]", "gyro_{} [rad/s]"),
    ],
)
def test_the_example_names_the_sensor_s_own_reading(tmp_path, worked_on, own):
    heads = ",".join(h.format(a) for h in (worked_on, own) for a in "XYZ")
    text = table(f"time [s],{heads}", T, GYRO - GYRO.mean(axis=0), GYRO)
    with pytest.raises(InputError, match="say which is meant") as error:
        opened(tmp_path / "a.csv", text, "")
    named = re.search(r"--columns '([^']+)'", str(error.value))[1]
    record = opened(tmp_path / "a.csv", text, f"--columns '{named}'").record
    assert np.allclose(record["gyro"], GYRO, atol=1e-8)


@pytest.mark.parametrize("frame", ["ENU", "ned", ("east", "north", "up")])
def test_points_of_the_compass_are_axes(tmp_path, frame):
    order = [[p[0].lower() for p in frame].index(a) for a in ("enu" if "u" in str(frame).lower() else "ned")]  # fmt: skip
    heads = [f"gyro_{p}_dps" for p in frame] + [f"acc_{p}_g" for p in frame]
    found = opened(tmp_path / "a.csv", table("time_s," + ",".join(heads), T, DPS, IN_G), "")
    assert np.allclose(found.record["gyro"], GYRO[:, order], rtol=1e-6)
    assert np.allclose(found.record["accel"], ACCEL[:, order], rtol=1e-6)


def test_an_example_names_a_signal_or_is_not_printed(tmp_path):
    heads = "time_s," + ",".join(f"{s}_{p}" for s in ("acc", "gyro") for p in ("k", "l", "m"))
    with pytest.raises(InputError) as error:
        opened(tmp_path / "a.csv", table(heads, T, ACCEL, GYRO), SI)
    named = re.search(r"as in (\S+) with --gyro-unit", str(error.value))[1]
    same(opened(tmp_path / "a.csv", table(heads, T, ACCEL, GYRO), f"{SI} --columns {named}"), 100)
    with pytest.raises(InputError, match="give the file with the readings"):
        opened(tmp_path / "b.csv", table("time_s,temperature", T, T * 0 + 20.5), "")


def test_three_columns_with_gravity_are_offered_as_an_accelerometer(tmp_path):
    text = table("time,seconds_elapsed,z,y,x", 16 * 10**17 + I * 10**7, T, ACCEL[:, ::-1])
    with pytest.raises(InputError, match="as in time,-,accel_z,accel_y,accel_x"):
        opened(tmp_path / "a.csv", text, "")


def test_commas_that_are_decimal_marks_and_delimiters(tmp_path):
    heads = "t [s],wx [dps],wy [dps],wz [dps],ax [g],ay [g],az [g]"
    rows = table("", T, DPS, IN_G, form="%.7f").replace(".", ",")
    rows = re.sub(r"(?m)^(\d),", r"\1,", rows)
    text = heads + "\n" + rows
    found = opened(tmp_path / "a.csv", text, "")
    assert found.record.rate == pytest.approx(100)
    assert np.allclose(found.record["gyro"], GYRO, atol=1e-6)
    assert any("decimal marks" in n for n in found.record.notes)


def test_names_of_a_sketch(tmp_path):
    heads = "t [s],AcX [g],AcY [g],AcZ [g],GyX [dps],GyY [dps],GyZ [dps]"
    same(opened(tmp_path / "a.csv", table(heads, T, IN_G, DPS), ""), 100)
