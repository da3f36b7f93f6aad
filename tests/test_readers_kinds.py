"""Logs of many kinds: each opens with its flags and gives the sensor's signal, or asks for what is
missing and opens with the answer.
"""

import re
import shlex

import numpy as np
import pytest
import strange_logs

from imu_lib import readers
from imu_lib.cli import common
from imu_lib.cli.main import joined, parser
from imu_lib.errors import InputError
from imu_lib.readers import gravity, plausibility

LOGS, ASKING = strange_logs.logs(), strange_logs.asking()


def opened(path, content, flags):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    args = parser("check").parse_args(joined(["check", str(path), *shlex.split(flags)]))
    return readers.read(args.file, **common.record_options(args))


def same(found, rate):
    """Whether the record is the standing sensor's, at its rate."""
    record = found.record
    assert record.rate == pytest.approx(rate, rel=1e-3)
    for kind, right in (("gyro", strange_logs.GYRO), ("accel", strange_logs.ACCEL)):
        for axis, y in zip("xyz", right.T):
            if f"{kind}_{axis}" in record:
                x = record[f"{kind}_{axis}"]
                # of streams half a sample apart the first reading of one may have no partner
                first = int(len(x) < len(y) and abs(x[0] - y[1]) < abs(x[0] - y[0]))
                assert len(y) - 1 <= len(x) <= len(y)
                # counts are rounded to half a step, 2.5e-4
                assert np.allclose(x, y[first : first + len(x)], rtol=1e-3, atol=3e-4)
    assert not record.gaps()
    assert {c.read_as for c in found.columns} >= {None} or all(c.read_as for c in found.columns)
    return record


@pytest.mark.parametrize("name", LOGS)
def test_opens_and_is_right(tmp_path, name):
    content, flags, rate = LOGS[name]
    record = same(opened(tmp_path / name, content, flags), rate)
    text = content.decode("latin-1") if isinstance(content, bytes) else content
    one = name.startswith(
        ("phone_de", "minutes_seconds", "many", "coarse", "neg", "noon", "reset", "plain")
    )
    assert len(record.channel_names) == (3 if one or name == "phone_fr.csv" else 6), text[:200]


@pytest.mark.parametrize("name", ASKING)
def test_asks_and_opens_with_the_answer(tmp_path, name):
    content, flags, asked, answer, rate = ASKING[name]
    with pytest.raises(InputError, match=re.escape(asked)) as error:
        opened(tmp_path / name, content, flags)
    if answer is None:  # the sentence itself holds the names to give
        named = re.search(r"(?:--columns '|as in )([^' ]+,[^' ]+)", str(error.value))
        answer = f"--columns {named[1].rstrip('.;')}"
    same(opened(tmp_path / name, content, f"{flags} {answer}"), rate)


def test_what_was_done_is_said(tmp_path):
    said = {
        "reset.csv": "falls back",
        "typed.csv": "rows of their own",
        "own_stamps.csv": "stamps of its own",
        "week.csv": "a week",
        "coarse.csv": "coarser than the sampling",
        "header_again.csv": "appended",
        "dataflash.csv": None,
    }
    for name, words in said.items():
        content, flags, _ = LOGS[name]
        found = opened(tmp_path / name, content, flags)
        assert words is None or any(words in note for note in found.record.notes), (name, found)
        if name == "dataflash.csv":
            assert found.record.temperature[0] == pytest.approx(41.2)
            time = next(c for c in found.columns if c.read_as == "time")
            assert (time.name, time.unit) == ("TimeUS", "us")
    used = opened(tmp_path / "mt_manager.txt", *LOGS["mt_manager.txt"][:2])
    assert next(c for c in used.columns if c.read_as == "time").unit == "ticks:10000"
    unused = {c.name: c.evidence for c in used.columns if c.read_as is None}
    assert unused["Roll"] == "an attitude" and unused["Mag_X"] == "a magnetometer"


def test_what_the_call_says_wins_with_a_word(tmp_path):
    g = strange_logs.table("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", strange_logs.T, strange_logs.IN_G)  # fmt: skip
    with pytest.raises(InputError, match="likely g"):
        opened(tmp_path / "g.csv", g, "")
    found = opened(tmp_path / "g.csv", g, "--accel-unit g")
    assert any("--accel-unit g was taken" in n for n in found.record.notes)
    assert np.allclose(found.record["accel"], strange_logs.ACCEL, rtol=1e-6)
    ms = strange_logs.table("time [s],gx [rad/s],gy [rad/s],gz [rad/s]", strange_logs.I * 10, strange_logs.GYRO)  # fmt: skip
    with pytest.raises(InputError, match="--time-unit ms"):
        opened(tmp_path / "ms.csv", ms, "")
    assert opened(tmp_path / "ms.csv", ms, "--time-unit ms").record.rate == 100.0
    assert opened(tmp_path / "ms.csv", ms, "--time-unit s").record.rate == pytest.approx(0.1)


def test_a_stated_unit_that_makes_an_unusual_rate_is_doubted(tmp_path):
    head = "timestamp [us],gx [rad/s],gy [rad/s],gz [rad/s]"
    text = strange_logs.table(head, strange_logs.I * 1_000_000, strange_logs.GYRO)
    found = opened(tmp_path / "a.csv", text, "")
    assert found.record.rate == 1.0 and any("--time-unit ns" in n for n in found.record.notes)
    assert not opened(tmp_path / "a.csv", text, "--time-unit us").record.notes


def test_a_unit_for_what_is_not_there_is_said(tmp_path):
    text = strange_logs.table("time,gx,gy,gz,foo_x,foo_y,foo_z", strange_logs.T, strange_logs.GYRO, strange_logs.ACCEL)  # fmt: skip
    notes = opened(tmp_path / "a.csv", text, strange_logs.SI).record.notes
    assert any("--accel-unit m/s^2 was given" in n and "foo_x" in n for n in notes)


@pytest.mark.parametrize("unit, zero", [("degF", 32.0), ("K", 273.15)])
def test_temperatures(tmp_path, unit, zero):
    factor = 1.8 if unit == "degF" else 1.0
    warm = 20 + strange_logs.T / 4
    text = strange_logs.table(f"time [s],gx [rad/s],temp [{unit}]", strange_logs.T, strange_logs.GYRO[:, 0], warm * factor + zero)  # fmt: skip
    found = opened(tmp_path / "t.csv", text, "")
    assert np.allclose(found.record.temperature, warm, atol=1e-6)
    bare = text.replace(f" [{unit}]", "")
    notes = opened(tmp_path / "t.csv", bare, "").record.notes
    assert any("degF" in n or "K:" in n for n in notes)


def test_flight_logs_and_data_of_r(tmp_path):
    ulog = pytest.importorskip("pyulog")
    assert ulog
    from ulog_writer import write

    stamp = 98_765_432 + 4000 * strange_logs.I
    write(tmp_path / "a.ulg", stamp, strange_logs.GYRO, strange_logs.ACCEL)
    same(readers.read(tmp_path / "a.ulg"), 250)
    write(tmp_path / "b.ulg", stamp, strange_logs.GYRO, strange_logs.ACCEL, apart=True)
    same(readers.read(tmp_path / "b.ulg"), 250)
    (tmp_path / "c.ulg").write_bytes((tmp_path / "a.ulg").read_bytes()[:40])
    with pytest.raises(InputError, match="c.ulg"):
        readers.read(tmp_path / "c.ulg")


@pytest.mark.parametrize(
    ("fs", "gyro", "accel", "bias"),
    [
        (200.0, 3e-7, 3e-4, (4e-5, 1e-5, 5e-5)),  # fibre optic, 0.001 deg/sqrt(h)
        (200.0, 3.5e-6, 1.2e-3, (5e-5, -4e-5, 3e-5)),  # tactical, 0.012 deg/sqrt(h)
        (500.0, 4.4e-5, 1.2e-3, (1e-4, 2e-4, -1e-4)),  # tactical MEMS, 0.15 deg/sqrt(h)
        (100.0, 8.7e-5, 3.9e-3, (0.02, -0.03, 0.01)),  # consumer, 0.005 deg/s/sqrt(Hz)
        (100.0, 3e-3, 5e-3, (0.2, -0.1, 0.1)),  # very poor, 10 deg/sqrt(h)
        (5.0, 9e-4, 3e-3, (0.01, 0.0, -0.02)),  # decimated to 5 Hz
        (4.16, 2.6e-3, 4e-3, (0.01, 0.0, -0.01)),  # 0.3 deg/s in every sample
    ],
)
def test_no_true_unit_is_refused(fs, gyro, accel, bias):
    """From fibre-optic to very poor: data sheets' noise densities, rad/s and m/s^2 per sqrt(Hz)."""
    rng = np.random.default_rng(8)
    w = rng.normal(0, gyro * np.sqrt(fs), (3000, 3)) + bias
    a = rng.normal(0, accel * np.sqrt(fs), (3000, 3)) - [0, 0, 9.8]
    for unit in ("rad/s", "deg/s", "deg/h"):
        told = plausibility.gyro_unit(w, a, fs, unit, strict=True)
        alone = plausibility.gyro_unit(w, None, fs, unit, strict=True)
        assert not (told and told.refused) and not (alone and alone.refused)


def test_a_moving_car_passes_in_its_unit():
    rng = np.random.default_rng(3)
    fs, n = 100.0, 30_000
    t = np.arange(n) / fs
    go = (t > 30)[:, None]
    yaw = 0.2 * np.sin(2 * np.pi * t / 20) * go[:, 0]
    w = np.column_stack([0.02 * np.sin(3 * t), 0.03 * np.sin(5 * t), 0 * t]) * go
    w[:, 2] += yaw
    w += rng.normal(0, 2e-3, (n, 3)) + rng.normal(0, 0.03, (n, 3)) * go
    a = np.column_stack([1.5 * np.sin(t / 7), 2 * yaw, 0 * t - 9.81]) + rng.normal(0, 0.6, (n, 3))
    assert plausibility.gyro_unit(w, a, fs, "rad/s", strict=True) is None
    assert plausibility.gyro_unit(w, a, fs, "deg/s", strict=True) is None
    assert plausibility.gyro_unit(w / (np.pi / 180), a, fs, "rad/s", strict=True).likely == "deg/s"
    assert gravity.accel_unit(a, "m/s^2", 1.0) is None


def test_gravity_that_is_off_is_said():
    a = np.random.default_rng(1).normal(0, 0.02, (3000, 3)) - [0, 0, 9.05]
    told = gravity.accel_unit(a, "m/s^2", 1.0)
    assert not told.refused and "7.7 % below gravity" in told.why


@pytest.mark.parametrize("shape", ["kalibr_allan", "psins", "navego", "six"])
def test_matrices_and_structs_of_toolboxes(tmp_path, shape):
    import scipy.io

    t, w, a = strange_logs.T, strange_logs.GYRO, strange_logs.ACCEL
    path = tmp_path / "m.mat"
    seven = "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
    if shape == "kalibr_allan":
        scipy.io.savemat(path, {"data_imu": np.column_stack([1.6e9 + t, w, a])})
        same(readers.read(path, columns=seven, gyro_unit="rad/s", accel_unit="m/s^2"), 100)
    elif shape == "psins":  # increments, the time behind them
        scipy.io.savemat(path, {"imu": np.column_stack([w * 0.01, a * 0.01, t + 0.01])})
        with pytest.raises(InputError, match="dtheta_x") as error:
            readers.read(path)
        named = re.search(r"as in '([^']+)'", str(error.value))[1]
        same(readers.read(path, columns=named), 100)
    elif shape == "navego":
        scipy.io.savemat(path, {"imu": {"t": t[:, None], "fb": a, "wb": w, "freq": 100.0}})
        same(readers.read(path, gyro_unit="rad/s", accel_unit="m/s^2"), 100)
    else:
        np.save(tmp_path / "six.npy", np.vstack([w.T, a.T]))  # (axes, samples)
        options = {"columns": seven[5:], "gyro_unit": "rad/s", "accel_unit": "m/s^2", "rate": 100}
        same(readers.read(tmp_path / "six.npy", **options), 100)
        kinds = [(k, "f8") for k in seven.split(",")]
        rows = np.array(list(map(tuple, np.column_stack([t, w, a]))), dtype=kinds)
        np.save(tmp_path / "named.npy", rows)
        same(readers.read(tmp_path / "named.npy", gyro_unit="rad/s", accel_unit="m/s^2"), 100)


def test_a_data_frame_of_r(tmp_path):
    """A data frame as R serialises it (XDR, version 2), packed by xz."""
    import lzma
    import struct

    def text(word):
        return struct.pack(">ii", 0x40009, len(word)) + word.encode()

    def symbol(word):
        return struct.pack(">i", 1) + text(word)

    columns = {"time": strange_logs.T} | {f"g{a}": x for a, x in zip("xyz", strange_logs.GYRO.T)}
    body = struct.pack(">ii", 0x13 | 0x200, len(columns))
    for x in columns.values():
        body += struct.pack(">ii", 14, len(x)) + np.asarray(x, ">f8").tobytes()
    heads = struct.pack(">ii", 16, len(columns)) + b"".join(text(k) for k in columns)
    body += struct.pack(">i", 0x402) + symbol("names") + heads + struct.pack(">i", 254)
    whole = b"RDX2\nX\n" + struct.pack(">iii", 2, 0x30600, 0x20300)
    whole += struct.pack(">i", 0x402) + symbol("imu") + body + struct.pack(">i", 254)
    (tmp_path / "d.rda").write_bytes(lzma.compress(whole))
    same(readers.read(tmp_path / "d.rda", gyro_unit="rad/s"), 100)


def test_columns_cannot_tell_rows_of_different_sensors_apart(tmp_path):
    content = LOGS["typed.csv"][0]
    with pytest.raises(InputError, match="different sensors"):
        opened(
            tmp_path / "a.csv", content, "--gyro-unit rad/s --columns time,-,gyro_x,gyro_y,gyro_z"
        )


def test_one_member_of_an_archive(tmp_path):
    path = tmp_path / "two.zip"
    one = strange_logs.table("time [s],gx [rad/s],gy [rad/s],gz [rad/s]", strange_logs.T, strange_logs.GYRO)  # fmt: skip
    path.write_bytes(strange_logs.archive(first=one, second=one))
    with pytest.raises(InputError, match="several files") as error:
        readers.read(path)
    named = re.search(r"as in '([^']+)'", str(error.value))[1]
    same(readers.read(named), 100)
    with pytest.raises(InputError, match="holds no third.csv"):
        readers.read(path / "third.csv")
