"""Flags that the call cannot heed, names that are misspelled, fleets of nothing: one sentence, exit 2."""

import json

import numpy as np
import pytest

from imu_lib.cli import main as cli


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("flags")
    rng = np.random.default_rng(1)
    n = 600
    gyro, accel = rng.normal(0, 2e-3, (n, 3)), rng.normal(0, 2e-2, (n, 3)) + [0, 0, 9.81]
    time = np.arange(n) / 100
    np.savez(folder / "r.npz", time=time, gyro=gyro, accel=accel)
    rows = np.column_stack([time, gyro, accel])
    head = "t [s],a,b,c,d,e,f\n"
    text = head + "\n".join(",".join(f"{v:.7f}" for v in r) for r in rows) + "\n"
    (folder / "r.csv").write_text(text)
    place = np.tile([0.8, 0.1, 200.0], (6, 1))
    fixes = {"gnss_time": np.arange(6.0), "gnss_position": place}
    np.savez(folder / "drive.npz", time=time, gyro=gyro, accel=accel, **fixes)
    fixes = {"gnss_time": np.zeros(1), "gnss_position": place[:1]}
    np.savez(folder / "one_fix.npz", time=time, gyro=gyro, accel=accel, **fixes)
    (folder / "words.csv").write_text("no numbers,here\na,b\n")
    (folder / "cut.json").write_text('{"gyro_x": [{"process":')
    (folder / "gone.csv").write_text("file,sensor\nnope.csv,S1\nneither.csv,S2\n")
    (folder / "bad.csv").write_text("file,sensor\nwords.csv,S1\n")
    return folder


@pytest.fixture
def here_alone(monkeypatch):
    """A fleet's records one after the other in this process."""

    def run(work, tasks, **_):
        return ((i, work(*task)) for i, task in enumerate(tasks))

    monkeypatch.setattr("imu_lib.scheduler.run", run)


NAMES = "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,"
UNITS = "--gyro-unit rad/s --accel-unit m/s^2"
REFUSED = [
    ("check {}/r.npz --topic /imu", "leave --topic /imu out"),
    (f"check {{}}/r.csv {UNITS} --columns {NAMES}accel_z --topic /imu", "leave --topic /imu out"),
    ("gap {}/r.npz --heading 40", "--heading: ", "a record without fixes"),
    ("gap {}/r.npz --gnss-offset 5 --heading 4", "--heading and --gnss-offset: "),
    ("check {}/drive.npz --only gyro", "--only: a drive needs gyro and accelerometer"),
    ("gap {}/drive.npz --only gyro", "--only: a drive needs gyro and accelerometer"),
    ("book {}/drive.npz --start 3 --rate 100", "--start and --rate: the book takes the drive"),
    ("compare preset:isis-imu preset:isis-imu --start 3", "--start: A and B are models"),
    ("check {}/r.npz --start -5", "-5 is below 0"),
    ("outages {}/drive.npz --start -5", "-5 is below 0"),
    (f"check {{}}/r.csv {UNITS} --columns {NAMES}acel_z", "write accel_z, or - to skip it"),
    (f"check {{}}/r.csv {UNITS} --columns {NAMES}acceel_z[g]", "accel_z"),
    (f"check {{}}/r.csv {UNITS} --columns tiem,{NAMES[5:]}accel_z", "(time is near)"),
    (f"check {{}}/r.csv {UNITS} --columns {NAMES}roll", "no column name; use"),
    ("check {}/one_fix.npz", "holds 1; write the times of all fixes there"),
    ("gap {}/r.npz --model {}/cut.json", "cut off: write it anew"),
    ("fleet {}/gone.csv --out {}/f", "gone.csv, line 2: ", "nope.csv does not exist"),
    ("fleet {}/bad.csv --out {}/g --workers 1", "bad.csv, line 2: ", "words.csv"),
]


@pytest.mark.parametrize("call, said", [(c, s) for c, *s in REFUSED], ids=lambda x: str(x)[:50])
def test_one_sentence_and_nothing_done(made, capsys, here_alone, call, said):
    assert cli.main(call.replace("{}", str(made)).split()) == 2
    told = capsys.readouterr()
    assert told.out == ""
    last = told.err.splitlines()[-1]
    assert all(part in last for part in said), told.err
    for folder in ("f", "g"):
        assert not (made / folder / "fleet.parquet").exists()
        assert not (made / folder / "fleet.json").exists()


@pytest.mark.parametrize("z", ["accel_z", "acc_z", "az", "Accel_Z[m/s^2]", "accelerometer_z"])
def test_right_names_are_taken(made, capsys, z):
    call = f"check {made}/r.csv {UNITS} --columns {NAMES}{z} --json -"
    assert cli.main(call.split()) == 0, capsys.readouterr().err
    assert json.loads(capsys.readouterr().out)["columns"][-1]["read_as"] == "accel_z"


def test_a_fleet_goes_on_without_a_missing_record(made, capsys, here_alone, monkeypatch):
    """The line of the manifest is named, and the table is that of the others."""
    from imu_lib.fleet import rows

    found = rows._found
    monkeypatch.setattr(
        rows, "_found", lambda e, gap: [rows._row(e)] if "r.npz" in e.path else found(e, gap)
    )
    (made / "some.csv").write_text("file\nr.npz\nnope.csv\n")
    assert cli.main(["fleet", f"{made}/some.csv", "--out", f"{made}/h"]) == 0
    assert f"left out: {made}/some.csv, line 3: " in capsys.readouterr().err
    assert (made / "h" / "fleet.parquet").exists()
