"""What three axes of a sensor agree on is as sure as all of them make it; two noises that take two_noises."""

import re
from dataclasses import replace

import numpy as np
import pytest

from imu_lib.ensembles import furthest
from imu_lib.ensembles.battery import battery
from imu_lib.gap.axes import agreed
from imu_lib.gap.channel import ChannelResult, analyse
from imu_lib.gap.steps import Step
from imu_lib.processes import Sum, WhiteNoise
from imu_lib.samples import two_noises

MODEL = Sum((WhiteNoise(1e-4),))


def results(effect, key, values, sure, *, gain=20.0):
    """Channel -> result with one step each."""
    return {
        f"gyro_{a}": ChannelResult(
            f"gyro_{a}",
            MODEL,
            MODEL,
            [Step(effect, {key: v}, {}, "", c, {}, ["other"], gain=gain, detected=gain is None)],
            [],
            None,
        )
        for a, v, c in zip("xyz", values, sure)
    }


def confidences(found):
    return [r.steps[0].confidence for r in found.values()]


def test_one_filter_on_three_axes_is_surer_than_on_one():
    found = agreed(results("low_pass", "cutoff", (40.0, 40.5, 39.8), (0.85, 0.8, 0.7)))
    assert min(confidences(found)) == max(confidences(found)) > 0.9
    apart = results("low_pass", "cutoff", (40.0, 30.0, 20.0), (0.85, 0.8, 0.7))
    assert confidences(agreed(apart)) == [0.85, 0.8, 0.7]
    # beside something unexplained an axis is no witness
    left = results("low_pass", "cutoff", (40.0, 40.5, 39.8), (0.85, 0.8, 0.7))
    left["gyro_x"] = replace(left["gyro_x"], unexplained="something")
    assert confidences(agreed(left))[0] == 0.85


def test_one_grid_is_as_sure_on_all_axes_as_on_the_surest():
    found = agreed(results("resolution", "lsb", (1e-3, 1e-3, 1e-3), (0.985, 0.5, 0.5), gain=None))
    assert confidences(found) == [0.985] * 3
    assert all(r.steps[0].indistinguishable == [] for r in found.values())


def test_that_samples_lie_on_a_grid_is_no_less_sure_beside_strange_noise():
    rng = np.random.default_rng(3)
    x = rng.standard_normal(20_000) * np.where(rng.random(20_000) < 0.4, 4.0, 1.0)
    found = analyse("accel_x", np.round(x / 0.7) * 0.7, 100.0, None)
    assert found.unexplained is not None
    (grid,) = [s for s in found.steps if s.effect == "resolution"]
    assert grid.confidence > 0.9


@pytest.mark.parametrize(("run", "words"), [(1, "from one sample to the next"), (100, "at a time")])
def test_two_noises_that_take_turns_are_said_with_their_share_and_ratio(run, words):
    rng = np.random.default_rng(4)
    n = 60_000
    loud = np.repeat(rng.random(n // run) < 0.2, run)
    y = rng.standard_normal(n) * np.where(loud, 4.0, 1.0)
    share, ratio = two_noises.two_sizes(y)
    assert share == pytest.approx(np.mean(loud), abs=0.02) and ratio == pytest.approx(4.0, rel=0.1)
    assert words in two_noises.sentence(y, 100.0)
    if run > 1:  # runs of one length, some of them in a row
        assert 0.5 * run < two_noises.stays(y) < 3 * run
    assert two_noises.sentence(rng.standard_normal(n), 100.0) is None


def test_what_is_still_off_is_said_in_words_that_a_figure_shows():
    rng, n, fs = np.random.default_rng(5), 8_000, 100.0
    rows = [battery(rng.standard_normal(n), fs) for _ in range(20)]
    tails = furthest.sentence("distribution", battery(rng.standard_t(4, n), fs), rows, n, fs)
    assert re.fullmatch(r"the \D+ is [\d.]+ ?%? where simulations have [\d.]+ ?%? to .*", tails)
    loud = furthest.sentence("allan", battery(2.0 * rng.standard_normal(n), fs), rows, n, fs)
    assert re.match(r"the Allan variance at 0.01 s is \+(5.9|6|6.1) dB off", loud)
    line = np.sin(2 * np.pi * 20.0 * np.arange(n) / fs)
    seen = furthest.sentence("psd", battery(rng.standard_normal(n) + line, fs), rows, n, fs)
    low, high = (float(v) for v in re.search(r"between ([\d.]+) and ([\d.]+) Hz", seen).groups())
    assert low <= 20.0 <= high
