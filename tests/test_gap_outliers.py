"""Samples thrown off behind a filter: in coloured noise each makes its neighbours surprising."""

import numpy as np
import pytest

from imu_lib.drawing.stages import passed
from imu_lib.gap.channel import analyse
from imu_lib.gap.data import Data
from imu_lib.gap.effects.step import Step
from imu_lib.processes import LowPass, Spikes, Sum, WhiteNoise
from imu_lib.samples.imputation import first_fill, impute
from imu_lib.samples.innovations import Smooth, surprises
from imu_lib.samples.outliers import deconvolved

FS, N = 100.0, 180_000
WHITE = WhiteNoise(N=1e-3)


def _behind(order, cutoff, seed):
    return Sum((WHITE,), (LowPass(order=order, cutoff=cutoff, rate=FS),)), np.random.default_rng(
        seed
    )


@pytest.mark.parametrize(("order", "cutoff"), [(1, 30.0), (2, 14.0), (4, 13.0)])
def test_heights_are_those_that_were_added(order, cutoff):
    model, rng = _behind(order, cutoff, 3)
    quiet = model.simulate(N, FS, rng)
    smooth = Smooth(quiet, FS)
    at = np.array([5000, 9000, 9001, 20_000, 20_003, 40_000, 90_000, 90_002])
    sd = np.sqrt(smooth.conditional_variance)
    heights = sd * np.array([40.0, 60.0, 80.0, -70.0, 50.0, 15.0, 300.0, -200.0])
    x = quiet.copy()
    x[at] += heights
    y, instead = deconvolved(surprises(x, smooth), smooth)
    seen = np.flatnonzero(np.abs(y) > 5)
    assert np.array_equal(
        seen[(seen > 64) & (seen < N - 64)], at
    )  # at the ends half of the neighbours are missing
    # one at a time to a standard deviation; neighbours of neighbours share what is known of them
    assert np.all(
        np.abs(y[at] * sd - heights) < 5 * sd * np.where(np.isin(at, [5000, 40_000]), 1, 6)
    )
    assert instead[at].all() and instead[64:-64].sum() < 40


def test_without_outliers_nothing_is_touched():
    model, rng = _behind(2, 20.0, 4)
    x = model.simulate(N, FS, rng)
    smooth = Smooth(x, FS)
    y = surprises(x, smooth)
    got, instead = deconvolved(y, smooth)
    assert np.array_equal(got[300:-300], y[300:-300]) and not instead[64:-64].any()


def test_many_outliers_are_another_distribution():
    x = np.random.default_rng(6).standard_t(1.0, N)
    smooth = Smooth(x, FS)
    y = surprises(x, smooth)
    y = y / np.median(np.abs(y))
    got, instead = deconvolved(y, smooth)
    assert np.array_equal(got, y) and not instead.any()


def test_spikes_behind_a_steep_filter_are_named_alone():
    """Their heights were a third too small, and in every record something was left unexplained or
    named beside them.
    """
    explained = []
    for seed, (order, cutoff) in enumerate([(2, 14.0), (4, 13.0), (3, 20.0)] * 2):
        model, rng = _behind(order, cutoff, seed)
        hit = rng.random(N) < 0.4 / FS
        x = model.simulate(N, FS, rng) + hit * 0.05 * rng.standard_normal(N)
        found = analyse("accel_x", x, FS, model)
        assert [s.effect for s in found.steps] == ["spikes"]
        explained.append(found.unexplained is None)
        step, count = found.steps[0], hit.sum()
        # the number that fell is known, the scale to 1 / sqrt(2 count); some are too small to be
        # seen
        assert step.parameters["rate"] == pytest.approx(count / N * FS, rel=0.06)
        assert step.parameters["scale"] == pytest.approx(0.05, rel=4 / np.sqrt(2 * count))
    # of three spikes within a few samples not every one is found: a sixth of longer runs of this
    # kind keep a heavy tail
    assert np.mean(explained) >= 0.5


@pytest.mark.parametrize(("order", "cutoff", "seed"), [(1, 20.0, 21), (2, 14.0, 22), (4, 13.0, 23)])
def test_clipping_behind_a_filter_is_named_alone(order, cutoff, seed):
    """What was drawn for the clipped samples lay so far from what their neighbours foretell that
    noise was named beside it.
    """
    model, rng = _behind(order, cutoff, seed)
    x = model.simulate(N, FS, rng)
    limit = np.quantile(x, 0.98)
    found = analyse("gyro_x", np.minimum(x, limit), FS, model)
    assert [s.effect for s in found.steps] == ["saturation"] and found.unexplained is None
    assert found.steps[0].parameters["limit"] == pytest.approx(limit, rel=1e-9)


def test_clipped_samples_are_drawn_beyond_the_limit_as_the_others_foretell():
    model, rng = _behind(2, 20.0, 31)
    x = model.simulate(N, FS, rng)
    smooth = Smooth(x, FS)
    limit = float(np.quantile(x, 0.966))
    side = x > limit
    got = impute(np.minimum(x, limit), np.zeros(N, bool), smooth, rng, above=(side, limit))
    assert np.array_equal(got[~side], x[~side]) and np.all(got[side] >= limit)
    drawn, true = surprises(got, smooth)[side], surprises(x, smooth)[side]
    # 6000 samples, of which a run shares its surprises: a scatter of 2 %; a draw of each for
    # itself has four times as much
    assert drawn.std() == pytest.approx(true.std(), rel=0.15)


@pytest.mark.parametrize(("n", "fs"), [(6_400, 200.0), (12_000, 100.0), (30_000, 100.0)])
def test_short_records_are_whitened_to_the_spread_that_is_claimed(n, fs):
    """Bins of one or two ordinates would make the reciprocal of the spectrum a hundred times too
    large at their frequencies now and then: one of these twelve records of each length had
    surprises of a standard deviation of 1.5 to 10. Two per cent are five standard deviations of
    the spectrum's own error.
    """
    for seed in range(12):
        x = np.random.default_rng([seed, 77]).standard_normal(n)
        assert abs(np.std(surprises(x, Smooth(x, fs))) - 1) < 0.02


def test_a_channel_that_freezes_to_the_end_does_not_jump_there():
    """What is filled in lies at the level that was measured, not at that of a few samples before
    the hole; a jump needs samples on both of its sides.
    """
    n, lost = 13_000, 3_500
    bad = np.arange(n) >= n - lost
    for seed in range(8):
        x = np.random.default_rng(seed).standard_normal(n)
        assert abs(np.mean(first_fill(x, bad)[bad])) < 0.1
    times = [p.time for p in Step().shapes(Data(x, 100.0, missing=bad))]
    assert times and max(times) < (n - lost) / 100.0 < 0.9 * n / 100.0


def test_spikes_before_increments_are_taken_are_spikes_each_with_its_opposite():
    """They were two noises that take turns, for four samples at a time."""
    rng = np.random.default_rng(77)
    n, fs = 12_000, 50.0
    x = rng.standard_normal(n)
    at = np.sort(rng.choice(n // 4, 40, replace=False)) * 4
    height = 15.0 * rng.standard_normal(40)
    x[at] += height
    x[at + 1] -= height
    result = analyse("gyro_x", 1e-3 * x, fs, None)
    (step,) = result.steps
    assert step.effect == "spikes" and step.confidence > 0.95 and result.unexplained is None, (
        result.unexplained
    )
    assert step.parameters["differenced"] == 1
    assert step.parameters["rate"] == pytest.approx(40 / (n / fs), rel=0.25)
    again = Spikes(**step.parameters).apply(np.zeros(n), fs, np.random.default_rng(1))
    thrown = np.flatnonzero(again)
    assert len(thrown) > 40 and abs(again.sum()) < 1e-9 * np.abs(again).sum()


def test_spikes_with_opposites_are_drawn_the_same_in_pieces():
    thrown = Spikes(rate=5.0, scale=2.0, differenced=1)
    pieces = passed(thrown, iter([np.zeros(500)] * 4), 100.0, np.random.default_rng(3), 2000)
    x = np.concatenate(list(pieces))
    assert np.count_nonzero(x) > 100 and abs(x.sum()) < 1e-9
