"""Folders of logs stranger than the world: each is one record, or one sentence."""

import gc
import gzip
import shutil
from pathlib import Path

import numpy as np
import pytest

from imu_lib import InputError
from imu_lib.long_record import open_folder
from imu_lib.model import Model
from imu_lib.record import Record
from imu_lib.writers import write_record

N, FS = 600, 50.0
WHITE = {"process": "white_noise", "N": 1e-3}
SIGNALS = Model.from_json(
    {"gyro_x": [WHITE], "accel_z": [WHITE, {"process": "constant", "value": -9.8}]}
).simulate(5 * N, FS, np.random.default_rng(1))


def write(path, k, *, start=None, rate=FS, count=N, scale=1.0, order=None, unit="rad/s"):
    """Log k of a row, in text with absolute stamps."""
    rows = slice(k * N, k * N + count)
    time = (k * N / FS if start is None else start) + np.arange(count) / rate
    columns = {
        "time [s]": time,
        f"gyro_x [{unit}]": SIGNALS["gyro_x"][rows] * scale,
        "accel_z [m/s^2]": SIGNALS["accel_z"][rows],
    }
    names = list(columns) if order is None else [list(columns)[i] for i in order]
    with open(path, "w") as file:
        file.write(",".join(names) + "\n")
        np.savetxt(file, np.column_stack([columns[n] for n in names]), delimiter=",", fmt="%.12g")


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "logs"
    place.mkdir()
    for k in range(4):
        write(place / f"log_{k + 8}.csv", k)  # 8, 9, 10, 11: not in the order of their letters
    return place


def packed(folder):
    (folder / "log_9.csv.gz").write_bytes(gzip.compress((folder / "log_9.csv").read_bytes()))
    (folder / "log_9.csv").unlink()


def linked(folder):
    (folder / "log_9.csv").rename(folder.parent / "elsewhere.csv")
    (folder / "log_9.csv").symlink_to(folder.parent / "elsewhere.csv")


WHOLE = {
    "as it is": lambda f: None,
    "one of them packed": packed,
    "one of them a link": linked,
    "other order of columns": lambda f: write(f / "log_9.csv", 1, order=[2, 0, 1]),
    "other unit": lambda f: write(f / "log_9.csv", 1, unit="deg/s", scale=180 / np.pi),
    "a note beside": lambda f: (f / "README.txt").write_text("of Tuesday"),
    "a system's own file": lambda f: (f / "._log_9.csv").write_bytes(b"\0\1\2"),
}


@pytest.mark.parametrize("case", WHOLE)
def test_one_record(case, folder):
    WHOLE[case](folder)
    record = open_folder(folder)
    assert (record.rows, len(record.steps)) == (4 * N, 0)
    got = record.in_memory()
    for name, x in got.channels.items():
        np.testing.assert_allclose(x, SIGNALS[name][: 4 * N], rtol=1e-9, atol=1e-13)
    assert any("README.txt" in n for n in record.notes) == (case == "a note beside")


def test_a_missing_hour_is_a_gap_and_a_restart_is_said(folder):
    (folder / "log_9.csv").unlink()
    record = open_folder(folder)
    assert record.steps.tolist() == [[N, N]]
    write(folder / "log_10.csv", 2, start=0.0)
    write(folder / "log_11.csv", 3, start=N / FS)
    record = open_folder(folder)
    assert len(record.steps) == 1
    assert any("begins anew (log_10.csv)" in n for n in record.notes)


def test_rows_written_again_at_the_head_of_the_next_log_are_used_once(folder):
    for k in (1, 2):
        before = (folder / f"log_{k + 7}.csv").read_text().splitlines()[-50:]
        head, rows = (folder / f"log_{k + 8}.csv").read_text().split("\n", 1)
        (folder / f"log_{k + 8}.csv").write_text("\n".join([head, *before, rows]))
    record = open_folder(folder)
    assert (record.rows, len(record.steps), record.seams) == (4 * N, 0, ())
    np.testing.assert_allclose(record.in_memory()["gyro_x"], SIGNALS["gyro_x"][: 4 * N], rtol=1e-9)
    assert "50, 50 rows of log_9.csv, log_10.csv" in record.notes[-1]


@pytest.mark.parametrize("zero", [0.0, 1.7e9])
def test_logs_whose_names_are_in_another_order_go_by_their_stamps(zero, folder):
    for k in range(4):
        write(folder / f"log_{k + 8}.csv", k, start=zero + k * N / FS)
    (folder / "log_8.csv").rename(folder / "log_12.csv")
    record = open_folder(folder)
    assert (record.rows, len(record.steps), record.seams) == (4 * N, 0, ())
    np.testing.assert_allclose(record.in_memory()["gyro_x"], SIGNALS["gyro_x"][: 4 * N], rtol=1e-9)
    assert "order of their stamps" in record.notes[-1] and "log_12.csv, log_9" in record.notes[-1]


def cut(folder):
    text = (folder / "log_9.csv").read_bytes()
    middle = text.rfind(b"\n", 0, len(text) // 2)
    (folder / "log_9.csv").write_bytes(text[: middle + 5] + text[text.index(b"\n", middle + 5) :])


def dangling(folder):
    (folder / "log_9.csv").unlink()
    (folder / "log_9.csv").symlink_to(folder / "nowhere.csv")


REFUSED = {
    "line": cut,
    "link to a file that is not there": dangling,
    "is empty": lambda f: (f / "log_9.csv").write_text(""),
    "holds what the log before it holds": lambda f: shutil.copy(f / "log_9.csv", f / "log_10.csv"),
    "logs of one record have one rate": lambda f: write(f / "log_9.csv", 1, rate=2 * FS),
    "logs of one record have the same": lambda f: write_record(
        Record({"gyro_x": SIGNALS["gyro_x"][:N]}, FS), f / "log_9.csv"
    ),
}


@pytest.mark.parametrize("says", REFUSED)
def test_one_sentence(says, folder):
    REFUSED[says](folder)
    with pytest.raises(InputError, match=says) as error:
        open_folder(folder)
    assert "log_" in str(error.value)
    assert "give --rate" not in str(error.value)  # their stamps tell it


def test_the_samples_on_the_disk_go_with_the_record(folder):
    record = open_folder(folder)
    (place,) = {column.source.path for column in record.columns.values()}
    assert Path(place).is_dir()
    del record
    gc.collect()
    assert not Path(place).exists()
