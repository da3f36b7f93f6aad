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
