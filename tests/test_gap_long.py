"""The gap workflow on a record that stays on disk: two views and the windows unlike the rest."""

import sys

import numpy as np
import pytest

from imu_lib import gap, long_record
from imu_lib.gap import long
from imu_lib.gap.long import looked_at
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.record import Record
from imu_lib.writers import write_record

FS, N = 50.0, 400_000
MODEL = Model.from_json(
    {
        "gyro_x": [
            {"process": "white_noise", "N": 1e-4},
            {"process": "random_walk", "K": 1e-6},
            {"process": "low_pass", "order": 2, "cutoff": 12.0, "rate": FS},
        ],
        "accel_z": [
            {"process": "white_noise", "N": 1e-3},
            {"process": "gauss_markov", "sigma": 3e-4, "correlation_time": 300.0},
        ],
    }
)


@pytest.fixture
def small(monkeypatch):
    """A record of two hours at 50 Hz counts as one of days."""
    monkeypatch.setattr(long, "PART", 1 << 15)
    monkeypatch.setattr(long, "MEANS", 1 << 14)
    monkeypatch.setattr(sys.modules["imu_lib.gap.long.scan"], "WINDOW", 1 << 13)


def opened(signals, folder):
    write_record(Record(signals, FS), folder / "long.parquet")
    return long_record.open_long(folder / "long.parquet", least=1 << 17)


def strange(signals):
    """The record with what MODEL lacks, drawn by code of its own: a slow wave whose period wanders,
    throws of one axis, a level that jumps, a hum of half an hour, a knock.
    """
    rng = np.random.default_rng(99)
    t = np.arange(N) / FS
    x, z = signals["gyro_x"].copy(), signals["accel_z"].copy()
    slow = np.cumsum(rng.standard_normal(N // 500)) * 4e-5
    x += np.interp(t, np.arange(len(slow)) * 10.0, slow)
    at = rng.choice(N, 90, replace=False)
    x[at] += 0.02 * rng.standard_normal(90)
    z += np.where(t > 5000.0, 1.5e-3, 0.0)
    z += np.where((t > 2000) & (t < 3800), 0.01 * np.sin(2 * np.pi * 17.3 * t), 0.0)
    knock = (t > 6500) & (t < 6501)
    x[knock] += 0.2 * rng.standard_normal(knock.sum())
    z[knock] += 2.0 * rng.standard_normal(knock.sum())
    return {"gyro_x": x, "accel_z": z}


def test_nothing_is_found_where_nothing_is(small, tmp_path):
    record = opened(MODEL.simulate(N, FS, np.random.default_rng(4)), tmp_path)
    found = gap.close(record, MODEL, simulations=20, jobs=1)
    assert not found.steps and found.record_unexplained is None
    for c in found.channels.values():
        assert c.result.unexplained is None
        assert 0.6 < c.before.value < 1.35


def test_both_views_and_the_windows_unlike_the_rest(small, tmp_path):
    record = opened(strange(MODEL.simulate(N, FS, np.random.default_rng(4))), tmp_path)
    found = gap.close(record, MODEL, simulations=0, jobs=1)
    steps = {(w, s.effect): s.parameters for w, s in found.steps}
    assert abs(steps["accel_z", "step"]["time"] - 5000) < 60
    assert abs(steps["accel_z", "step"]["amplitude"] / 1.5e-3 - 1) < 0.2
    walks = {"parameter_change", "random_walk", "gauss_markov", "flicker"}
    assert walks & {effect for where, effect in steps if where == "gyro_x"}
    assert ("gyro_x", "spikes") in steps
    hum = steps["record", "vibration"]
    assert abs(hum["frequency"] - 17.3) < 0.05
    assert abs(hum["from"] - 2000) < 200 and abs(hum["to"] - 3800) < 200
    assert abs(steps["record", "disturbance"]["start"] - 6500) < 10
    assert len(found.views) == 2 and " h at " in " ".join(sentences(found))
    tau = np.array([300.0])
    assert found.model["gyro_x"].avar(tau, FS) > 10 * MODEL["gyro_x"].avar(tau, FS)
    assert found.model["gyro_x"].low_pass == MODEL["gyro_x"].low_pass


def test_two_levels_of_a_long_record_are_named_where_no_model_was_given(small, tmp_path):
    """A Gauss-Markov process has the same spectrum: the base of the block means is free."""
    rng = np.random.default_rng(12)
    t = np.arange(N) / FS
    x = 2e-4 * np.sqrt(FS) * rng.standard_normal(N)
    flips = np.cumsum(rng.exponential(150.0, 200))
    record = opened({"gyro_x": x + 2e-4 * (-1.0) ** np.searchsorted(flips, t)}, tmp_path)
    found = gap.close(record, simulations=0, jobs=1)
    (step,) = found.channels["gyro_x"].result.steps
    assert step.effect == "telegraph"
    assert abs(step.parameters["amplitude"] / 4e-4 - 1) < 0.1
    assert abs(np.log(step.parameters["rate"] * 150.0)) < np.log(2)
    terms = [p.name for p in found.model["gyro_x"].terms]
    assert sorted(terms) == ["telegraph", "white_noise"]


def step_of(begin, end, frequency=17.3):
    p = {"frequency": frequency, "from": begin, "to": end}
    return Step("vibration", p, {}, "", "", 1.0, {})


def test_a_vibration_over_several_stretches_is_one_and_one_with_a_pause_is_two():
    known = [step_of(1000.0, 1200.0)]
    for more in ((1200.0, 5000.0), (400.0, 1000.0), (8000.0, 8200.0)):
        known = looked_at.together(known, [step_of(*more)])
    assert [(s.parameters["from"], s.parameters["to"]) for s in known] == [
        (400.0, 5000.0),
        (8000.0, 8200.0),
    ]
    assert len(looked_at.together(known, [step_of(400.0, 5000.0, 31.0)])) == 3
