"""A signal that is cut off: its rail is a fact, and its noise that of the whole signal."""

import numpy as np
import pytest

from imu_lib.gap.channel import analyse
from imu_lib.gap.effects.saturation import Saturation
from imu_lib.samples.clipped import Side, started

FS, N = 100.0, 40_000


def noise(seed):
    return 0.1 * np.random.default_rng(seed).standard_normal(N)


def test_a_fifth_of_the_samples_on_a_rail_leaves_the_noise_as_it_is():
    """N is that of the whole signal to one per cent, three standard deviations of what four fifths
    of the samples tell; it was 6 % low where clipped ones were drawn about the mean of the others.
    """
    x = noise(1)
    found = analyse("gyro_x", np.minimum(x, np.quantile(x, 0.79)), FS, None)
    assert [s.effect for s in found.steps] == ["saturation"] and found.unexplained is None
    (white,) = found.model.noise.terms
    assert white.N == pytest.approx(np.std(x) / np.sqrt(FS), rel=0.012)


def test_a_rail_is_a_fact_beside_what_has_no_name():
    """A beat that is no sinusoid is left, and the rail is as sure as it was."""
    t = np.arange(N) / FS
    x = noise(2) * (1 + 0.5 * np.sign(np.sin(2 * np.pi * t / 3.3)))
    found = analyse("gyro_x", np.minimum(x, np.quantile(x, 0.79)), FS, None)
    assert found.unexplained
    assert next(s for s in found.steps if s.effect == "saturation").confidence > 0.9


@pytest.mark.parametrize("step", [None, 0.02])
def test_a_rail_is_visited_again_and_again_and_lies_at_the_end_of_the_signal(step):
    x = noise(3)
    if step is not None:
        x = step * np.rint(x / step)
    assert Saturation().detect(np.minimum(x, np.quantile(x, 0.9)), step, None).counted
    gone = x.copy()
    gone[::50] = 4.0
    found = Saturation().detect(gone, step, None)  # samples that drop out do not come near it
    assert found is None or not found.counted


def test_the_level_and_the_scatter_of_a_clipped_signal_are_found_together():
    """A drift whose upper end is cut off: mean and standard deviation to three standard errors."""
    x = noise(4) + np.linspace(0.0, 0.3, N)
    limit = float(np.quantile(x, 0.75))
    mask = x >= limit
    got = started(np.minimum(x, limit), [Side(mask, limit, 1.0)], np.random.default_rng(5))
    assert np.all(got[mask] >= limit) and np.array_equal(got[~mask], x[~mask])
    for part in np.array_split(np.arange(N), 4):
        assert np.mean(got[part]) == pytest.approx(np.mean(x[part]), abs=0.006)
    assert np.std(got[: N // 2]) == pytest.approx(np.std(x[: N // 2]), rel=0.03)
