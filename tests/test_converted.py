"""Long files that are read once, part by part: the record that the readers make of the whole."""

import gzip
import shutil

import h5py
import numpy as np
import pytest

from imu_lib import InputError, read_record
from imu_lib.long_record import converted, open_converted, parts
from imu_lib.model import Model
from imu_lib.writers import write_record

N, FS = 20_000, 100.0
WHITE = {"process": "white_noise", "N": 1e-3}
#: Stamps that jitter, gaps, rows without a number: what no file can be read with where it lies.
MODEL = Model.from_json(
    {c: [WHITE] for c in ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y")}
    | {
        "accel_z": [WHITE, {"process": "constant", "value": -9.8}],
        "record": [
            {"process": "jitter", "sd": 3e-4},
            {"process": "time_gaps", "fraction": 1e-3, "length": 3},
            {"process": "dropout", "fraction": 1e-3, "channels": ["gyro_x", "accel_z"]},
        ],
    }
)
UNITS = {"gyro_unit": "rad/s", "accel_unit": "m/s^2"}


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Parts of some thousand rows, a cache of the test's own."""
    monkeypatch.setattr(parts, "TEXT", 1 << 19)
    monkeypatch.setattr(parts, "ROWS", 6000)
    monkeypatch.setenv("IMU_LIB_CACHE", str(tmp_path / "cache"))


@pytest.fixture(scope="module")
def record():
    return MODEL.simulate_record(N, FS, np.random.default_rng(6))


def _hdf5(record, path, last=False):
    turned = (lambda x: x.T) if last else (lambda x: x)
    with h5py.File(path, "w") as file:
        file["t"] = record.times()
        file["imu/gyro"], file["imu/accel"] = turned(record["gyro"]), turned(record["accel"])


def _zarr(record, path, form=2):
    zarr = pytest.importorskip("zarr")
    root = zarr.open_group(str(path), mode="w", zarr_format=form)
    held = {"t": record.times(), "imu/gyro": record["gyro"], "imu/accel": record["accel"]}
    for name, x in held.items():
        root.create_array(name, data=x, chunks=(4000, *x.shape[1:]))


def _zipped(record, path):
    _zarr(record, path.with_suffix(".folder"), 3)
    shutil.make_archive(str(path), "zip", path.with_suffix(".folder"))
    path.with_name(path.name + ".zip").rename(path)


def _dated(record, path):
    """A log with a moment in each row, semicolons, degrees and g."""
    with open(path, "w") as file:
        file.write("# logger 7\nwhen;gx [deg/s];gy [deg/s];gz [deg/s];ax [g];ay [g];az [g]\n")
        start = np.datetime64("2024-03-01T23:59:00.000")
        stamps = start + np.round(record.times() * 1e3).astype("timedelta64[ms]")
        rows = np.column_stack([np.degrees(record["gyro"]), record["accel"] / 9.80665])
        for t, row in zip(stamps, rows, strict=True):
            values = ("" if np.isnan(v) else f"{v:.9g}" for v in row)
            file.write(f"{t};{';'.join(values)}\n")


MAKERS = {
    "a.csv": write_record,
    "a.npz": write_record,
    "a.parquet": write_record,
    "a.h5": _hdf5,
    "matlab.mat": lambda record, path: _hdf5(record, path, last=True),
    "format_2.zarr": _zarr,
    "format_3.zarr": _zipped,
    "dated.txt": _dated,
}


@pytest.mark.parametrize("name", MAKERS)
def test_parts_make_the_record_of_the_whole(name, record, small, tmp_path):
    MAKERS[name](record, tmp_path / name)
    if name.endswith(".csv"):
        packed = tmp_path / f"{name}.gz"
        packed.write_bytes(gzip.compress((tmp_path / name).read_bytes()))
        name = packed.name
    units = UNITS if "imu" in name or name.endswith((".h5", ".mat", ".zarr")) else {}
    whole = read_record(tmp_path / name, **units)
    shares = []
    found = open_converted(tmp_path / name, least=10_000, progress=shares.append, **units)
    assert len(shares) > 2 and found.rows == whole.n
    part = found.part(0, found.rows)
    for channel, x in whole.channels.items():
        np.testing.assert_array_equal(part[channel], x)
    np.testing.assert_array_equal(part.slots(), whole.slots())
    assert abs(found.rate / whole.rate - 1) < 1e-5
    assert found.n == whole.n - whole.missing().sum()
    again = open_converted(tmp_path / name, least=10_000, progress=shares.clear, **units)
    assert shares and again.rows == found.rows  # not read a second time
    assert any("delete that file" in note for note in again.notes)


STAMPS = np.arange(9000) / 100 + 1.2345678
CLOCKS = {
    "one decimal": [f"{t:.1f}" for t in np.floor(STAMPS * 10) / 10],
    "a system's tick": [f"{t:.6f}" for t in np.floor(STAMPS * 64) / 64],
    "packets": [f"{k // 10 / 10 + 0.013 * (k // 10 * 7 % 5) / 5:.3f}" for k in range(9000)],
    "six digits": [f"{t + 950:.6g}" for t in STAMPS],
}


@pytest.mark.parametrize("clock", CLOCKS)
def test_a_coarse_clock_makes_no_gaps_between_the_parts(clock, monkeypatch, small, tmp_path):
    monkeypatch.setattr(parts, "TEXT", (1 << 18) + 1)  # the head, and a part behind it
    values = np.random.default_rng(3).normal(0.01, 0.002, (9000, 3))
    rows = (f"{t},{w[0]:.6f},{w[1]:.6f},{w[2]:.6f}\n" for t, w in zip(CLOCKS[clock], values))
    (tmp_path / "a.csv").write_text("time,gx,gy,gz\n" + "".join(rows))
    whole = read_record(tmp_path / "a.csv", gyro_unit="rad/s")
    found = open_converted(tmp_path / "a.csv", least=5000, gyro_unit="rad/s")
    assert found.rows == whole.n == 9000
    np.testing.assert_array_equal(found.part(0, 9000).slots(), whole.slots())
    assert found.rate == pytest.approx(whole.rate, rel=1e-4)
    assert len(found.notes) < 5


@pytest.mark.parametrize("apart", [1, 2, 5])
def test_rows_that_changed_places_between_two_parts_are_put_back(
    apart, monkeypatch, small, tmp_path
):
    monkeypatch.setattr(parts, "TEXT", (1 << 18) + 1)
    values = np.random.default_rng(3).normal(0.01, 0.002, (9000, 3))
    rows = [f"{k / 100:09.4f},{w[0]:+.6f},{w[1]:+.6f},{w[2]:+.6f}\n" for k, w in enumerate(values)]
    head = "time [s],gx [rad/s],gy [rad/s],gz [rad/s]\n"
    seam = ((1 << 18) + 1) // len(rows[0])  # the first row of the second part
    rows.insert(seam - 1, rows.pop(seam - 1 + apart))
    (tmp_path / "a.csv").write_text(head + "".join(rows))
    found = open_converted(tmp_path / "a.csv", least=5000)
    assert any("read in parts" in n for n in found.notes) and not len(found.steps)
    np.testing.assert_allclose(found.part(0, 9000)["gyro"], values, atol=1e-6)


def test_what_is_wrong_is_told_by_its_line_and_leaves_nothing(record, small, tmp_path):
    path = tmp_path / "a.csv"
    write_record(record, path)
    lines = path.read_text().splitlines(keepends=True)
    lines[15_000] = lines[15_000].replace(".", ".x", 1)
    path.write_text("".join(lines))
    with pytest.raises(InputError, match="line 15001"):
        open_converted(path, least=10_000)
    assert not list(converted.cache().iterdir())


def test_a_packed_log_that_is_cut_off(record, small, tmp_path):
    write_record(record, tmp_path / "a.csv")
    packed = gzip.compress((tmp_path / "a.csv").read_bytes())
    (tmp_path / "b.csv.gz").write_bytes(packed[: len(packed) // 2])
    with pytest.raises(InputError, match="cannot be unpacked to its end"):
        open_converted(tmp_path / "b.csv.gz", least=1000)


def test_short_files_and_other_kinds_are_left_to_the_readers(record, small, tmp_path):
    write_record(record, tmp_path / "a.csv")
    assert open_converted(tmp_path / "a.csv") is None
    (tmp_path / "log.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(1000))
    assert open_converted(tmp_path / "log.bag", least=1) is None


def test_a_damaged_or_empty_zarr_store_is_said(record, tmp_path):
    pytest.importorskip("zarr")
    path = tmp_path / "a.zarr"
    _zarr(record, path, 3)
    chunk = next(p for p in (path / "imu/gyro/c").rglob("*") if p.is_file())
    chunk.write_bytes(b"\0")
    with pytest.raises(InputError, match="is not a whole Zarr store"):
        read_record(path, **UNITS)
    (path / "zarr.json").write_text("{")
    with pytest.raises(InputError, match="is not a whole Zarr store"):
        read_record(path, **UNITS)
