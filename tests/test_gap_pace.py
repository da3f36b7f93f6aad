"""A clock that is off is told by lines of known frequency, and by nothing else."""

import numpy as np
import pytest

from imu_lib import gap
from imu_lib.gap.clock_rate import WHY, paced
from imu_lib.gap.model_rate import at_rate
from imu_lib.model import Model
from imu_lib.record import Record

N, RATIO = 24_000, 1.013


def record(lines, fs, ratio):
    """White noise with lines (Hz, amplitude), sampled at `ratio` times the stated rate."""
    rng, t = np.random.default_rng(4), np.arange(N) / (fs * ratio)
    x = {c: 1e-3 * rng.standard_normal(N) for c in ("gyro_x", "gyro_y")}
    for f, a in lines:
        x["gyro_x"] = x["gyro_x"] + a * np.sin(2 * np.pi * f * t + f)
    return Record(x, fs)


def model(*lines):
    terms = [{"process": "sinusoid", "frequency": f, "amplitude": a} for f, a in lines]
    white = {"process": "white_noise", "N": 1e-4}
    return Model.from_json({"gyro_x": [white, *terms], "gyro_y": [white]})


LINES = ((13.0, 2e-4), (29.0, 3e-4))


def test_lines_of_the_model_tell_the_rate():
    found = paced(record(LINES, 100.0, RATIO), model(*LINES))
    assert found.step.parameters["ratio"] == pytest.approx(RATIO, abs=2e-4)
    assert found.record.rate == pytest.approx(100.0 * RATIO, rel=2e-4)
    right = paced(record(LINES, 100.0, 1.0), model(*LINES))
    assert right.step is None and right.invisible is None and right.record.rate == 100.0


def test_one_line_may_be_a_machine_at_another_speed():
    found = paced(record(LINES[:1], 100.0, RATIO), model(LINES[0]))
    assert found.step is None and found.record.rate == 100.0
    assert "a machine's speed" in found.invisible


def test_the_mains_tell_the_rate_by_their_multiples():
    hum = tuple((50.0 * k, 3e-4) for k in (1, 2, 3, 5))
    assert paced(record(hum, 800.0, 0.98), None).step.parameters["ratio"] == pytest.approx(
        0.98, abs=3e-4
    )
    assert paced(record(hum, 800.0, 1.0), None).step is None
    machine = paced(record(((49.0, 1e-3), (81.0, 1e-3)), 800.0, 1.0), None)
    assert machine.step is None and machine.invisible == WHY


def test_where_nothing_tells_it_is_said():
    found = gap.close(record((), 100.0, RATIO), channels=["gyro_y"], simulations=0, jobs=1)
    (hidden,) = found.to_json()["record"]["invisible"]
    assert hidden["effect"] == "rate_error" and hidden["why"] == WHY
    assert found.steps == []


@pytest.mark.parametrize("rate", [99.93, 100.0, 97.5])
def test_a_model_goes_with_a_record_that_another_clock_sampled(rate):
    steps = [
        {"process": "white_noise", "N": 1e-4},
        {"process": "low_pass", "order": 2, "cutoff": 20.0, "rate": 1000.0},
    ]
    noise = {"process": "autoregressive", "phi": [0.5], "sigma": 1e-4, "rate": 100.0}
    given = Model.from_json({"gyro_x": steps, "gyro_y": [noise], "rate": 100.0})
    here = at_rate(given, rate)
    assert here["gyro_x"].low_pass.rate == 10 * rate and here["gyro_x"].low_pass.cutoff == 20.0
    assert here["gyro_y"].terms[0].rate == rate
    # half the rate is not the same rate by another clock
    assert at_rate(given, 41.3)["gyro_y"].terms[0].rate == 100.0


@pytest.mark.parametrize(
    "stated, told", [(100.0, False), (100.2, False), (101.6, True), (200.0, False)]
)
def test_stamps_and_a_model_of_another_rate_are_told_at_even_odds(stated, told):
    given = Model.from_json({**model().to_json(), "rate": stated})
    found = paced(record((), 100.0, 1.0), given)
    assert (found.step is not None) == told and found.record.rate == 100.0
    if told:
        assert found.step.confidence == 0.5
        assert found.step.parameters["ratio"] == pytest.approx(100.0 / 101.6)
