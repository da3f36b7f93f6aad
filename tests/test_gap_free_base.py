"""A free base does not imitate what stands far out of the noise, nor show noises that are not there."""

import numpy as np
import pytest
from scipy import signal

from imu_lib.gap import base_fit
from imu_lib.gap.channel import analyse
from imu_lib.gap.data import Data
from imu_lib.gap.effects.step import Step

FS, N = 50.0, 60_000


def drift(kind, t):
    return {
        "ramp": 2.0 * t / t[-1],
        "warm_up": 1.5 * np.exp(-t / 90.0),
        "step": 1.2 * (t > 700.0),
        "none": 0.0 * t,
    }[kind]


@pytest.mark.parametrize(
    "kind, walk", [("ramp", 0.0), ("step", 0.0), ("warm_up", 0.0), ("none", 2e-3)]
)
def test_a_drift_that_stands_far_out_is_named_beside_a_free_base(kind, walk):
    """The noise of a block of 4 s has a standard deviation of 0.4, the drifts 1.2 to 2."""
    rng = np.random.default_rng([3, len(kind)])
    t = np.arange(N) / FS
    x = 5.0 * rng.standard_normal(N) + walk * np.cumsum(rng.standard_normal(N)) + drift(kind, t)
    found = analyse("gyro_x", x, FS, None, seed=1)
    assert [s.effect for s in found.steps] == ([] if kind == "none" else [kind])
    assert found.unexplained is None
    if not walk:  # nothing but white noise is in the base
        assert [p.name for p in found.base.terms] == ["white_noise"]


@pytest.mark.parametrize("cutoff", [10.0, 20.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_white_noise_behind_a_one_pole_filter_is_no_gauss_markov_process(cutoff, seed):
    """The two have one spectrum; the second has a sensor without white noise."""
    pole = np.exp(-2 * np.pi * cutoff / 100.0)
    x = signal.lfilter([1 - pole], [1, -pole], np.random.default_rng(seed).standard_normal(N))
    (step,) = analyse("gyro_x", x, 100.0, None).steps
    assert step.effect == "low_pass"


def test_a_quick_gauss_markov_process_over_white_noise_is_no_filter():
    pole = np.exp(-1 / (100.0 * 0.016))
    rng = np.random.default_rng(5)
    x = signal.lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(N))
    (step,) = analyse("gyro_x", x + 0.5 * rng.standard_normal(N), 100.0, None).steps
    assert step.effect == "gauss_markov"


@pytest.mark.parametrize("taps", [1, 2])
def test_two_levels_are_not_taken_for_a_red_noise_of_the_base(taps):
    """A level lasts 12 s on average, and the mean over it has a thirtieth of the distance."""
    rng = np.random.default_rng([8, taps])
    flips = np.cumsum(rng.random(20_000) < 0.08 / FS) % 2
    x = rng.standard_normal(20_000) + 0.8 * flips
    x = np.convolve(x, np.full(taps, 1 / taps), "same") if taps > 1 else x
    found = analyse("gyro_x", x, FS, None, seed=1)
    sure = {s.effect for s in found.steps if s.confidence >= 0.9}
    assert sure == {"telegraph"} | ({"low_pass"} if taps > 1 else set())
    (step,) = (s for s in found.steps if s.effect == "telegraph")
    assert abs(step.parameters["amplitude"] / 0.8 - 1) < 0.1  # three standard deviations


@pytest.mark.parametrize(("seed", "dwell", "distance"), [(20261130, 200.0, 3e-4), (21, 50.0, 3e-4)])
def test_two_levels_beside_an_ordinary_walk_are_named_in_a_free_base(seed, dwell, distance):
    """A level is told from the walk by its jumps, from both ends of the record, and what is taken
    out leaves the noise as it is: no second telegraph, no step at the start, no dip that would be a
    noise of its own.
    """
    rng, fs = np.random.default_rng(seed), 3.0
    n = int(6 * 3600 * fs)
    x = 2e-4 * np.sqrt(fs) * rng.standard_normal(n)
    x += np.cumsum(2e-6 / np.sqrt(fs) * rng.standard_normal(n))
    flips = np.cumsum(rng.exponential(dwell, size=int(4 * n / fs / dwell)))
    x += 0.5 * distance * (-1.0) ** np.searchsorted(flips, np.arange(n) / fs)
    found = analyse("gyro_x", x, fs, None, seed=1)
    (step,) = found.steps
    assert step.effect == "telegraph" and step.confidence > 0.9
    low, high = step.intervals["amplitude"]
    assert low < distance * 1.01 and high > distance * 0.99  # within one per cent of its interval
    noise = found.model.find("white_noise")
    assert noise.N == pytest.approx(2e-4, rel=0.01)  # 64,800 samples: 0.3 %


@pytest.mark.parametrize("jump", [0.0, 1.2])
def test_a_jump_beside_too_poor_a_base_is_held_against_slow_noise_alone(jump):
    """White noise and flicker, sd 1 and about 0.2 a decade: what a base of white noise alone calls
    a jump is the flicker's, unless there is one.
    """
    n, rng = 6000, np.random.default_rng(31)
    f = np.fft.rfftfreq(2 * n, 0.1)
    shape = np.r_[0.0, np.sqrt(0.04 / f[1:])]
    x = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * n)) * shape, 2 * n)[:n]
    x += rng.standard_normal(n) + jump * (np.arange(n) > 2500)
    data = Data(x, 10.0)
    white = next(s for s in base_fit._families(data, []) if len(s.base) == 1)
    state = white.plus(Step().best(white, white.scan)).settled()
    assert state.evidence > white.evidence + base_fit.EVENT_EVIDENCE
    state, rivals = base_fit.against_bases(state, [{}])
    assert len(state.items) == len(rivals) == (jump > 0)
    if jump:
        assert max(rivals[0].values()) < -base_fit.EVENT_EVIDENCE
    assert "flicker" in [t.name for t in state.base]
