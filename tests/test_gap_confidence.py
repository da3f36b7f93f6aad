"""A confidence is a frequency: of a likelihood's odds, or of the right names in the blind scores."""

import json
import sys
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from imu_lib.gap import left_beside, reliability, rounds, steps
from imu_lib.gap.channel import analyse
from imu_lib.gap.state import State
from imu_lib.gap.steps import Step
from imu_lib.processes import RandomWalk, Sum, WhiteNoise

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "benchmarks"))
import gap_reliability  # noqa: E402

RESULTS = Path(__file__).resolve().parents[1] / "benchmarks" / "results"


def test_shares_of_right_names_are_those_of_the_stored_scores():
    found, right = Counter(), Counter()
    for name in ("gap_score", "gap_score_free", "gap_score_pairs"):
        for case in json.loads((RESULTS / f"{name}.json").read_text())["cases"]:
            for step in case["steps"]:
                if step["effect"] in reliability.DETECTED and step["confidence"] > 0.5:
                    found[step["effect"]] += 1
                    right[step["effect"]] += any(
                        (t["effect"], t["channel"]) == (step["effect"], step["channel"])
                        for t in case["truths"]
                    )
    assert {e: (found[e], right[e]) for e in reliability.DETECTED} == reliability.DETECTED


def test_odds_are_those_of_the_largest_gain_among_places():
    """The largest of 1000 exponential gains, against one that is there at 4 more."""
    rng = np.random.default_rng(5)
    chance = rng.exponential(size=(4000, 1000)).max(axis=1)
    for gain in (8.0, 10.0, 12.0):
        exceeded = np.mean(chance > gain)
        assert reliability.odds(gain, 1000) == pytest.approx(1 / (1 + exceeded), abs=0.06)


def test_what_has_no_likelihood_is_detected_with_its_evidence():
    rng = np.random.default_rng(3)
    x = rng.standard_normal(60_000)
    x = np.clip(x, -3.0, 3.0)
    found = analyse("gyro_x", x, 100.0, Sum((WhiteNoise(0.1),)), seed=1)
    (step,) = found.steps
    assert isinstance(step, Step) and step.effect == "saturation"
    entry = step.to_json()
    assert (
        entry["detected"] is True
        and entry["gain"] is None
        and "end of the range" in entry["evidence"]
    )
    assert entry["confidence"] == pytest.approx(reliability.share("saturation"), abs=1e-4)
    assert reliability.share("unheard of") == 0.5


def test_names_are_as_sure_as_the_stored_scores_were_right():
    """The shares beside something unexplained are counted again, and every bin of the reliability
    diagram that holds twenty findings is within five points of its confidence or has it in its
    95 % interval.
    """
    assert gap_reliability.beside_unexplained() == left_beside.COUNTED
    rows = [
        (gap_reliability.as_told(sure, effect, left), right)
        for effect, sure, right, left, _ in gap_reliability.findings()
    ]
    for bin_ in gap_reliability.table(rows):
        low, high = bin_["interval"]
        near = abs(bin_["right"] - bin_["confidence"]) <= 0.05 or low <= bin_["confidence"] <= high
        assert near or bin_["findings"] < 20


def test_the_weights_of_a_winner_and_its_rivals_are_shares():
    """A weight of nine in ten was right nine times in ten; order and bounds are kept."""
    weights = [0.0, 0.05, 0.3, 0.6, 0.9, 0.99, 1.0]
    sure = [reliability.calibrated(w) for w in weights]
    assert sure == sorted(sure) and 0 <= sure[0] and sure[-1] <= 1
    assert abs(reliability.calibrated(0.9) - 0.9) < 0.02


def test_a_change_that_is_as_likely_is_told_with_its_parameter():
    base = Sum((WhiteNoise(N=1e-3), RandomWalk(K=4e-5)))
    weights = {"flicker": 0.4, "parameter_change:0:N": 0.01, "parameter_change:1:K": 0.3, "": 0.0}
    changes = steps._changes(State(None, base.terms), weights, 0.05)
    assert changes == (("random_walk", "K"),)
    known = {"runner_up": {}, "indistinguishable": ["flicker", "parameter_change"]}
    step = Step("gauss_markov", {}, {}, "somewhere", 0.5, **known, changes=changes)
    assert step.rivals == ["flicker", "parameter_change (K of random_walk)"]
    assert step.to_json()["changes"] == [{"process": "random_walk", "name": "K"}]


def test_what_looks_like_a_rival_is_one_too():
    """Levels that the noise buries look like a Gauss-Markov process: both have its weight."""
    alike = SimpleNamespace(alike=lambda state, item: {"telegraph": 0.5})
    rival = rounds.Weighed(SimpleNamespace(key="gauss_markov", effect=alike), None, 4.0, 0.0)
    shared = rounds._rivals([rival], SimpleNamespace(key="gauss_markov_2"), 5.0)
    alone = rounds._rivals([rival], SimpleNamespace(key="telegraph"), 5.0)
    assert shared["telegraph"] == shared["gauss_markov"] and alone == {"gauss_markov": -1.0}
    assert rounds.confidence(shared)[0] == pytest.approx(rounds.confidence(alone)[0])
