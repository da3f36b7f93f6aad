"""Which records a folder or a manifest holds: sensors and dates from names, logs from stamps."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from imu_lib import InputError, fleet
from imu_lib.cli.fleet import understood
from imu_lib.fleet.names import a_date, sensor_and_date

FS, N = 50.0, 500


def _file(path, start=0.0, seed=0):
    path.parent.mkdir(parents=True, exist_ok=True)
    x = np.random.default_rng(seed).normal(1e-3, 2e-4 * np.sqrt(FS), N)
    np.savez(path, time=start + np.arange(N) / FS, gyro_x=x)


def _told(folder, **options):
    return {e.file: (e.sensor, e.date) for e in fleet.entries(folder, **options)}


@pytest.mark.parametrize(
    ("stem", "sensor", "date"),
    [
        ("unit12_2024-05-01", "unit12", "2024-05-01"),
        ("unit12_20240501", "unit12", "2024-05-01"),
        ("unit12_01.05.2024", "unit12", "2024-05-01"),
        ("2024-05-01 unit12", "unit12", "2024-05-01"),
        ("unit12_2024-05-01_2", "unit12", "2024-05-01"),
        ("unit12_20240501_143000", "unit12", "2024-05-01"),
        ("unit12_2024-05-01_run3", "unit12", "2024-05-01"),
        ("imu_2024-05-01_SN7", "imu_SN7", "2024-05-01"),
        ("unit_2024-13-45", "unit_2024-13-45", ""),
        ("unit12", "unit12", ""),
    ],
)
def test_a_name_says_sensor_and_date(stem, sensor, date):
    assert sensor_and_date(stem) == (sensor, date)


def test_dates_as_they_are_written():
    assert (
        a_date("2024-05-01T08:00:00") == a_date("1.5.2024") == a_date("2024/05/01") == "2024-05-01"
    )
    assert a_date("2024-13-01") == a_date("05/01/2024") == a_date("") == ""


def test_a_folder_of_consecutive_logs_is_one_record(tmp_path):
    for unit in range(3):
        for date in ("2026-01-10", "2026-02-10"):
            for k in range(3):
                path = tmp_path / "in" / f"Ü {unit}" / date / f"log_{k + 1}.npz"
                _file(path, k * N / FS, seed=10 * unit + k)
    found = _told(tmp_path / "in")
    assert len(found) == 6 and found["Ü 1/2026-02-10"] == ("Ü 1", "2026-02-10")
    assert len(_told(tmp_path / "in", record="file")) == 18
    one = tmp_path / "in" / "Ü 0"
    assert set(_told(one).values()) == {("Ü 0", "2026-01-10"), ("Ü 0", "2026-02-10")}
    with pytest.raises(InputError, match="is one record.*imu-lib characterise"):
        fleet.entries(one / "2026-01-10")
    rows = fleet.rows.of_record(fleet.entries(one)[0])
    assert not rows[0]["error"] and rows[0]["duration"] == pytest.approx(3 * N / FS, abs=0.1)
    assert {row["sensor"] for row in rows} == {"Ü 0"}


def test_a_file_is_read_once_for_its_stamps(tmp_path, monkeypatch):
    # where the unit was open each was read twice
    from imu_lib.readers import opening

    read, seen = opening.read_raw, []
    monkeypatch.setattr(
        opening, "read_raw", lambda path, **how: seen.append(path.name) or read(path, **how)
    )
    for k in range(2):
        rows = np.column_stack([k * 10 + np.arange(N) / FS, np.full((N, 3), 0.1 * k)])
        path = tmp_path / "unit" / f"log_{k}.csv"
        path.parent.mkdir(exist_ok=True)
        np.savetxt(path, rows, delimiter=",", header="time,gx,gy,gz", comments="")
    assert list(_told(tmp_path)) == ["unit"] and seen == ["log_0.csv", "log_1.csv"]


def test_stamps_that_begin_anew_are_said(tmp_path):
    for unit in range(2):
        for k in range(2):
            _file(tmp_path / f"unit{unit}" / f"log_{k}.npz")
    found = fleet.entries(tmp_path)
    assert [e.sensor for e in found] == ["unit0", "unit0", "unit1", "unit1"]
    assert "--record folder" in found[0].note
    assert _told(tmp_path, record="folder") == {"unit0": ("unit0", ""), "unit1": ("unit1", "")}


def test_sensors_of_subfolders(tmp_path):
    """A date's folder, a lot's folder, a sensor's folder."""
    for date in ("2026-01-10", "2026-07-10"):
        for unit in range(3):
            _file(tmp_path / "a" / date / f"unit {unit}.npz")
    assert _told(tmp_path / "a")["2026-07-10/unit 2.npz"] == ("unit 2", "2026-07-10")
    assert {e.sensor for e in fleet.entries(tmp_path / "a")} == {"unit 0", "unit 1", "unit 2"}
    for lot in range(2):
        for unit in range(3):
            _file(tmp_path / "b" / f"lot {lot}" / f"SN{3 * lot + unit}.npz")
    assert _told(tmp_path / "b")["lot 1/SN4.npz"] == ("lot 1/SN4", "")
    assert any("--sensor folder" in e.note for e in fleet.entries(tmp_path / "b"))
    assert _told(tmp_path / "b", sensor="folder")["lot 1/SN4.npz"] == ("lot 1", "")
    for unit in range(2):
        _file(tmp_path / "c" / f"unit{unit}" / "2026-01-10.npz")
        _file(tmp_path / "c" / f"unit{unit}" / f"unit{unit}_2026-07-10.npz")
    assert _told(tmp_path / "c")["unit1/unit1_2026-07-10.npz"] == ("unit1", "2026-07-10")
    assert {e.sensor for e in fleet.entries(tmp_path / "c")} == {"unit0", "unit1"}


def test_manifests_as_laboratories_write_them(tmp_path):
    _file(tmp_path / "Daten" / "log 1.npz")
    lines = "\ufeffFile;Sensor;Date;Rate\r\n\r\nDaten\\log 1.npz;Gerät 1;10.01.2026;50,0\r\n"
    for encoding in ("utf-8", "cp1252"):
        text = lines if encoding == "utf-8" else lines[1:]
        (tmp_path / "fleet.csv").write_bytes(text.encode(encoding))
        (one,) = fleet.entries(tmp_path / "fleet.csv")
        assert (one.sensor, one.date, one.reading) == ("Gerät 1", "2026-01-10", {"rate": 50.0})
        assert one.where.endswith("line 3")
    with pytest.raises(InputError, match="--record"):
        fleet.entries(tmp_path / "fleet.csv", record="folder")


def test_a_line_may_take_a_part_of_a_folder_of_logs(tmp_path):
    for k in range(3):
        _file(tmp_path / "logs" / f"log_{k + 1}.npz", k * N / FS, seed=k)
    (tmp_path / "fleet.csv").write_text("file,start,stop\nlogs,5,20\n")
    rows = fleet.rows.of_record(*fleet.entries(tmp_path / "fleet.csv"))
    assert not rows[0]["error"] and rows[0]["duration"] == pytest.approx(15.0, abs=0.1)


def test_the_command_says_how_names_were_understood(tmp_path):
    for unit in range(3):
        for k in range(2):
            _file(tmp_path / f"unit{unit}" / f"log_{k}.npz", seed=10 * unit + k)
    entries = fleet.entries(tmp_path)
    said = understood(entries)
    assert said == "records: 6, sensors: 3, dates: 0; unit0/log_0.npz is of unit0, no date"
    rows = [fleet.rows.of_record(replace(e, path="nowhere"))[0] for e in entries]
    assert "--record folder" in fleet.summary(pd.DataFrame(rows), [entries[0].note]).text()
