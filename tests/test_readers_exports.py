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
        ("a.mat", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1834\n", "git lfs pull"),
        ("a.csv", table("t,roll (deg),pitch (deg),heading (deg),altitude (m),throttle", T, GYRO, T, T), "holds angles"),
        ("a.log", "(1710411753.000000) can0 4B1#8D7405C8958\n(1710411753.010000) can0 4B1#8D7405C8\n", "CAN bus"),
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


def test_rows_of_something_else_under_the_stamps_of_the_table(tmp_path):
    rows = table(f"__time,{SIX},speed", 1e9 + T, GYRO, ACCEL, [""] * N, form="%.12g").splitlines()
    rows.pop(0)
    rows += [f"{1e9 + 0.05 * k + 0.0037:.12g},,,,,,,0.5" for k in range(N // 5)]
    text = f"__time,{SIX},speed\n" + "\n".join(sorted(rows)) + "\n"
    found = opened(tmp_path / "a.csv", text, f"{SI} --time-unit s")
    assert any("something else" in n for n in found.record.notes)
    assert len(same(found, 100)["gyro"]) == N
    lost = table(f"time [s],{SIX}", T, GYRO, ACCEL).splitlines()
    lost[50:150:7] = [r.split(",")[0] + ",,,,,," for r in lost[50:150:7]]
    found = opened(tmp_path / "b.csv", "\n".join(lost) + "\n", SI)
    assert found.record.n == N and found.record.missing().sum() == 15


def test_units_above_that_contradict_the_headings_are_said(tmp_path):
    head = "# units: accel m/s^2, gyro rad/s, yaw deg\n# gyro range 250 dps, accel range 8 g\n"
    names = ",".join(["t_ms", *(f"gyro_{a} (deg/s)" for a in "xyz"), *(f"acc_{a} (m/s^2)" for a in "xyz")])  # fmt: skip
    found = opened(tmp_path / "a.csv", head + table(names, I * 10, DPS, ACCEL), "")
    assert any("states rad/s for the gyro, its heading deg/s" in n for n in found.record.notes)
    same(found, 100)
    bare = opened(tmp_path / "b.csv", head + table(f"t_ms,{SIX}", I * 10, GYRO, ACCEL), "")
    assert not any("heading" in n for n in same(bare, 100).notes)


def test_messages_of_a_broker_late_and_twice(tmp_path):
    import json

    lines = [
        "sensors/imu/07 "
        + json.dumps(
            {
                "ts": 1710252311120 + 10 * int(k),
                "imu": {
                    "acc": {a: x for a, x in zip("xyz", ACCEL[k] / 9.80665)} | {"unit": "g"},
                    "gyr": {a: x for a, x in zip("xyz", DPS[k])} | {"unit": "dps"},
                },
            }
        )  # fmt: skip
        for k in I
    ]
    for at in range(20, N - 20, 50):
        lines.insert(at + 4, lines.pop(at))
        lines.insert(at + 9, lines[at + 7])
    found = opened(tmp_path / "a.log", "\n".join(lines) + "\n", "")
    assert len(same(found, 100)["gyro"]) == N
    assert any("out of order" in n for n in found.record.notes)


def test_a_second_table_and_frames_of_several_samples(tmp_path):
    rows = table("", *(np.repeat(np.arange(N // 2), 2), I % 2), ACCEL, GYRO)
    text = (
        f"Devices\nFrame,Sub Frame,AX,AY,AZ,GX,GY,GZ\n,,m/s²,m/s²,m/s²,rad/s,rad/s,rad/s\n{rows}\n"
        "Trajectories\n100\n,,S07:KNE,,,S07:ANK,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n"
        + table("", I, I % 2, ACCEL * 100, GYRO)
    )
    found = opened(tmp_path / "a.csv", text, "--rate 200")
    assert any("another table" in n for n in found.record.notes)
    assert len(same(found, 200)["gyro"]) == N


def test_numbers_that_touch_here_and_there_and_units_in_cells(tmp_path):
    down = IN_G * 1000 - [0, 0, 10]
    rows = "".join(
        f"{T[k]:8.2f}{w[0]:9.4f}{w[1]:9.4f}{w[2]:9.4f}{a[0]:9.3f}{a[1]:9.3f}{a[2] + (k % 5 == 0) * 20:9.3f}\n"
        for k, (w, a) in enumerate(zip(DPS, down))
    )
    head = "FORMAT (F8.2)\n    TIME   GX   GY   GZ   AX   AY   AZ\n   (S)  (DEG/S)  (DEG/S)  (DEG/S)  (MG)  (MG)  (MG)\n"
    record = opened(tmp_path / "a.dat", head + rows, "").record
    assert record.n == N and record["accel_z"].std() == pytest.approx(0.0802, rel=0.1)
    cells = "t,\u03c9_x,\u03c9_y,\u03c9_z,a_x,a_y,a_z\n" + "".join(
        f"{T[k]:g} s," + ",".join(f"{v:.8g} rad s^-1" for v in GYRO[k]) + ","
        + ",".join(f"{v:.8g} m s^-2" for v in ACCEL[k]) + "\n"
        for k in I
    )  # fmt: skip
    same(opened(tmp_path / "b.csv", cells, ""), 100)


def test_open_ticks_are_answered_by_the_rate_and_words_of_other_languages(tmp_path):
    stamp = np.cumsum(np.random.default_rng(2).integers(383, 387, N))
    found = opened(tmp_path / "a.csv", table(f"timestamp,{SIX}", stamp, GYRO, ACCEL), f"{SI} --rate 104")  # fmt: skip
    assert found.record.rate == pytest.approx(104, rel=5e-3)
    with pytest.raises(InputError, match="in no usual unit"):
        opened(tmp_path / "b.csv", table(f"timestamp,{SIX}", I * 10, GYRO, ACCEL), f"{SI} --rate 50")  # fmt: skip
    head = "Zaman (sn);" + ";".join(f"A\u00e7\u0131sal H\u0131z {a} (derece/sn)" for a in "XYZ")
    head += ";" + ";".join(f"\u0130vme {a} (m/s\u00b2)" for a in "XYZ")
    same(opened(tmp_path / "c.csv", table(head, T, DPS, ACCEL, sep=";").replace(".", ","), ""), 100)
    wide = "_start,_time,gyro_x_mdps,gyro_y_mdps,gyro_z_mdps,accel_x_mg,accel_y_mg,accel_z_mg"
    clocks = [f"2024-03-12T14:05:{k / 100:09.6f}Z" for k in I]
    start = ["2024-03-12T14:00:00Z"] * N
    same(opened(tmp_path / "d.csv", table(wide, start, clocks, DPS * 1e3, IN_G * 1e3), ""), 100)
    sheet = table("time [s],ax [m/s^2]", T, ["Sep 81" if k == 250 else f"{v:.6g}" for k, v in enumerate(ACCEL[:, 2])])  # fmt: skip
    with pytest.raises(InputError, match="a spreadsheet made of a number"):
        opened(tmp_path / "e.csv", sheet, "")
    for z, said in (("Sep 81", "made of numbers"), ("low", "holds text")):
        whole = table(f"time [s],{SIX}", T, GYRO, ACCEL[:, 0], ACCEL[:, 1], [z] * N)
        if z == "low":
            assert any(said in n for n in opened(tmp_path / "f.csv", whole, SI).record.notes)
            continue
        with pytest.raises(InputError, match=said):
            opened(tmp_path / "f.csv", whole, SI)


def test_a_header_of_several_levels(tmp_path):
    head = (
        "sensor,accel,accel,accel,gyro,gyro,gyro,temp\naxis,x,y,z,x,y,z,-\n"
        "unit,m/s^2,m/s^2,m/s^2,deg/s,deg/s,deg/s,degC\ntime,,,,,,,\n"
    )
    text = head + table("", T, ACCEL, DPS, T * 0 + 25)
    assert same(opened(tmp_path / "a.csv", text, "--time-unit s"), 100).temperature[0] == 25.0


def test_signs_in_brackets_wide_digits_zones_and_months(tmp_path):
    import re

    head = "time [s]," + ",".join(
        [*(f"gyro_{a} [rad/s]" for a in "xyz"), *(f"acc_{a} [m/s^2]" for a in "xyz")]
    )
    plain = table(head, T, GYRO, ACCEL)
    found = opened(tmp_path / "a.csv", re.sub(r"(?<=,)-([0-9.e-]+)", r"(\1)", plain), "")
    assert any("brackets are negative" in n for n in same(found, 100).notes)
    wide = str.maketrans({c: chr(ord(c) + 0xFEE0) for c in "0123456789.-"})
    same(opened(tmp_path / "b.csv", table(f"t,{SIX}", T, GYRO, ACCEL).translate(wide), SI), 100)
    for form in ("04-Mar-2021 10:59:{} CET", "04-mrt-2021 10:59:{}", "2021-03-04 10:59:{} PDT"):
        stamps = [form.format(f"{k / 100 + 50:05.2f}") for k in I]
        same(opened(tmp_path / "c.csv", table(f"Time,{SIX}", stamps, GYRO, ACCEL), SI), 100)
    turned = ",".join(["t [s]", *(f"a_{a} [deg/s]" for a in "xyz"), *(f"w_{a} [g]" for a in "xyz")])
    same(opened(tmp_path / "d.csv", table(turned, T, DPS, IN_G), ""), 100)


def test_streams_in_lists_and_lines_of_two_sensors(tmp_path):
    import json
    import sqlite3

    rows = {
        name: [{"t": int(1e9 + 1e7 * k + late), **dict(zip("xyz", x[k]))} for k in I]
        for name, x, late in (("accelerometer", ACCEL, 3e6), ("gyroscope", GYRO, 0))
    }
    text = json.dumps({"device": "x", "data": rows})
    same(opened(tmp_path / "a.json", text, SI), 100)
    lines = "".join(
        f"LSM6 Accelerometer : values [{', '.join(f'{v:.9g}' for v in ACCEL[k])}]\n"
        f"LSM6 Gyroscope : values [{', '.join(f'{v:.9g}' for v in GYRO[k])}]\n"
        for k in I
    )
    same(opened(tmp_path / "b.txt", lines, f"{SI} --rate 100"), 100)
    with sqlite3.connect(tmp_path / "c.db") as base:
        base.execute("create table imu (t real)")
    with pytest.raises(InputError, match="no ROS bag"):
        opened(tmp_path / "c.db", (tmp_path / "c.db").read_bytes(), "")


def test_packets_on_a_clock_of_milliseconds(tmp_path):
    """Four rows at 1 kHz share the stamp of an arrival that is up to a millisecond late."""
    late = np.random.default_rng(4).uniform(0.0, 0.8, N)
    stamp = [f"{5000 + 4 * (k // 4) + late[k // 4]:.0f}" for k in I]
    found = opened(tmp_path / "a.csv", table(f"recv_ms,{SIX}", stamp, GYRO, ACCEL), SI)
    same(found, 1000)


def test_a_turntable_keeps_its_unit():
    from imu_lib.readers import plausibility

    rng = np.random.default_rng(4)
    w = rng.normal(0, 1e-3, (3000, 3)) + [0, 0, 3.49]
    a = rng.normal(0, 1e-2, (3000, 3)) - [0, 0, 9.81]
    told = plausibility.gyro_unit(w, a, 100.0, "rpm", strict=True)
    assert told is None or not told.refused
    told = plausibility.gyro_unit(w * 57.3, a, 100.0, "rad/s", strict=True)
    assert told.refused and told.likely == "deg/s"


def test_signals_of_simulink_are_called_by_their_labels(tmp_path):
    scipy = pytest.importorskip("scipy.io")
    signals = np.zeros(2, dtype=[(n, object) for n in ("values", "dimensions", "label")])
    for k, (x, label) in enumerate([(GYRO, "gyro (rad/s)"), (ACCEL, "accel (m/s^2)")]):
        signals[k] = (x, 3.0, label)
    scipy.savemat(tmp_path / "a.mat", {"simout": {"time": T[:, None], "signals": signals}})
    same(opened(tmp_path / "a.mat", (tmp_path / "a.mat").read_bytes(), "--time-unit s"), 100)


def test_increments_state_their_units_without_brackets(tmp_path):
    names = [f"dtheta_{a}_rad" for a in "xyz"] + [f"dvel_{a}_m_s" for a in "xyz"]
    text = table(",".join(["tow_s", *names]), 1000 + T, GYRO * 0.01, ACCEL * 0.01, form="%.12g")
    same(opened(tmp_path / "a.csv", text, ""), 100)


def test_the_gyro_is_the_sensor_s_own_where_the_accelerometer_is(tmp_path):
    """A phone writes its sensors beside what it made of them."""
    kinds = [f"{k}{a}({u})" for k, u in (
        ("accelerometerAcceleration", "G"), ("gyroRotation", "rad/s"),
        ("motionRotationRate", "rad/s"), ("motionUserAcceleration", "G"),
    ) for a in "XYZ"]  # fmt: skip
    free = (GYRO - GYRO.mean(axis=0), IN_G - IN_G.mean(axis=0))
    text = table(",".join(["time(s)", *kinds]), T, IN_G, GYRO, *free)
    found = opened(tmp_path / "a.csv", text, "")
    same(found, 100)
    assert any("`gyroRotationX(rad/s)` was taken as the gyro" in n for n in found.record.notes)


@pytest.mark.parametrize("torn", ["0.9\n", "9412,-0.0"])
def test_a_board_that_restarted_in_the_middle_is_said(tmp_path, torn):
    greeting = f"MPU6050 connection successful\nt_ms,{SIX}\n"
    runs = [table("", 412 + I[part] * 10 - 10 * I[part][0], GYRO[part], ACCEL[part]) for part in (slice(0, 150), slice(150, N))]  # fmt: skip
    again = greeting if torn.endswith("\n") else greeting.splitlines()[1] + "\n"
    text = greeting + runs[0].strip() + "\n" + torn + again + runs[1].strip() + "\n"
    found = opened(tmp_path / "a.csv", text, SI)
    assert len(same(found, 100)["gyro"]) == N
    assert any("Line 153 is cut off" in n and "restarted" in n for n in found.record.notes)
    (tmp_path / "b.csv").write_text("".join(text.splitlines(keepends=True)[:152]))
    assert opened(tmp_path / "b.csv", (tmp_path / "b.csv").read_bytes(), SI).record.n == 150
