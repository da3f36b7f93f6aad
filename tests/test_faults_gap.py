"""Faults in model files, in simulated records and before the competition of the gap workflow."""

import json

import numpy as np
import pytest

from imu_lib import faults
from imu_lib.cli.main import main
from imu_lib.errors import InputError
from imu_lib.gap import close
from imu_lib.gap.fault_masking import ready
from imu_lib.gap.fault_steps import DETECTED
from imu_lib.model import Model
from imu_lib.processes import from_json
from imu_lib.record import CHANNELS, Record

SENSOR = {
    c: [{"process": "white_noise", "N": 2e-4 if c.startswith("gyro") else 2e-3}] for c in CHANNELS
} | {"rate": 100.0}
SENSOR["accel_z"] = SENSOR["accel_z"] + [{"process": "constant", "value": -9.81}]
FAULTS = [
    {"process": "dropout", "fraction": 0.01, "value": 0, "period": 50, "channels": list(CHANNELS)},
    {
        "process": "disturbance",
        "start": 50,
        "duration": 0.4,
        "peak": [0.1, 1, 2],
        "channels": ["gyro_x", "accel_x", "accel_z"],
    },
    {"process": "tilt", "time": 150, "angles": [0.002, -0.003, 0.0], "duration": 2},
]


def test_what_a_model_file_says_of_faults_is_drawn_and_found_again():
    model = Model.from_json({**SENSOR, "record": FAULTS})
    assert Model.from_json(model.to_json()) == model
    record = model.simulate_record(30_000, 100.0, np.random.default_rng(1))
    found = {f.kind: f for f in faults.find(record)}
    assert set(found) == {"dropout", "disturbance", "tilt"}
    assert found["dropout"].parameters["period"] == 50
    # a binomial share of the 600 places
    assert found["dropout"].parameters["fraction"] == pytest.approx(0.01, abs=3 * 0.0004)
    assert found["disturbance"].start == pytest.approx(50.0, abs=0.1)
    assert found["tilt"].parameters["time"] == pytest.approx(150.0, abs=1.0)
    # gravity tells the tilt to 2e-3 sqrt(2 / 30 s) / 9.81 rad; wander of the sides on top
    assert found["tilt"].parameters["angles"] == pytest.approx([0.002, -0.003, 0.0], abs=4e-4)


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ({"process": "dropout", "fraction": 2, "channels": ["gyro_x"]}, "between 0 and 1"),
        ({"process": "dropout", "fraction": 0.1}, "missing"),
        ({"process": "disturbance", "start": 1, "duration": 1, "peak": [1, 2, 3]}, "peak"),
        ({"process": "tilt", "time": 1, "angles": [1, 2]}, "3 finite numbers"),
    ],
)
def test_wrong_entries_are_refused_by_name(entry, says):
    with pytest.raises(InputError, match=says):
        from_json(entry, on_record=True)


def test_copies_and_missing_values_are_drawn():
    rng = np.random.default_rng(2)
    x = {"gyro_x": rng.standard_normal(5000), "gyro_y": rng.standard_normal(5000)}
    entry = {"process": "dropout", "fraction": 0.02, "channels": ["gyro_x"]}
    lost = from_json(entry, on_record=True).act(x, 100.0, rng)
    assert np.isnan(lost["gyro_x"]).mean() == pytest.approx(0.02, abs=0.008)  # four sigma
    assert lost["gyro_y"] is x["gyro_y"]
    copied = from_json({**entry, "held": True}, on_record=True).act(x, 100.0, rng)
    assert np.mean(np.diff(copied["gyro_x"]) == 0) == pytest.approx(0.02, abs=0.008)


def test_both_doors_mask_what_is_found_and_name_it(tmp_path, capsys):
    """A row of zeros in two channels, one row in 57: nothing else comes of it."""
    rng = np.random.default_rng(3)
    n = 6000
    x = {c: 0.02 + 2e-3 * rng.standard_normal(n) for c in ("gyro_x", "gyro_y")}
    rows = np.arange(23, n, 57)
    for v in x.values():
        v[rows] = 0.0
    record = Record(x, 100.0)
    found = close(record, simulations=0, jobs=1)
    (step,) = found.record_steps
    assert step.effect == "dropout" and step.parameters["period"] == 57
    assert step.detected and step.gain is None and "rows" in step.evidence
    assert not [s for where, s in found.steps if where != "record"]
    assert [p.name for p in found.model.record] == ["dropout"]
    file, out = tmp_path / "zeros.npz", tmp_path / "gap.json"
    np.savez(file, time=np.arange(n) / 100.0, **x)
    assert main(["gap", str(file), "--simulations", "0", "--jobs", "1", "--json", str(out)]) == 0
    told = json.loads(out.read_text())
    assert [s["parameters"] for s in told["record"]["steps"]] == [step.to_json()["parameters"]]
    assert "taken as missing" in capsys.readouterr().err


def test_confidence_is_the_share_of_right_names_in_the_stored_score():
    from conftest import ROOT

    score = json.loads((ROOT / "benchmarks/results/fault_score.json").read_text())
    stored = {k: (v["of"], v["count"]) for k, v in score["right_of_those_named"].items()}
    assert stored == DETECTED


def test_the_means_of_half_a_minute_of_bursts_are_enough():
    """Four samples at 960 Hz, forty times a second, for 23 s: 930 bursts."""
    rng = np.random.default_rng(3)
    k = np.arange(3_720)
    time = (k // 4) * 0.025 + (k % 4) / 960
    channels = {c: 1e-3 * rng.standard_normal(k.size) for c in ("gyro_x", "gyro_y")}
    made = ready(Record(channels, 960.0, time=time))
    assert 900 <= made.record.n <= 930 and not made.left_out


def test_an_axis_that_another_one_repeats_is_told_and_left_out():
    rng = np.random.default_rng(7)
    x = {f"{k}_{a}": 1e-3 * rng.standard_normal(6000) for k in ("gyro", "accel") for a in "xyz"}
    x["gyro_y"] = -x["gyro_x"]
    found = [f for f in faults.find(Record(x, 100.0)) if f.kind == "copied"]
    assert [(f.channels, f.parameters) for f in found] == [
        (("gyro_y",), {"of": "gyro_x", "sign": -1})
    ]
    done = close(Record(x, 100.0), channels=["gyro_x", "gyro_y"], simulations=0, jobs=1)
    assert list(done.channels) == ["gyro_x"]
    assert "yro_y is gyro_x again" in done.to_json()["verdict"][1]


def test_two_long_knocks_in_half_a_minute_are_no_tail_of_the_noise():
    rng = np.random.default_rng(8)
    x = {c: 1e-3 * rng.standard_t(6, 6400) for c in ("gyro_x", "gyro_z", "accel_y")}
    u = np.arange(120) / 120
    for at in (3064, 5385):
        for c in x:
            x[c][at : at + 120] += 0.05 * np.exp(-4 * u) * np.sin(2 * np.pi * 6 * u + len(c))
    found = [f for f in faults.find(Record(x, 200.0)) if f.kind == "disturbance"]
    assert [round(f.start) for f in found] == [15, 27]
    calm = {c: 1e-3 * rng.standard_t(3.5, 6400) for c in x}
    assert not [f for f in faults.find(Record(calm, 200.0)) if f.kind == "disturbance"]
