"""A fleet: one table, whatever ends the work; and what the table answers."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
from ending_task import dies

from imu_lib import InputError, fleet, scheduler
from imu_lib.cli.main import main
from imu_lib.fleet.spread import of_units, widening
from imu_lib.model import Model
from imu_lib.writers import write_record

MODEL = Model.from_json({"gyro_x": [{"process": "white_noise", "N": 1e-4}]})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six short records of three sensors, and a file that is none."""
    place = tmp_path_factory.mktemp("fleet")
    for unit in range(3):
        for day in (1, 2):
            rng = np.random.default_rng([unit, day])
            record = MODEL.simulate_record(1500, 50.0, rng)
            write_record(record, place / f"unit{unit}_2024-05-0{day}.npz")
    (place / "broken.npz").write_bytes(b"PK\x03\x04 no more than this")
    return place


@pytest.fixture(scope="module")
def table(folder, tmp_path_factory):
    """The bytes of the table as one worker makes it."""
    out = tmp_path_factory.mktemp("one")
    assert main(["fleet", str(folder), "--out", str(out), "--workers", "1"]) == 0
    return (out / "fleet.parquet").read_bytes(), out


def command(folder, out, *more):
    call = [sys.executable, "-m", "imu_lib", "fleet", str(folder), "--out", str(out), *more]
    return subprocess.Popen(call, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_table(table):
    rows = fleet.load(table[1])
    assert rows.sensor.nunique() == 4 and set(rows.date.dropna()) == {"2024-05-01", "2024-05-02"}
    broken = rows[rows.error.notna()]
    assert len(broken) == 1 and "broken.npz" in broken.error.iloc[0]
    white = rows[(rows.method == "likelihood") & (rows.coefficient == "N")]
    assert len(white) == 6
    assert np.all((white.low < white.value) & (white.value < white.high))
    assert white.value.to_numpy() == pytest.approx(1e-4, rel=0.15)  # 2 % is one standard error
    told = json.loads((table[1] / "fleet.json").read_text())
    assert told["sensors"] == 3 and any("1 sensor (broken)" in note for note in told["notes"])
    assert Model.load(table[1] / "model.json")["gyro_x"].find("white_noise")


@pytest.mark.skipif("IMU_LIB_SLOW" not in os.environ, reason="takes minutes: set IMU_LIB_SLOW=1")
@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up in /proc")
def test_killed_at_any_moment_nothing_is_lost_and_nothing_twice(folder, table, tmp_path):
    """kill -9 of the command, then of a worker, then to the end: the table of one quiet run."""
    out = tmp_path / "out"
    run = command(folder, out, "--workers", "2")
    _until(lambda: len(list(out.glob("records/*.json"))) >= 2, run)
    run.send_signal(signal.SIGKILL)
    run.communicate()
    before = {p.name: p.stat().st_mtime_ns for p in out.glob("records/*.json")}
    assert 2 <= len(before) < 7
    run = command(folder, out, "--workers", "2")
    worker = _until(lambda: _children(run.pid), run)
    os.kill(worker[-1], signal.SIGKILL)
    run.communicate()
    assert run.returncode == 0
    assert (out / "fleet.parquet").read_bytes() == table[0]
    kept = {p.name: p.stat().st_mtime_ns for p in out.glob("records/*.json")}
    assert len(kept) == 7 and all(kept[name] == moment for name, moment in before.items())


def _until(found, run):
    for _ in range(1200):
        if result := found():
            return result
        assert run.poll() is None, run.communicate()
        time.sleep(0.05)
    raise AssertionError("nothing came")


def _children(pid):
    """Processes that work for the command, not the tracker of its semaphores."""
    out = []
    for thread in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{thread}/children") as file:
            out += [int(child) for child in file.read().split()]
    said = {}
    for child in out:
        try:
            with open(f"/proc/{child}/cmdline") as file:
                said[child] = file.read()
        except OSError:
            continue
    return [child for child, text in said.items() if "popen_loky" in text]


@pytest.mark.skipif(os.name == "nt", reason="Windows has no kill -9")
def test_a_task_that_ends_its_workers_is_told_apart(tmp_path):
    tasks = [(n, str(tmp_path)) for n in range(5)]
    found = dict(scheduler.run(dies, tasks, workers=2))
    assert isinstance(found.pop(1), scheduler.Lost)
    assert found == {0: 0, 2: 2, 3: 3, 4: 4}


def test_dask_makes_the_same_table(folder, table, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0"
    ) as cluster:
        entries = fleet.entries(folder)
        out = fleet.characterise(entries, tmp_path, address=cluster.scheduler_address)
    assert out.read_bytes() == table[0]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name\na.npz\n", "no column `file`"),
        ("file,gyro units\na.npz,deg/s\n", "where `gyro_unit` is meant"),
        ("file,rate\na.npz,quick\n", "line 2"),
        ("file\na.npz\na.npz\n", "line 3"),
        ("file,date\na.npz,yesterday\n", "2024-05-01"),
        ("file\n", "names no record"),
        ("file,date\na.npz,2026-13-45\n", "line 2"),
        ("file,rate\na.npz,-50\n", "above 0"),
        ("file,sensor\na.npz,S1,surplus\n", "more fields"),
        ("\n\nfile,sensor\n\na.npz,S1\n./a.npz,S2\n", "line 6"),
    ],
)
def test_a_manifest_that_is_wrong(text, says, tmp_path):
    (tmp_path / "fleet.csv").write_text(text)
    with pytest.raises(InputError, match=says):
        fleet.entries(tmp_path / "fleet.csv")


def test_manifest_and_names(tmp_path):
    (tmp_path / "fleet.csv").write_text(
        "file,sensor,date,rate\na.npz,left,2024-01-02,100\nb.npz,,,\n"
    )
    one, two = fleet.entries(tmp_path / "fleet.csv", gyro_unit="deg/s")
    assert (one.sensor, one.date, one.reading) == (
        "left",
        "2024-01-02",
        {"rate": 100.0, "gyro_unit": "deg/s"},
    )
    assert (two.sensor, two.date, two.reading) == ("b", "", {"gyro_unit": "deg/s"})
    assert not one.note and not two.note
    with pytest.raises(InputError, match="no record"):
        fleet.entries(_made(tmp_path / "empty"))


def test_columns_of_a_manifest_that_say_nothing_are_told(tmp_path):
    (tmp_path / "fleet.csv").write_text("file,operator,temperature,sensor\na.npz,Ann,21,left\n")
    (one,) = fleet.entries(tmp_path / "fleet.csv")
    assert one.sensor == "left" and one.reading == {}
    assert "no use for `operator` and `temperature`" in one.note


def test_the_table_of_an_earlier_run_is_no_record(folder, table, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "fleet.parquet").write_bytes(table[0])
    (tmp_path / "a.npz").write_bytes((folder / "unit0_2024-05-01.npz").read_bytes())
    assert [entry.file for entry in fleet.entries(tmp_path)] == ["a.npz"]


def _made(path):
    path.mkdir()
    return path


def fleet_of(rng, units, days, *, scatter=0.2, day=0.0, error=0.05, growth=0.0, absent=0.0):
    """A table as a fleet makes it, of log-normal coefficients, typical value 1."""
    rows = []
    for unit in range(units):
        true = scatter * rng.standard_normal()
        for k in range(days):
            y = true + day * rng.standard_normal() + error * rng.standard_normal() + growth * k
            half = 1.959964 * error
            row = dict.fromkeys(fleet.rows.COLUMNS) | {
                "sensor": f"u{unit}",
                "file": f"u{unit}_{k}",
                "date": f"{2020 + k}-06-01",
                "channel": "gyro_x",
                "method": "likelihood",
                "coefficient": "N",
            }
            if rng.random() < absent:
                row |= {"low": 0.0, "high": float(np.exp(true + 0.5))}
            else:
                row |= dict(zip(("value", "low", "high"), np.exp([y, y - half, y + half])))
            rows.append(row)
    return pd.DataFrame(rows)


ASKED = ("gyro_x", "likelihood", "N")


def test_spread_takes_the_error_of_the_estimates_off():
    """200 fleets: intervals of 95 % hold the truth, the bound is above 95 % of all units."""
    rng = np.random.default_rng(0)
    held = np.zeros(3)
    for _ in range(200):
        y = 0.2 * rng.standard_normal(15)
        s = rng.uniform(0.02, 0.3, 15)
        value = y + s * rng.standard_normal(15)
        found = of_units(*(np.exp(value + k * 1.959964 * s) for k in (0, -1, 1)))
        held += [found.typical.covers(1.0), found.scatter.covers(0.2), found.worst > np.exp(0.329)]
    # 0.95 with a standard error of 0.015; the bound is one-sided
    assert np.all(held / 200 > 0.90), held / 200


def test_spread_of_what_some_units_do_not_show():
    rng = np.random.default_rng(1)
    y, s = 0.3 * rng.standard_normal(60), 0.05
    value = np.where(y > -0.2, np.exp(y), np.nan)  # the smaller ones hide below a limit
    high = np.where(y > -0.2, np.exp(y + 1.96 * s), np.exp(-0.2))
    low = np.where(y > -0.2, np.exp(y - 1.96 * s), 0.0)
    found = of_units(value, low, high)
    assert found.shown < found.units == 60
    assert found.typical.covers(1.0) and found.scatter.covers(0.3)
    naive = of_units(*(v[y > -0.2] for v in (value, low, high)))
    assert naive.typical.low > 1.0  # those that show it are not all
    assert of_units(value[:2], low[:2], high[:2]) is None


def test_outliers_and_false_alarms():
    rng = np.random.default_rng(2)
    alarms = sum(len(fleet.outliers(fleet_of(rng, 12, 1), *ASKED)) > 0 for _ in range(20))
    assert alarms < 6  # 1 expected; 6 has a chance of one in three thousand
    table = fleet_of(rng, 12, 1)
    table.loc[table.sensor == "u7", ["value", "low", "high"]] *= 4.0
    found = fleet.outliers(table, *ASKED)
    assert list(found.index) == ["u7"] and found.ratio.iloc[0] > 2


def test_drift_and_sensor_against_day():
    rng = np.random.default_rng(3)
    steady = [fleet.drift(fleet_of(rng, 5, 4, day=0.3), *ASKED) for _ in range(150)]
    assert np.mean([d.covers(0.0) for d in steady]) > 0.90  # 0.95 +- 0.018
    growing = fleet.drift(fleet_of(rng, 10, 5, growth=0.1), *ASKED)
    assert growing.low > 0.05 and growing.high < 0.15
    assert fleet.drift(fleet_of(rng, 2, 3), *ASKED) is None
    both = [
        fleet.sensor_and_day(fleet_of(rng, 12, 4, scatter=0.3, day=0.1), *ASKED) for _ in range(10)
    ]
    assert np.median([b["sensor"].value for b in both]) == pytest.approx(0.3, rel=0.15)
    assert np.median([b["day"].value for b in both]) == pytest.approx(0.1, rel=0.15)
    assert np.mean([b["sensor"].covers(0.3) and b["day"].covers(0.1) for b in both]) > 0.7
    assert both[0]["error"] == pytest.approx(0.05)


def test_fleet_model_draws_its_fleet(table):
    model = fleet.summary(fleet.load(table[1])).model
    scatter = model.extra["spread"]["gyro_x"]["N"]["scatter"]
    rng = np.random.default_rng(0)
    drawn = [np.log(fleet.draw(model, rng)["gyro_x"].find("white_noise").N) for _ in range(400)]
    assert np.std(drawn) == pytest.approx(scatter, rel=0.1)
    again = Model.from_json(model.to_json())
    assert again.extra["spread"] == model.extra["spread"]


def test_shares():
    table = fleet_of(np.random.default_rng(0), 10, 1)
    effects = table.assign(coefficient=None, effect="white", confidence=0.99)
    effects.loc[:2, "effect"] = "white + flicker"
    found = fleet.shares(pd.concat([table, effects])).set_index("effect")
    assert found.loc["white + flicker", "found"] == 3 and found.loc["white", "asked"] == 10
    # Clopper and Pearson (1934), 3 of 10
    assert found.loc["white + flicker", "low"] == pytest.approx(0.0667, abs=1e-3)
    assert found.loc["white + flicker", "high"] == pytest.approx(0.6525, abs=1e-3)


def test_scatter_of_uneven_units_is_known_less_well():
    rng = np.random.default_rng(4)
    even = rng.standard_normal(40)
    assert widening(even) < 1.3
    assert widening(np.append(even, 8.0)) > 3  # one unit carries half of the variance
    assert widening(np.ones(9)) == widening(even[:3]) == 1.0
    y = 0.2 * np.append(even, 8.0)
    value = [np.exp(y + k * 1.96 * 0.02) for k in (0, -1, 1)]
    ratio = of_units(*value).scatter.high / of_units(*value).scatter.low
    without = of_units(*(v[:-1] for v in value))
    assert ratio > 1.5 * without.scatter.high / without.scatter.low
