"""A confidence is a frequency: of a likelihood's odds, or of the right names in the blind scores."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from imu_lib.gap import measured
from imu_lib.gap.channel import analyse
from imu_lib.gap.steps import Step
from imu_lib.processes import Sum, WhiteNoise

RESULTS = Path(__file__).resolve().parents[1] / "benchmarks" / "results"


def test_shares_of_right_names_are_those_of_the_stored_scores():
    found, right = Counter(), Counter()
    for name in ("gap_score", "gap_score_free", "gap_score_pairs"):
        for case in json.loads((RESULTS / f"{name}.json").read_text())["cases"]:
            for step in case["steps"]:
                if step["effect"] in measured.DETECTED and step["confidence"] > 0.5:
                    found[step["effect"]] += 1
                    right[step["effect"]] += any(
                        (t["effect"], t["channel"]) == (step["effect"], step["channel"])
                        for t in case["truths"]
                    )
    assert {e: (found[e], right[e]) for e in measured.DETECTED} == measured.DETECTED


def test_odds_are_those_of_the_largest_gain_among_places():
    """The largest of 1000 exponential gains, against one that is there at 4 more."""
    rng = np.random.default_rng(5)
    chance = rng.exponential(size=(4000, 1000)).max(axis=1)
    for gain in (8.0, 10.0, 12.0):
        exceeded = np.mean(chance > gain)
        assert measured.odds(gain, 1000) == pytest.approx(1 / (1 + exceeded), abs=0.06)


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
    assert entry["confidence"] == pytest.approx(measured.share("saturation"), abs=1e-4)
    assert measured.share("unheard of") == 0.5
