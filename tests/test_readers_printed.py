"""Printed messages, wristbands, cameras and data sets: what opens is right, the rest is asked about."""

import re

import numpy as np
import printed_logs
import pytest
from strange_logs import GYRO, I, T, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError

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
