"""Whatever is wrong with a file ends in one sentence on standard error and exit 2: no traceback,
nothing half-written.
"""

import builtins
import gzip
import io
import struct
import time
import zipfile

import numpy as np
import pytest

from imu_lib import archive, units
from imu_lib.cli.main import main
from imu_lib.errors import InputError
from imu_lib.readers import read_drive, read_record

HEAD = "time [s],gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s],accel_x [m/s^2],accel_y [m/s^2],accel_z [m/s^2]"


def values(n=300):
    rng = np.random.default_rng(11)
    accel = rng.normal(scale=2e-2, size=(n, 3)) - [0, 0, units.G]
    return np.column_stack([np.arange(n) / 100.0, rng.normal(scale=2e-3, size=(n, 3)), accel])


def lines(change=None):
    rows = [",".join(f"{v:.9g}" for v in row) for row in values()]
    if change:
        rows = change(rows) or rows
    return HEAD + "\n" + "\n".join(rows) + "\n"


def edit(row, column, text):
    def change(rows):
        fields = rows[row].split(",")
        fields[column] = text
        rows[row] = ",".join(fields)

    return change


def swap(rows):
    """Far apart: neighbours that changed places are put back."""
    rows[100], rows[201] = rows[201], rows[100]


def repeat_time(rows):
    rows[100] = rows[99].split(",")[0] + "," + rows[100].partition(",")[2]


TABLES = {
    "empty": ("", "empty"),
    "blank": ("\n\n  \n", "empty"),
    "one row": (HEAD + "\n" + lines().splitlines()[1] + "\n", "row"),
    "header only": (HEAD + "\n", "no rows of numbers"),
    "prose": ("It was a dark and stormy night,\nthe rain fell in torrents\n", "no rows of numbers"),
    "text in a number": (lines(edit(40, 3, "oops")), "line 42, column 4"),
    "unit in a number": (lines(edit(250, 6, "-9.8m")), "line 252, column 7"),
    "infinity": (lines(edit(17, 5, "inf")), "line 19"),
    "nan time": (lines(edit(30, 0, "nan")), "line 32"),
    "unsorted": (lines(swap), "line 203"),
    "repeated time": (lines(repeat_time), "line 102"),
    "constant time": (
        lines(lambda rows: ["1.0," + r.partition(",")[2] for r in rows]),
        "time stamps are 1",
    ),
    "a short line": (lines(edit(60, 6, "")).replace(",\n", "\n"), "line 62"),
    "a long line": (lines(edit(60, 6, "1.0,2.0")), "line 62"),
    "cut off in two": (lines()[:-30] + "\n" + lines()[-160:-40], "columns where"),
    "an empty column": (
        lines(lambda rows: [",".join([*r.split(",")[:2], "", *r.split(",")[3:]]) for r in rows]),
        "gyro_y",
    ),
    "unknown unit": (lines().replace("[rad/s]", "[furlong]"), "furlong"),
    "two units": (lines().replace("gyro_y [rad/s]", "gyro_y [deg/s]"), "different units"),
    "no unit": (lines().replace(" [rad/s]", ""), "--gyro-unit"),
    "wrong by 9.81": (lines().replace("[m/s^2]", "[g]"), "likely m/s^2"),
    "wrong by 57.3": (lines().replace("[rad/s]", "[deg/s]"), "likely rad/s"),
    "unknown columns": (lines().replace("gyro", "foo").replace("accel", "bar"), "--columns"),
    "a name too few": (lines().replace(",accel_z [m/s^2]", ""), "no header of 7 names"),
    "columns of one name": (lines().replace("gyro_y", "gyro_x"), "gyro_x"),
}


def refused(capsys, *argv, says=""):
    """The call ends with 2 and one sentence."""
    assert main([str(a) for a in argv]) == 2
    out, err = capsys.readouterr()
    assert (
        "Traceback" not in err
        and err.startswith("imu-lib")
        and len(err.strip().splitlines()) == 1
        and err.rstrip().endswith(".")
    ), err
    assert says in err, err
    return err


@pytest.mark.parametrize("name", TABLES)
def test_tables(tmp_path, capsys, name):
    text, says = TABLES[name]
    path = tmp_path / "bad.csv"
    path.write_text(text)
    if name == "repeated time":  # check reports it, everything else refuses it
        with pytest.raises(InputError, match=says):
            read_record(path)
        assert main(["check", str(path)]) == 0 and "repeated stamps  1" in capsys.readouterr().out
        return
    assert "bad.csv" in refused(capsys, "check", path, "--json", tmp_path / "out.json", says=says)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.csv"]


def test_three_bare_columns_are_told_how_to_be_named(tmp_path, capsys):
    path = tmp_path / "xyz.txt"
    path.write_text("\n".join(f"{x:.5f} {y:.5f} {z:.5f}" for x, y, z in values()[:, 1:4]))
    refused(capsys, "check", path, says="--gyro FILE or --accel FILE")
    assert main(["check", "--gyro", str(path), "--gyro-unit", "rad/s", "--rate", "100"]) == 0


def test_what_a_record_can_have_is_reported_instead(tmp_path, capsys):
    path = tmp_path / "gaps.csv"
    path.write_text(
        lines(
            lambda rows: [
                edit(50, 2, "nan")(rows),
                edit(51, 3, "")(rows),
                *rows[:200],
                *rows[230:],
            ][2:]
        )
    )
    assert main(["check", str(path)]) == 0
    out = capsys.readouterr().out
    assert "1 (30 samples missing)" in out and out.count("1 value is missing (NaN) on gyro_") == 2


def npz(path, **arrays):
    np.savez(path, **arrays)
    return path.read_bytes()


def lying(shape):
    """An .npz whose header announces more than it holds."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        stream, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("gyro.npy", stream.getvalue() + b"\0" * 800)
    return out.getvalue()


def binaries(tmp_path):
    good = npz(
        tmp_path / "x.npz", time=values()[:, 0], gyro=values()[:, 1:4], accel=values()[:, 4:]
    )
    (tmp_path / "x.npz").unlink()
    junk = np.random.default_rng(12).bytes(5000)
    yield "truncated.npz", good[:-2000], "truncated.npz"
    yield "torn.npz", good[:3000] + bytes(50) + good[3050:], ""
    yield "billion.npz", lying((1_000_000_000, 3)), "announces"
    yield "overflow.npz", lying((2**62, 3)), "announces"
    yield "junk.npz", junk, "junk.npz"
    yield "junk.csv", junk, "junk.csv"
    yield "junk.mat", junk, "junk.mat"
    yield "junk.parquet", junk, "junk.parquet"
    yield "junk.bag", b"#ROSBAG V2.0\n" + junk, "junk.bag"
    yield "junk.db3", b"SQLite format 3\0" + junk, "junk.db3"
    yield "junk.xyz", junk, "neither text nor"
    yield "hdf.mat", b"\x89HDF\r\n\x1a\n" + junk, "hdf.mat"
    yield "five.mat", b"MATLAB 5.0 MAT-file" + bytes(105) + b"\0\1IM" + junk, "five.mat"
    yield "empty.npz", b"", "empty"
    yield (
        "long.mat",
        b"MATLAB 5.0 MAT-file" + bytes(105) + b"\0\1IM" + struct.pack("<II", 14, 10**9),
        "long.mat",
    )
    yield "packed.csv.gz", gzip.compress(lines().encode())[:-200], "not a whole gzip file"
    yield "packed.7z", b"7z\xbc\xaf\x27\x1c" + junk, "unpack it first"
    yield "sheet.xlsx", b"PK\3\4" + junk, "save its sheet as .csv"
    yield "wide.csv", lines().encode("utf-32"), "UTF-8"
    yield "unmarked.csv", lines().encode("utf-16-le"), "UTF-8"
    yield (
        "nothing.npz",
        npz(tmp_path / "n.npz", gyro=np.zeros((0, 3)), time=np.zeros(0)),
        "no samples",
    )
    (tmp_path / "n.npz").unlink()
    for name, arrays, says in (
        ("none.npz", {"temperature": np.ones(9)}, "gyro"),
        ("text.npz", {"gyro": np.array([["a"] * 3] * 9)}, "numbers"),
        ("flat.npz", {"gyro": np.ones(9), "time": np.arange(9.0)}, "three axes"),
        ("lengths.npz", {"gyro": np.ones((9, 3)), "time": np.arange(8.0)}, "differ in length"),
        ("single.npz", {"gyro": np.ones((1, 3)), "time": np.zeros(1)}, "only 1 sample"),
        ("norate.npz", {"gyro": np.ones((9, 3)) * 1e-3}, "--rate"),
        ("complex.npz", {"gyro": np.ones((9, 3)) * 1j, "time": np.arange(9.0)}, "complex"),
        ("inf.npz", {"gyro_x": np.r_[np.ones(8), np.inf], "time": np.arange(9.0)}, "infinite"),
        (
            "ns.npz",
            {"gyro_x": np.ones(9) * 1e-3, "time": 10**18 + np.arange(9) * 10**7},
            "look like ns",
        ),
        ("falls.npz", {"gyro_x": np.ones(9) * 1e-3, "time": np.arange(9.0)[::-1]}, "falls"),
    ):
        content = npz(tmp_path / name, **arrays)
        (tmp_path / name).unlink()
        yield name, content, says
    stream = io.BytesIO()
    np.save(stream, np.array([{"a": 1}]), allow_pickle=True)
    yield "object.npy", stream.getvalue(), "objects"


def test_binary_files(tmp_path, capsys):
    for name, content, says in list(binaries(tmp_path)):
        path = tmp_path / name
        path.write_bytes(content)
        refused(capsys, "check", path, says=says)
        path.unlink()


def test_places_that_are_no_files(tmp_path, capsys, monkeypatch):
    refused(capsys, "check", tmp_path, says="directory")
    refused(capsys, "check", tmp_path / "missing.csv", says="does not exist")
    path = tmp_path / "locked.csv"
    path.write_text(lines())
    real = builtins.open

    def locked(file, *args, **kwargs):
        if str(file) == str(path):
            raise PermissionError(13, "Permission denied", str(path))
        return real(file, *args, **kwargs)

    monkeypatch.setattr(
        builtins, "open", locked
    )  # the superuser of a test machine may read everything
    refused(capsys, "check", path, says="permissions")


def test_no_memory(tmp_path, capsys, monkeypatch):
    path = tmp_path / "good.csv"
    path.write_text(lines())

    def none(*_, **__):
        raise MemoryError

    monkeypatch.setattr("imu_lib.readers.opening.read_text", none)
    refused(capsys, "check", path, says="memory")


def test_calls_that_cannot_be_meant(tmp_path, capsys):
    path = tmp_path / "good.csv"
    path.write_text(lines())
    assert main(["check", str(path)]) == 0
    capsys.readouterr()
    for argv, says in (
        (["check"], "one file"),
        (["check", path, "--gyro", path], "not both"),
        (["check", path, "--rate", "-1"], "above 0"),
        (["check", path, "--rate", "abc"], "not a number"),
        (["check", path, "--rate", "300"], "--rate"),
        (["check", path, "--gyro-unit", "furlong"], "furlong"),
        (["check", path, "--gyro-unit", "deg/s"], "likely rad/s"),
        (["check", path, "--gyro-unit", "counts:0"], "counts per"),
        (["check", path, "--columns", "time,gyro_x"], "7 columns"),
        (["check", path, "--start", "5", "--stop", "4"], "--stop"),
        (["check", path, "--start", "500"], "--start"),
        (["check", path, "--json", tmp_path / "no" / "x.json"], "no folder"),
        (["check", path, "--json", tmp_path], "directory"),
        (["chek", path], "invalid choice"),
        (["check", path, "--gyr", "x"], "nrecognized arguments"),
    ):
        refused(capsys, *argv, says=says)
    with pytest.raises(InputError, match="no drive"):
        read_drive(path)


def test_headers_are_parsed_one_at_a_time(tmp_path, monkeypatch):
    # Two syntax trees built at once are a SystemError in CPython 3.11, which a reader of a whole
    # file saw now and then.
    inside, most = [], []
    parse = archive.npy.read_array_header_1_0

    def watched(stream):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.01)
        inside.pop()
        return parse(stream)

    monkeypatch.setattr(archive.npy, "read_array_header_1_0", watched)
    np.savez(tmp_path / "many.npz", **{f"a{k}": np.arange(k) for k in range(8)})
    found = archive.load_arrays(tmp_path / "many.npz")
    assert [len(found[f"a{k}"]) for k in range(8)] == list(range(8))
    assert max(most) == 1
