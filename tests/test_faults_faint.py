"""What happened to the sensor and is faint: small knocks, footsteps, slow tilts, tilts by a hand."""

import numpy as np
import pytest
from scipy.signal import lfilter

from imu_lib import faults
from imu_lib.faults import passing
from imu_lib.record import Record

CHANNELS = [f"{k}_{a}" for k in ("gyro", "accel") for a in "xyz"]
SD = np.r_[[2e-3] * 3, [1.5e-2] * 3]
RATE, N = 100.0, 18_000
T = np.arange(N) / RATE


def still(seed, *, slow=0.0, freedom=np.inf):
    rng = np.random.default_rng([seed, 41])
    z = rng.standard_normal((N, 6))
    if np.isfinite(freedom):
        z = rng.standard_t(freedom, (N, 6)) * np.sqrt((freedom - 2) / freedom)
    poles = np.exp(-1 / (RATE * np.geomspace(0.3, 100.0, 6)))
    z += slow * sum(
        lfilter([np.sqrt(1 - p * p)], [1, -p], rng.standard_normal((N, 6)), axis=0) for p in poles
    )
    x = z * SD
    x[:, 5] -= 9.81
    return x, rng


def found(x):
    return faults.find(Record(dict(zip(CHANNELS, x.T)), RATE))


def knock(at, peak, rng, *, ring=0.08):
    after = np.clip(T - at, 0, None)[:, None]
    shape = np.exp(-after / ring) * np.sin(2 * np.pi * 17.0 * after + rng.uniform(0, 6, 6))
    return (T >= at)[:, None] * peak * rng.uniform(0.4, 1.0, 6) * SD * shape


def turned(x, angle, start, seconds):
    """Tilted about an axis between x and y, evenly."""
    done = np.clip((T - start) / seconds, 0.0, 1.0)
    rate = angle * np.gradient(done) * RATE
    x[:, 0] += 0.8 * rate
    x[:, 1] += 0.6 * rate
    x[:, 3] += 0.6 * 9.81 * angle * done
    x[:, 4] -= 0.8 * 9.81 * angle * done


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_knock_that_stands_out_on_no_channel_is_found_by_all_together(seed):
    x, rng = still(seed, slow=0.2)
    x += knock(80.0, 4.6, rng)
    (item,) = found(x)
    assert item.kind == "disturbance" and item.start == pytest.approx(80.0, abs=0.4)
    assert item.stop - item.start < 1.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_footsteps_of_which_none_stands_out_are_one_walk(seed):
    x, rng = still(seed, slow=0.2)
    for at in 60.0 + np.cumsum(rng.normal(0.55, 0.03, 22)):
        x += knock(at, 2.6, rng)
    (item,) = found(x)
    assert item.kind == "disturbance" and "as of footsteps" in item.sentence
    assert 59.0 < item.start < 66.0 and 67.0 < item.stop < 76.0
    assert item.evidence["rhythm"] == pytest.approx(1 / 0.55, rel=0.05)


@pytest.mark.parametrize("freedom", [np.inf, 4.0])
def test_nothing_faint_in_noise_of_any_tails(freedom):
    for seed in range(2):
        assert not found(still(seed, slow=0.3, freedom=freedom)[0])


def test_what_beats_all_the_time_is_no_walk():
    x, rng = still(4)
    hum = np.sin(2 * np.pi * 21.0 * T) + np.sin(2 * np.pi * 22.9 * T)
    assert not [f for f in found(x + 0.7 * hum[:, None] * SD) if "footsteps" in f.sentence]


@pytest.mark.parametrize("seconds", [12.0, 25.0])
def test_a_slow_tilt_is_a_tilt(seconds):
    x, _ = still(5, slow=0.03)
    turned(x, 0.03, 70.0, seconds)
    (item,) = found(x)
    assert item.kind == "tilt" and item.start == pytest.approx(70.0, abs=0.3 * seconds)
    assert np.linalg.norm(item.parameters["angles"]) == pytest.approx(0.03, rel=0.15)


def test_a_tilt_by_a_hand_that_shakes_more_than_the_gyros_turn():
    """What the gyros integrate to while they are shaken does not contradict the tilt."""
    for seed in range(3):
        x, rng = still(seed, slow=0.1)
        low, m = 9000, 350
        shake = np.cumsum(rng.standard_normal((m, 6)), axis=0)
        shake -= np.linspace(0, 1, m)[:, None] * shake[-1]
        x[low : low + m] += 25 * SD * shake / shake.std(axis=0)
        turned(x, 8e-3, 91.0, 1.5)
        kinds = [f.kind for f in found(x)]
        assert kinds == ["disturbance", "tilt"] or kinds == ["tilt", "disturbance"], seed


@pytest.mark.parametrize("scale", [0.0, 1e200])
def test_a_channel_without_noise_to_judge_by_has_no_level_that_it_keeps(scale):
    assert not passing._steady(scale * np.r_[np.ones(99), 1e108], np.ones(100))
