"""What does not hold in time that was not fitted is not taken."""

import numpy as np
import pytest
from scipy import signal

from imu_lib.gap import held_out
from imu_lib.gap.channel import analyse
from imu_lib.gap.data import Data
from imu_lib.gap.effects import CATALOGUE
from imu_lib.processes import Sum, WhiteNoise

FS, N = 100.0, 30_000
BASE = Sum((WhiteNoise(N=0.1),))


def resonance(rng):
    """(N,) about 18 Hz, a third as strong as the white noise."""
    return 0.05 * signal.lfilter([1.0], [1.0, -0.8, 0.95], rng.standard_normal(N))


@pytest.mark.parametrize("whole", [True, False])
def test_a_resonance_counts_where_the_rest_of_the_record_has_it(whole):
    rng = np.random.default_rng(6)
    on = np.ones(N) if whole else (np.arange(N) < 0.6 * N) * 1.0
    found = analyse("gyro_x", rng.standard_normal(N) + on * resonance(rng), FS, BASE)
    names = [s.effect for s in found.steps]
    assert names == (["autoregressive"] if whole else [])
    assert (found.unexplained is None) == whole  # it is there, and has no name


def test_a_line_that_ends_is_no_line_of_the_record():
    """Its amplitude is twenty-four standard deviations in the whole, seventeen in half of it."""
    rng = np.random.default_rng(7)
    t = np.arange(N) / FS
    for on, count in ((t >= 0.0, 1), (t < 150.0, 0)):
        x = rng.standard_normal(N) + 0.2 * on * np.sin(2 * np.pi * 12.345 * t)
        data = Data(x, FS)
        found, cleaned = CATALOGUE["sinusoid"].find(data)
        lines, left = held_out.steady(found, cleaned, data)
        assert len(lines) == count and len(found) >= 1
        put_back = 0.0 if count else sum(line for _, line in found)
        np.testing.assert_allclose(left.x, cleaned.x + put_back, atol=1e-9)
