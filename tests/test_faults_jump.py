"""A level that jumps once is told apart from a random walk."""

import numpy as np
import pytest

from imu_lib.characterise import characterise
from imu_lib.faults import jump
from imu_lib.processes import Flicker, GaussMarkov, RandomWalk, Sum, WhiteNoise
from imu_lib.record import Record

WHITE = WhiteNoise(1.0)
BASES = {
    "white": [WHITE],
    "walk": [WHITE, RandomWalk(0.3)],
    "strong walk": [WHITE, RandomWalk(3.0)],
    "slow Gauss-Markov": [WHITE, GaussMarkov(1.0, 30.0)],
    "flicker": [WHITE, Flicker(0.5)],
}


@pytest.mark.parametrize("base", BASES)
def test_noise_has_no_jump(base):
    # 0 of 420 channels of seven such bases when it was set
    for seed in range(6):
        x = Sum.of(BASES[base]).simulate(12000, 100.0, np.random.default_rng(seed))
        assert jump.of(x, 100.0) is None


@pytest.mark.parametrize("seed", range(4))
def test_a_jump_is_found_at_its_time_with_its_size(seed):
    rng = np.random.default_rng(seed)
    x = Sum.of([WHITE, RandomWalk(0.01)]).simulate(12000, 100.0, rng)
    at, amplitude = rng.uniform(20.0, 100.0), rng.choice([-1, 1]) * rng.uniform(5.0, 20.0)
    x[int(at * 100) :] += amplitude
    found = jump.of(x, 100.0)
    assert abs(found.time - at) <= 1.0  # a block mean
    assert found.amplitude == pytest.approx(amplitude, rel=0.25)


def test_a_single_mean_that_is_off_is_no_jump():
    x = WHITE.simulate(12000, 100.0, np.random.default_rng(5))
    x[6000:6100] += 20.0
    assert jump.of(x, 100.0) is None


def test_characterise_says_that_a_walk_is_a_jump_also_in_the_model():
    rng = np.random.default_rng(3)
    x = 1e-3 * rng.standard_normal(12000)
    x[6660:] += 2e-3
    found = characterise(Record({"gyro_x": x}, rate=100.0, name="desk"))
    said = "gyro_x by 0.115 deg/s near 66"
    assert any(said in note for note in found.notes)
    assert said in found.model.source
