"""What a format fixes, and readings that were worked on before the file was written."""

import re

import numpy as np
import pytest
import scipy.io
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError

AXES = ("X", "Y", "Z")


def heads(*forms):
    return ",".join(f.format(a.lower()) for f in forms for a in AXES)


def manager(*columns):
    head = "PacketCounter,SampleTimeFine," + heads("Acc_{}", "Gyr_{}")
    text = "// Update Rate: 100.0Hz\n// Filter Profile: human\n" + table(head, I, I * 100, *columns)
    return re.sub(r"(Acc|Gyr)_([xyz])", lambda m: f"{m[1]}_{m[2].upper()}", text).replace(",", "\t")


def labview(*columns):
    rows = table("X_Value\t" + "\t".join(("Gyro X", "Gyro Y", "Gyro Z", "Accel X", "Accel Y", "Accel Z", "Comment")), T, *columns, sep="\t")  # fmt: skip
    units = (
        "Y_Unit_Label\tdeg/s\tdeg/s\tdeg/s\tg\tg\tg\t\nX_Dimension\tTime\nX0\t0.0\nDelta_X\t0.01\n"
    )
    head = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
    return f"{head}***End_of_Header***\t\n\t\nChannels\t6\n{units}***End_of_Header***\n{rows}"


FIXED = {
    "ros.csv": table("time [s]," + heads("field.angular_velocity.{}", "field.linear_acceleration.{}"), T, GYRO, ACCEL),
    "plot.csv": table("__time," + heads("/imu/angular_velocity/{}", "/imu/linear_acceleration/{}"), T + 1.7e9, GYRO, ACCEL, form="%.12g"),
    "manager.txt": manager(ACCEL, GYRO),
    "labview.lvm": labview(DPS, IN_G),
}  # fmt: skip


@pytest.mark.parametrize("name", FIXED)
def test_units_that_a_format_fixes_are_not_asked_for(tmp_path, name):
    same(opened(tmp_path / name, FIXED[name], ""), 100)


def test_units_beside_the_arrays_of_a_struct(tmp_path):
    said = {"t": T[:, None], "gyr": DPS, "acc": IN_G, "fs": 100.0}
    for units in ("deg/s, g", {"gyr": "deg/s", "acc": "g"}, np.array(["deg/s", "g"], dtype=object)):
        scipy.io.savemat(tmp_path / "a.mat", {"imu": said | {"units": units}})
        same(readers.read(tmp_path / "a.mat"), 100)
    scipy.io.savemat(tmp_path / "a.mat", {"imu": said | {"units": "deg/s, rad/s"}})
    with pytest.raises(InputError, match="--gyro-unit"):
        readers.read(tmp_path / "a.mat")


def test_columns_named_by_the_call_keep_the_units_of_their_headings(tmp_path):
    text = table("t [s],one [deg/s],two [deg/s],three [deg/s],a_mps2,b_mps2,c [m/s^2]", T, DPS, ACCEL)  # fmt: skip
    named = "--columns time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
    with pytest.raises(InputError, match="accelerometer|accel") as error:
        opened(tmp_path / "a.csv", text.replace("c [m/s^2]", "c").replace("_mps2", ""), named)
    assert "--gyro-unit" not in str(error.value)
    same(opened(tmp_path / "a.csv", text.replace("a_mps2,b_mps2", "a [m/s^2],b [m/s^2]"), named), 100)  # fmt: skip


def test_two_units_of_rows_by_sensor_are_asked_for_at_once(tmp_path):
    both = (("ACC", ACCEL), ("GYRO", GYRO))
    rows = [f"{10 * k + 2 * j},{s},{x[k, 0]:.7f},{x[k, 1]:.7f},{x[k, 2]:.7f}" for k in range(N) for j, (s, x) in enumerate(both)]  # fmt: skip
    with pytest.raises(InputError, match="--gyro-unit .*--accel-unit"):
        opened(tmp_path / "a.csv", "timestamp,sensor,x,y,z\n" + "\n".join(rows), "")


@pytest.mark.parametrize("step", [100, 50])
def test_even_ticks_without_a_unit_are_asked_about(tmp_path, step):
    text = table("t," + heads("g{}", "a{}"), I * step, GYRO, ACCEL)
    with pytest.raises(InputError, match="ticks:10000"):
        opened(tmp_path / "a.csv", text, SI)
    same(opened(tmp_path / "a.csv", text, f"{SI} --time-unit ticks:10000"), 1e4 / step)
    assert opened(tmp_path / "a.csv", text, f"{SI} --time-unit ms").record.rate == pytest.approx(1e3 / step)  # fmt: skip


def test_milliseconds_that_can_be_nothing_else_are_read(tmp_path):
    rng = np.random.default_rng(2)
    for stamps in (I * 10, 1_700_000_000_000 + I * 100, I * 100 + 5000 + rng.integers(0, 9, N)):
        found = opened(tmp_path / "a.csv", table("t," + heads("g{}", "a{}"), stamps, GYRO, ACCEL), SI)  # fmt: skip
        assert found.record.rate == pytest.approx(
            1e3 * (N - 1) / (stamps[-1] - stamps[0]), rel=0.01
        )


def test_angles_are_no_rates(tmp_path):
    angles = np.cumsum(DPS, axis=0) * 0.01
    head = "t [s],GyroX (deg),GyroY (deg),GyroZ (deg),ax [g],ay [g],az [g]"
    for flags in ("", "--gyro-unit deg/s"):
        with pytest.raises(InputError, match="an angle that was integrated") as error:
            opened(tmp_path / "a.csv", table(head, T, angles, IN_G), flags)
    named = re.search(r"--columns (\S+), ", str(error.value))[1]
    record = opened(tmp_path / "a.csv", table(head, T, angles, IN_G), f"--columns {named}").record
    assert record.channel_names == ("accel_x", "accel_y", "accel_z")
    rates = table(head, T, DPS, IN_G)  # a unit that is spelled short stays a question of its own
    same(opened(tmp_path / "a.csv", rates, "--gyro-unit deg/s"), 100)


def test_a_bias_that_was_taken_out_is_said(tmp_path):
    rng = np.random.default_rng(4)
    gyro, t = rng.normal(0, 2e-3, (3000, 3)), np.arange(3000) / 100
    accel = rng.normal(0, 2e-2, (3000, 3)) - [0, 0, 9.81]
    rows = np.column_stack([t, gyro - gyro.mean(axis=0), accel])
    for shift, said in ((0.0, True), (1e-3, False)):
        rows[:, 1] = gyro[:, 0] - gyro[:, 0].mean() + shift
        np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="t,gx,gy,gz,ax,ay,az", comments="")  # fmt: skip
        found = readers.read(tmp_path / "a.csv", gyro_unit="rad/s", accel_unit="m/s^2", time_unit="s")  # fmt: skip
        assert any("vanish" in n for n in found.record.notes) is said


@pytest.mark.parametrize("unit", ["m/s^2", "g", ""])
def test_increments_under_the_names_of_rates_are_asked_for(tmp_path, unit):
    """At rest their length is gravity over the rate; the columns that are offered read them."""
    heads = [f"gyro_{a}" for a in "xyz"] + [f"accel_{a} ({unit})" if unit else f"accel_{a}" for a in "xyz"]  # fmt: skip
    force = IN_G if unit == "g" else ACCEL
    text = table(",".join(["time (s)", *heads]), T, GYRO * 0.01, force * 0.01, form="%.12g")
    with pytest.raises(InputError, match="look like increments") as error:
        opened(tmp_path / "a.csv", text, "")
    named = re.search(r"--columns '([^']+)'", str(error.value))[1]
    same(opened(tmp_path / "a.csv", text, f"--columns '{named}'"), 100)
