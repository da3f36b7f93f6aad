"""Everything that a file leaves open is asked in one message; numbers, letters and marks that may be
read in two ways are read in the right one, or asked about.
"""

import numpy as np
import pytest
from strange_logs import ACCEL, GYRO, IN_G, SI, I, T, table
from test_readers_kinds import opened, same

from imu_lib import readers
from imu_lib.errors import InputError
from imu_lib.readers import plausibility

SIX = "gx,gy,gz,ax,ay,az"


def asked(path, content, flags=""):
    with pytest.raises(InputError) as error:
        opened(path, content, flags)
    return str(error.value)


def test_sensors_time_and_units_are_asked_at_once(tmp_path):
    """A fall data set of five bands: whose row, in which unit of time, in which units."""
    rows = [
        f"{1000 + 50 * k};{k};{x[0]:.9g};{x[1]:.9g};{x[2]:.9g};{kind};{band}"
        for k in I
        for kind, x in ((0, ACCEL[k]), (1, GYRO[k]))
        for band in (0, 2)
    ]
    head = "% Sensor_Type: Accelerometer = 0 | Gyroscope = 1\n%\n% TimeStamp;Sample No;X-Axis;Y-Axis;Z-Axis;Sensor Type;Sensor ID\n"
    text = head + "\n".join(rows) + "\n"
    said = asked(tmp_path / "a.csv", text)
    for flag in ("--topic 'Sensor ID=0'", "--time-unit ms", "--gyro-unit", "--accel-unit"):
        assert flag in said
    answer = f"--topic 'Sensor ID=0' --time-unit ms {SI}"
    same(opened(tmp_path / "a.csv", text, answer), 20)
    assert "--gyro-unit" not in asked(tmp_path / "a.csv", text, SI)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("", "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"),
        ("time,u1,u2,u3,v1,v2,v3", "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"),
    ],
)
def test_columns_and_the_unit_of_their_time_are_asked_at_once(tmp_path, head, columns):
    text = table(head, 1000 + 50 * I, GYRO, ACCEL)
    said = asked(tmp_path / "a.csv", text)
    for flag in (columns, "--time-unit ms", "--gyro-unit", "--accel-unit"):
        assert flag in said
    assert "--time-unit" not in asked(tmp_path / "a.csv", text, "--time-unit ms")
    same(opened(tmp_path / "a.csv", text, f"--columns {columns} --time-unit ms {SI}"), 20)


def test_the_units_of_two_files_are_asked_at_once(tmp_path):
    for name, x in (("gyro", GYRO), ("accel", ACCEL)):
        (tmp_path / f"{name}.csv").write_text(table("t,x,y,z", 1000 + 50 * I, x))
    files = {k: tmp_path / f"{k}.csv" for k in ("gyro", "accel")}
    with pytest.raises(InputError) as error:
        readers.read(**files)
    for flag in ("--gyro-unit", "--accel-unit", "--time-unit ms"):
        assert flag in str(error.value)
    units = {"gyro_unit": "rad/s", "accel_unit": "m/s^2", "time_unit": "ms"}
    same(readers.read(**files, **units), 20)


def test_a_question_for_a_unit_says_what_the_numbers_look_like(tmp_path):
    counts = np.rint(IN_G * 16384).astype(int)
    for x, like in ((ACCEL, "gravity in m/s^2)"), (IN_G, "in g)"), (counts, "in counts:16384)")):
        said = asked(tmp_path / "a.csv", table(f"time,{SIX}", T, GYRO, x), "--gyro-unit rad/s")
        assert like in said
    tumbling = table(f"time,{SIX}", T, GYRO, ACCEL * np.sin(T)[:, None])
    assert "gravity" not in asked(tmp_path / "a.csv", tumbling, "--gyro-unit rad/s")


@pytest.mark.parametrize("mark", [",", ".", "'", "\u00a0", "\u202f", " "])
@pytest.mark.parametrize("quoted", [False, True])
def test_thousands_of_whole_numbers(tmp_path, mark, quoted):
    counts = np.rint(np.column_stack([GYRO * 4e5, IN_G * 16384])).astype(int)
    sep, form = (",", '"{}"') if quoted else (";", "{}")
    body = "".join(
        sep.join(form.format(f"{v:,}".replace(",", mark)) for v in (10 * k, *counts[k])) + "\n"
        for k in I
    )
    text = f"time_ms,{SIX}\n".replace(",", sep) + body
    found = opened(
        tmp_path / "a.csv", text, "--gyro-unit counts:6981.317 --accel-unit counts:16384"
    )
    assert any("between thousands" in n for n in found.record.notes)
    same(found, 100)


def test_decimals_are_no_thousands(tmp_path):
    """Three decimals behind a comma, beside whole numbers and dates with points."""
    text = table("time;gx;gy;gz;ax;ay;az;count", T, GYRO, ACCEL * 100, I, sep=";", form="%.3f")
    text = text.replace(".", ",")
    found = opened(tmp_path / "a.csv", text, "--gyro-unit rad/s --accel-unit cm/s^2")
    assert np.allclose(found.record["accel"], ACCEL, atol=1e-4)
    assert not any("thousands" in n for n in found.record.notes)


def test_a_letter_t_that_may_be_the_time_or_a_temperature(tmp_path):
    warm = table(f"T,{SIX}", 24.0 + 1e-3 * I + 1e-4 * np.sin(I), GYRO, ACCEL)
    said = asked(tmp_path / "a.csv", warm, SI)
    assert "time or a temperature" in said and "--rate" in said
    named = "temperature,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
    found = same(opened(tmp_path / "a.csv", warm, f"{SI} --columns {named} --rate 100"), 100)
    assert found.temperature[0] == pytest.approx(24.0, abs=1e-3)
    zero = table(f"T,{SIX}", T, GYRO, ACCEL)
    same(opened(tmp_path / "a.csv", zero, f"{SI} --time-unit s"), 100)
    as_time = f"{SI} --columns {named.replace('temperature', 'time')} --time-unit ms"
    assert opened(tmp_path / "a.csv", warm, as_time).record.rate == pytest.approx(1e6, rel=0.1)


def test_the_earths_rate_tells_degrees_that_are_labelled_radians():
    """Of a fibre-optic gyro neither noise nor bias tells: 0.005 deg/sqrt(h), 0.05 deg/h."""
    rng = np.random.default_rng(11)
    rate, earth = 100.0, 7.292e-5 * np.array([0.6, 0.0, -0.8])
    w = rng.normal(0, 1.5e-6 * np.sqrt(rate), (6000, 3)) + earth + 2.4e-7
    a = rng.normal(0, 5e-3, (6000, 3)) - [0, 0, 9.81]
    told = plausibility.gyro_unit(w / (np.pi / 180), a, rate, "rad/s", strict=True)
    assert told.likely == "deg/s" and "Earth" in told.why and not told.refused
    assert "Earth" not in getattr(
        plausibility.gyro_unit(w, a, rate, "rad/s", strict=True), "why", ""
    )
    other = rng.normal(0, 1e-3, (6000, 3)) + [0.01, -0.02, 0.005]
    assert plausibility.gyro_unit(other, a, rate, "rad/s", strict=True) is None


def test_headings_in_an_unknown_encoding_are_said(tmp_path):
    head = "time,\u56de\u8f49X,\u56de\u8f49Y,\u56de\u8f49Z,ax,ay,az"
    found = opened(tmp_path / "a.csv", table(head, T, GYRO, ACCEL).encode("big5"), SI)
    assert any("tells its encoding" in n for n in found.record.notes)
    turkish = table("Zaman (s);Jiroskop X (rad/s);Jiroskop Y (rad/s);Jiroskop Z (rad/s);"
                    "\u0130vme X (m/s\u00b2);\u0130vme Y (m/s\u00b2);\u0130vme Z (m/s\u00b2)",
                    T, GYRO, ACCEL, sep=";")  # fmt: skip
    same(opened(tmp_path / "b.csv", turkish.encode("cp1254"), ""), 100)


def test_milliseconds_in_a_column_of_their_own_stay_with_their_rows(tmp_path):
    """A clock of whole seconds whose sensors come at rates of their own, some rows logged twice."""
    ns = np.rint((59 + T) * 100).astype(int)
    clock = [f"10:{v // 6000:02d}:{v // 100 % 60:02d}" for v in ns]
    gyro = [[f"{v:.9g}" if k % 2 == 0 else "" for v in GYRO[k]] for k in I]
    rows = [
        ",".join([clock[k], str(ns[k] % 100 * 10), *gyro[k], *(f"{v:.9g}" for v in ACCEL[k])])
        for k in I
        for _ in range(1 + (k % 7 == 3))
    ]
    found = opened(tmp_path / "a.csv", f"clock,milliseconds,{SIX}\n" + "\n".join(rows) + "\n", SI)
    assert found.record.rate == pytest.approx(100.0)
    x = found.record["gyro"]
    assert np.allclose(x[np.isfinite(x).all(axis=1)], GYRO[::2], atol=1e-8)
    assert np.allclose(found.record["accel"], ACCEL, atol=1e-6)
