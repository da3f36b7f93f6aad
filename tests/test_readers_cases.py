"""One standing sensor in forty dresses: each file opens with its flags, or asks for what is named,
and gives the signal at its rate. The folder stands beside the records of IMU_LIB_DATA.
"""

import json
import re
import shlex

import numpy as np
import pytest

from imu_lib import readers
from imu_lib.cli import common
from imu_lib.cli.main import joined, parser
from imu_lib.errors import InputError

GYRO = np.array([0.010, -0.020, 0.005])  # rad/s
ACCEL = np.array([0.05, -0.11, -9.81])  # m/s^2, signs turned where the axes point up
UP = ("phystool.csv", "androsensor.csv", "st_mems.csv", "i2cdevlib.txt", "kv.txt")
SI = "--gyro-unit rad/s --accel-unit m/s^2"
#: What a file asks for, and the flags that answer; nothing else may be asked.
ASKS = {
    "T_temp.csv": ("--rate HZ", "--rate 100"),
    "minutes.csv": ("--time-unit min", "--time-unit min"),
    "fz37_sample_gap.csv": ("--rate HZ", "--rate 100"),
    "fz29_accel_2axes_wrong.csv": ("--accel-unit g", "--accel-unit g"),
    "excel_mmss.csv": ("--rate HZ", "--rate 100"),
    "arduino_mon.txt": (
        "--columns",
        "--columns clock,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z",
    ),
    "i2cdevlib.txt": ("--rate HZ", "--rate 100"),
    "kv.txt": ("--rate HZ", "--rate 100"),
    "fz22_temp_F.csv": ("--gyro-unit", SI),
    "fz32_time_1dec.csv": ("--gyro-unit", SI),
}
#: What must be said.
SAYS = {
    "millis_800.csv": "grain",
    "us_roll.csv": "unwrapped",
    "fz30_dupe_rows.csv": "copies",
    "04b_third_of_rows_twice.csv": "copies",
    "04c_copy_for_lost_sample.csv": "copies",
    "08_seven_alike.csv": "7 rows",
    "held.csv": "held",
    "interleaved.csv": "rows of their own",
    "31_bag_clock_stepped_back": "falls back by 2 s",
    "30_bag_in_g": "--accel-unit g was taken",
    "11_gyro_200.csv": "by its stamp",
}
#: Samples missing, where a file has a hole.
MISSING = {
    "millis_1khz_gap.csv": 1,
    "secs_nsecs_gap.csv": 30,
    "fz37_sample_gap.csv": 1,
    "04c_copy_for_lost_sample.csv": 199,
}


@pytest.fixture(scope="module")
def folder(data_dir):
    place = data_dir.parent / "cases" / "logs"
    if not (place / "expected.json").exists():
        pytest.skip("the folder of logs is not there")
    return place


def opened(folder, name, flags):
    argv = ["check", str(folder / name)]
    if name == "11_gyro_200.csv":
        argv = ["check", "--gyro", argv[1], "--accel", str(folder / "11_accel_201p5.csv")]
    if name == "11_accel_201p5.csv":
        argv = ["check", "--accel", argv[1]]
    args = parser("check").parse_args(joined(argv + shlex.split(flags)))
    return readers.read(args.file, **common.record_options(args))


def test_every_log_is_right_or_asks(folder):
    expected = json.loads((folder / "expected.json").read_text())
    for name, right in expected.items():
        flags = right["flags"]
        if name in ASKS:
            asked, answer = ASKS[name]
            if name in ("excel_mmss.csv", "fz29_accel_2axes_wrong.csv") or "--rate" not in flags:
                with pytest.raises(InputError, match=re.escape(asked)):
                    opened(folder, name, flags)
            flags = f"{flags} {answer}"
        found = opened(folder, name, flags)
        record = found.record
        rate = right["rate_hz"] or 100.0
        if name == "06b_alpha_columns.csv":
            rate = 200.0
        assert record.rate == pytest.approx(rate, rel=2e-3), name
        quiet = 0.2 if name.startswith(("boot_", "android_")) else 1.0
        up = -1.0 if name in UP else 1.0
        for kind, mean, scatter in (
            ("gyro", GYRO * quiet, 0.002 * quiet),
            ("accel", ACCEL * up, 0.02),
        ):
            for axis, m in zip("xyz", mean):
                if f"{kind}_{axis}" not in record:
                    continue
                x = record[f"{kind}_{axis}"]
                n = np.isfinite(x).sum()
                # five standard errors of a mean, a quarter on the scatter; counts round by half a step
                assert np.nanmean(x) == pytest.approx(m, abs=5 * scatter / np.sqrt(n) + 0.002 * abs(m) + 2e-4), (name, kind, axis)  # fmt: skip
                assert np.nanstd(x) == pytest.approx(scatter, rel=0.25), (name, kind, axis)
        assert sum(g.missing for g in record.gaps()) == MISSING.get(name, 0) or name == "11_gyro_200.csv", name  # fmt: skip
        if name in SAYS:
            assert any(SAYS[name] in note for note in record.notes), (name, record.notes)
        assert all(c.evidence for c in found.columns), name
    assert set(ASKS) | set(SAYS) | set(MISSING) <= set(expected)


def test_channels_that_must_be_there(folder):
    six = {"gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"}
    for name in ("phystool.csv", "zb_gyro_0.csv", "mip.csv", "androsensor.csv", "st_mems.csv", "unit_row.csv", "bagpy.csv", "rostopic.csv"):  # fmt: skip
        expected = json.loads((folder / "expected.json").read_text())[name]
        assert set(opened(folder, name, expected["flags"]).record.channel_names) == six, name
    warm = opened(folder, "T_temp.csv", SI + " --rate 100").record.temperature
    assert 23.9 < warm.min() and warm.max() < 24.6
