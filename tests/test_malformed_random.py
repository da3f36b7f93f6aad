"""No text, table, archive or heading breaks the readers, whatever is in it."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.readers import fields, names, read_record


def values(n=300):
    rng = np.random.default_rng(11)
    accel = rng.normal(scale=2e-2, size=(n, 3)) - [0, 0, units.G]
    return np.column_stack([np.arange(n) / 100.0, rng.normal(scale=2e-3, size=(n, 3)), accel])


def npz(path, **arrays):
    np.savez(path, **arrays)
    return path.read_bytes()


junk_text = st.text(
    alphabet=st.sampled_from("0123456789.,;:-+eE \t\n#%/[]()_gxyztnaif\"'\\|\0é"), max_size=400
)
SLOW = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@SLOW
@given(text=junk_text)
def test_no_text_breaks_the_readers(tmp_path, text):
    path = tmp_path / "fuzz.csv"
    path.write_text(text, encoding="utf-8")
    try:
        read_record(path, gyro_unit="rad/s", accel_unit="m/s^2", rate=100.0)
    except InputError as error:
        assert str(error)


FIELDS = ["1", "-2.5", "", "nan", "x", "1e400", "2020-01-01", "12:00:01", "inf", "9" * 30]


@SLOW
@given(
    rows=st.lists(st.lists(st.sampled_from(FIELDS), min_size=1, max_size=5), max_size=8),
    delimiter=st.sampled_from([",", ";", " ", "\t"]),
    columns=st.sampled_from([None, "time,gyro_x", "gyro_x,-,accel_z", "date,clock,gyro_x,gyro_y"]),
)
def test_no_table_breaks_the_readers(tmp_path, rows, delimiter, columns):
    path = tmp_path / "fuzz.txt"
    path.write_text("\n".join(delimiter.join(r) for r in rows))
    try:
        read_record(path, columns=columns, gyro_unit="deg/s", accel_unit="g", rate=10.0)
    except InputError as error:
        assert str(error)


@SLOW
@given(data=st.data())
def test_no_damage_breaks_the_archive(tmp_path, data):
    x = values(60)
    content = bytearray(npz(tmp_path / "good.npz", time=x[:, 0], gyro=x[:, 1:4], accel=x[:, 4:]))
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path = tmp_path / "bad.npz"
    path.write_bytes(bytes(content[: data.draw(st.integers(10, len(content)))]))
    try:
        read_record(path)
    except InputError as error:
        assert str(error)


@SLOW
@given(text=st.text(st.characters(max_codepoint=0x250), max_size=30))
def test_names_take_any_text(text):
    canonical, _ = names.parse(text)
    assert canonical is None or isinstance(canonical, str)
    assert fields.kind(text) in ("number", "date", "clock", "moment", "empty", "text")


@SLOW
@given(
    x=st.lists(st.floats(-10, 10, allow_nan=False), min_size=4, max_size=40),
    suffix=st.sampled_from([".csv", ".npz", ".parquet", ".tsv"]),
    rate=st.sampled_from([1.0, 8.0, 100.0, 204.8, 1000.0]),
)
def test_round_trip_of_any_numbers(tmp_path, x, suffix, rate):
    from imu_lib.record import Record
    from imu_lib.writers import write_record

    x = np.asarray(x)
    path = tmp_path / f"r{suffix}"
    write_record(Record({"accel_y": x}, rate), path)
    found = read_record(path, trust_units=True)
    assert np.array_equal(found["accel_y"], x) and found.rate == pytest.approx(rate, rel=1e-6)
