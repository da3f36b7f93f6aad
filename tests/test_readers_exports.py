"""What laboratories, flight controllers and vibration loggers export: blocks with their heading each,
lines cut off, tables shared with other sensors, increments with their intervals, and files that hold
no samples.
"""

import numpy as np
import pytest
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, table
from test_readers_kinds import opened, same

from imu_lib.errors import InputError

SIX = "gx,gy,gz,ax,ay,az"


def test_blocks_with_a_heading_each(tmp_path):
    """LabVIEW's segments; the first row of each has a remark."""
    blocks = ["LabVIEW Measurement\nMulti_Headings\tYes\n***End_of_Header***\n"]
    for low in range(0, N, 100):
        part = slice(low, low + 100)
        rows = table("", T[part], ACCEL[part], GYRO[part], sep="\t").splitlines()
        rows[0] += "\tstart" if low == 0 else ""
        blocks += [
            "\nChannels\t6\nSamples\t100\t100\t100\t100\t100\t100\n"
            "Y_Unit_Label\tm/s^2\tm/s^2\tm/s^2\trad/s\trad/s\trad/s\nDelta_X\t0.01\t0.01\n"
            "***End_of_Header***\nX_Value\tAccX\tAccY\tAccZ\tGyroX\tGyroY\tGyroZ\tComment\n"
            + "\n".join(rows)
        ]
    found = opened(tmp_path / "a.lvm", "\n".join(blocks) + "\n", "")
    assert len(same(found, 100)["gyro"]) == N


def test_a_last_line_that_is_cut_off_is_left_out(tmp_path):
    text = table(f"time [s],{SIX}", np.r_[T, 4.0], np.vstack([GYRO, GYRO[:1]]), np.vstack([ACCEL, ACCEL[:1]]))  # fmt: skip
    for end in (text[: text.rindex(",")], text[: text.rindex(",")] + "\n"):
        found = opened(tmp_path / "a.csv", end, SI)
        assert any("cut off" in n for n in found.record.notes)
        assert len(same(found, 100)["gyro"]) == N


def test_rows_of_another_topic_and_columns_of_a_longer_one(tmp_path):
    rows = table(f"/imu/stamp,/imu/gx,/imu/gy,/imu/gz,{SIX[9:]},lat", T, GYRO, ACCEL, T * 0 + 48)
    rows = rows.splitlines()
    for at in range(360, 0, -20):
        rows.insert(at, ",,,,,,,48.1")
    found = opened(tmp_path / "a.csv", "\n".join(rows) + "\n", f"{SI} --time-unit s")
    assert any("neither a stamp" in n for n in found.record.notes)
    same(found, 100)
    long = np.arange(3 * N) / 1926.0
    twice = zip(np.tile(T, 3), np.tile(GYRO[:, 0], 3))
    own = [[f"{t:.4f}", f"{v:.9g}"] if k < N else ["", ""] for k, (t, v) in enumerate(twice)]
    text = '"X [s]","EMG [V]","X [s]","Gyro X [rad/s]"\n' + "".join(
        f"{long[k]:.6f},0.1,{own[k][0]},{own[k][1]}\n" for k in range(3 * N)
    )
    record = opened(tmp_path / "b.csv", text, "").record
    assert record.rate == 100.0 and np.allclose(record["gyro_x"], GYRO[:, 0], atol=1e-8)


def test_increments_are_divided_by_their_own_intervals(tmp_path):
    dt = np.where(I % 10 == 9, 12500, 10000)
    stamp = 98_000_000 + np.cumsum(dt)
    axes = [f"{k}[{i}]" for k in ("delta_angle", "delta_velocity") for i in range(3)]
    head = ",".join(["timestamp", *axes, "delta_angle_dt", "delta_velocity_dt"])
    text = table(head, stamp, GYRO * dt[:, None] * 1e-6, ACCEL * dt[:, None] * 1e-6, dt, dt)
    found = opened(tmp_path / "a.csv", text, "")
    assert any("own interval" in n for n in found.record.notes)
    assert np.allclose(found.record["gyro"], GYRO, atol=1e-7)
    assert np.allclose(found.record["accel"], ACCEL, atol=1e-6)


def test_units_in_a_list_and_names_with_the_sensor_behind(tmp_path):
    listed = "[channel units]\ng\ng\ng\ndeg/s\ndeg/s\ndeg/s\n\n[column names]\n"
    text = listed + table("time ax ay az gx gy gz", T, IN_G, DPS, sep=" ").replace(
        "time", "time", 1
    )
    text = text.replace("gz\n", "gz\n\n[data]\n", 1)
    same(opened(tmp_path / "a.vbo", text, "--time-unit s"), 100)
    head = "time;ESP_Laengsbeschl;" + ";".join(f"{k}{a}_Sensor_6D" for k in "aw" for a in "xyz")
    text = f"{head}\ns;m/s²;m/s²;m/s²;m/s²;°/s;°/s;°/s\n"
    text += table("", T, T * 0, ACCEL, DPS, sep=";").replace(".", ",")
    same(opened(tmp_path / "b.csv", text.encode("cp1252"), ""), 100)


def test_fast_rates_of_data_sheets_and_registers_with_a_sign(tmp_path):
    text = table("Time,ax,ay,az", I / 6664.0, ACCEL, form="%.9f")
    same(opened(tmp_path / "a.csv", text, "--accel-unit m/s^2"), 6664)
    stamp = (2**31 - 2_000_000 + I * 10_000 + 2**31) % 2**32 - 2**31
    same(opened(tmp_path / "b.csv", table(f"micros,{SIX}", stamp, GYRO, ACCEL), SI), 100)
    same(opened(tmp_path / "c.csv", table(f"Sample,CNT,{SIX}", I, I * 3, GYRO, ACCEL), f"{SI} --rate 100"), 100)  # fmt: skip
    day = table(f"Time of day,{SIX}", 0.458 + T / 86400, GYRO, ACCEL, form="%.12f")
    same(opened(tmp_path / "d.csv", day, f"{SI} --time-unit day"), 100)


def test_values_in_a_list_under_the_name_of_the_sensor(tmp_path):
    import json

    rows = [
        json.dumps({"t": int(1e9 + 1e7 * k + late), "type": name, "values": list(x[k])})
        for k in I
        for name, x, late in (("gyroscope", GYRO, 0), ("accelerometer", ACCEL, 200))
    ]
    same(opened(tmp_path / "a.jsonl", "\n".join(rows) + "\n", SI), 100)
    objects = "".join(
        f'{1e9 + T[k]:.2f},"Vector3(x={w[0]:.9g}, y={w[1]:.9g}, z={w[2]:.9g})",'
        f'"Vector3(x={a[0]:.9g}, y={a[1]:.9g}, z={a[2]:.9g})"\n'
        for k, (w, a) in enumerate(zip(GYRO, ACCEL))
    )
    text = f"stamp,angular_velocity,linear_acceleration\n{objects}"
    same(opened(tmp_path / "b.csv", text, f"{SI} --time-unit s"), 100)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", "<!DOCTYPE html><html><head></head></html>\n", "web page"),
        ("a.bin", b"\xa3\x95\x80\x80YFMT\0BBnNZ\0\r\0Type,Length\"", "mavlogdump"),
        ("a.csv", table("tau,gx,gy,gz", np.geomspace(0.01, 100, N), GYRO), "Allan analysis"),
        ("a.txt", table("t tx ty tz qx qy qz qw", T, ACCEL, GYRO, GYRO[:, 0], sep=" "), "holds numbers that could be one"),
        ("a.txt", "\n".join(" ".join(["0.1"] * 100) for _ in I), "features of windows"),
        ("a.csv", table("Date/Time,X (V),Y (V),Z (V)", [f"2017-04-03 14:11:{k / 100:05.2f}" for k in I], GYRO + 1.65), "counts:C:ZERO"),
        ("a.txt", table("", *np.rint(np.random.default_rng(1).normal(5, 1, (6, N))).astype(int), sep=" "), "--columns"),
    ],
)  # fmt: skip
def test_what_holds_no_samples_or_not_their_unit_is_said(tmp_path, name, content, said):
    with pytest.raises(InputError, match=said):
        opened(tmp_path / name, content, "")
