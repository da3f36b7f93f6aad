"""Grids as wide as the noise, and frozen samples on them."""

import gap_generator as generator
import numpy as np
import pytest

from imu_lib.gap.channel import analyse
from imu_lib.gap.effects.saturation import Saturation
from imu_lib.gap.effects.stuck import Stuck
from imu_lib.processes import Sum, from_json
from imu_lib.samples.innovations import Smooth
from imu_lib.samples.rounding import Rounding, moments

FS, N = 100.0, 120_000


@pytest.mark.parametrize("sd", [0.3, 0.5, 1.2])
def test_moments_of_rounded_normal_samples(sd):
    mu, mean, variance = moments(sd)
    z = np.random.default_rng(1).standard_normal(400_000)
    for i in (3, 64, 100):
        x = np.rint(mu[i] + sd * z)
        assert abs(x.mean() - mean[i]) < 5 * np.sqrt(variance[i] / len(z))
        assert abs(x.var() - variance[i]) < 5 * np.sqrt(np.var((x - x.mean()) ** 2) / len(z))


@pytest.mark.parametrize("step, offset", [(1.2, 0.0), (2.0, 0.7), (3.0, 0.2)])
def test_the_noise_before_a_coarse_grid_is_recovered(step, offset):
    """Steps in standard deviations; Sheppard's step^2 / 12 would be off by up to 20 % of the noise
    at three of them.
    """
    x = np.random.default_rng(2).standard_normal(N) + 0.4
    y = np.rint((x - offset) / step) * step + offset
    smooth = Smooth(y, FS)
    rounding = Rounding(y, smooth, (step, offset))
    assert (
        abs(rounding.variance * step**2 - 1) < 0.03
    )  # four standard deviations of a variance cut to a few levels
    assert abs(np.mean(rounding.base) * step + offset - 0.4) < 0.03
    added = rounding.extra(np.random.default_rng(3))
    k = smooth.layout.slow
    left = np.average(smooth.level[k:] - added[k:], weights=smooth.count[k:]) * FS / 2
    assert abs(left - 1) < 0.03


@pytest.mark.parametrize("step", [1.4, 3.0])
def test_a_coarse_grid_leaves_nothing_else_to_be_named(step):
    base = [{"process": "white_noise", "N": 1e-4}]
    x = generator.noise(base[0], 360_000, FS, np.random.default_rng(4)) + 3e-4
    lsb = step * 1e-3
    found = analyse("gyro_x", np.rint(x / lsb) * lsb, FS, Sum.of(from_json(e) for e in base))
    assert [s.effect for s in found.steps] == ["resolution"] and found.unexplained is None


def test_frozen_samples_are_told_from_chance_runs_on_a_coarse_grid():
    rng = np.random.default_rng(5)
    x, twin = (np.rint(rng.standard_normal(N) / 2.5) for _ in range(2))
    clipped = np.zeros(N, bool)
    assert Stuck().detect(x, clipped, twin, None) is None
    y = x.copy()
    starts = np.arange(500, N - 500, 1500)
    for s in starts:
        y[s : s + 40] = y[s]
    found = Stuck().detect(y, clipped, twin, None)
    assert (
        abs(found.process.fraction / (39 * len(starts) / N) - 1) < 0.25
    )  # chance makes each run longer by a few samples
    assert found.mask[starts[0] + 30]


def test_a_grid_so_wide_that_rounding_quiets_the_noise_is_no_error():
    base = [{"process": "white_noise", "N": 2e-4}, {"process": "random_walk", "K": 1e-7}]
    x = sum(generator.noise(e, N, FS, np.random.default_rng(7)) for e in base)
    smooth = np.convolve(np.concatenate([np.full(2, x[0]), x]), np.ones(3) / 3, "valid")
    lsb = 4.5 * 2e-3 / np.sqrt(3)
    for model in (Sum.of(from_json(e) for e in base), None):
        found = analyse("gyro_x", np.rint(smooth / lsb) * lsb, FS, model)
        assert "resolution" in [s.effect for s in found.steps]


def test_of_two_levels_each_is_an_end_and_none_a_rail():
    x = np.where(np.random.default_rng(7).random(8000) < 0.57, 0.0, 1.0)
    assert Saturation().detect(x, 1.0, None) is None


def test_noise_that_becomes_quieter_on_a_coarse_grid_is_not_stuck():
    """The twin by which equal neighbours are expected becomes quieter as the record does."""
    rng = np.random.default_rng(8)
    kernel = np.ones(9) / 3
    x = np.convolve(rng.standard_normal(20_000), kernel, "same")
    x[12_000:] *= 0.45
    x = np.rint(x / 0.7) * 0.7
    loud = Rounding(x, Smooth(x, 200.0), (0.7, 0.0)).loudness
    assert loud[16_000] / loud[6_000] == pytest.approx(0.45, rel=0.15)
    found = analyse("gyro_x", x, 200.0, None)
    assert "stuck" not in [s.effect for s in found.steps]
