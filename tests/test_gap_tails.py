"""The distribution and the level of the noise: heavy tails, a level that wanders, and what looks
like either.
"""

import numpy as np
import pytest
from gap_unknowns import unknown
from scipy import signal

from imu_lib.gap.channel import OfRecord, analyse
from imu_lib.gap.effects.noise_level_change import unsteady
from imu_lib.gap.effects.wandering_level import PERIODIC, SPREAD, Level
from imu_lib.processes import HeavyTails, Sum, WhiteNoise
from imu_lib.samples.leaning import leaning

FS, N = 100.0, 60_000
BASE = Sum((WhiteNoise(N=1e-4),))
SD = 1e-4 * np.sqrt(FS)


def wandering(rng, sd, seconds, fs=FS, n=N):
    """exp of a Gauss-Markov process."""
    pole = np.exp(-1 / (fs * seconds))
    g = signal.lfilter(
        [np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(n + 5 * int(fs * seconds))
    )
    return np.exp(sd * g[-n:])


@pytest.mark.parametrize("freedom", [3.0, 5.0, 9.0])
@pytest.mark.parametrize("base", [BASE, None], ids=["given", "free"])
def test_heavy_tails_have_their_freedom(freedom, base):
    rng = np.random.default_rng(int(freedom))
    x = SD * rng.standard_t(freedom, N) * np.sqrt((freedom - 2) / freedom)
    found = analyse("gyro_x", x, FS, base)
    (step,) = found.steps
    assert step.effect == "heavy_tails" and step.confidence > 0.9
    low, high = step.intervals["freedom"]
    # of three intervals of 95 % one is allowed to miss by as much as it is wide
    assert low - (high - low) / 2 < freedom < high + (high - low) / 2
    assert found.unexplained is None


@pytest.mark.parametrize(("sd", "seconds"), [(0.35, 40.0), (0.15, 15.0)])
def test_a_level_that_wanders_has_its_size_and_time(sd, seconds):
    rng = np.random.default_rng(7)
    x = SD * wandering(rng, sd, seconds) * rng.standard_normal(N)
    found = analyse("accel_x", x, FS, None)
    (step,) = found.steps
    assert step.effect == "wandering_level" and step.confidence > 0.9
    # 15 and 40 correlation times: 25 % and 16 % in its size, half in its time
    assert step.parameters["sd"] == pytest.approx(sd, rel=0.5)
    assert step.parameters["correlation_time"] == pytest.approx(seconds, rel=0.8)
    assert found.unexplained is None


def test_a_level_that_wanders_and_heavy_tails_are_both_named():
    rng = np.random.default_rng(8)
    x = SD * wandering(rng, 0.4, 20.0) * rng.standard_t(5, N) * np.sqrt(3 / 5)
    found = analyse("accel_x", x, FS, BASE)
    assert {s.effect for s in found.steps} >= {"wandering_level", "heavy_tails"}


def test_one_change_of_level_and_spikes_keep_their_names():
    rng = np.random.default_rng(9)
    x = SD * rng.standard_normal(N)
    x[N // 3 :] *= 1.4
    assert [s.effect for s in analyse("gyro_x", x, FS, BASE).steps] == ["noise_level_change"]
    x = SD * rng.standard_normal(N)
    hit = rng.random(N) < 2e-3
    x[hit] += 12 * SD * rng.standard_normal(hit.sum())
    assert [s.effect for s in analyse("gyro_x", x, FS, BASE).steps] == ["spikes"]


def test_normal_noise_behind_a_filter_has_neither():
    rng = np.random.default_rng(10)
    x = signal.lfilter([0.3], [1, -0.7], SD * rng.standard_normal(N))
    names = {s.effect for s in analyse("gyro_x", x, FS, None).steps}
    assert not names & {"heavy_tails", "wandering_level"}


@pytest.mark.parametrize("shape", [np.sin, lambda phase: np.sign(np.sin(phase))])
def test_a_level_with_a_period_does_not_wander(shape):
    rng = np.random.default_rng(11)
    phase = 2 * np.pi * np.arange(N) / (FS * 40.0)
    x = SD * (1 + 0.3 * shape(phase)) * rng.standard_normal(N)
    found = analyse("accel_x", x, FS, BASE)
    assert "period of 40" in found.unexplained
    assert not [s.effect for s in found.steps if s.confidence >= 0.9]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_level_that_wanders_smoothly_has_no_period(order):
    """A chain of Gauss-Markov processes has another spectrum than one of them, and no peak."""
    rng = np.random.default_rng(order)
    pole = np.exp(-1 / (FS * 20.0 / order))
    g = rng.standard_normal(2 * N)
    for _ in range(order):
        g = signal.lfilter([1], [1, -pole], g)
    level = Level(np.exp(0.3 * g[N:] / np.std(g)) * rng.standard_normal(N), FS, 1.0)
    sd, time, _ = level.fit()
    assert level.period(sd, time)[0] > PERIODIC


def test_bursts_of_a_few_samples_are_not_the_level():
    """What comes in clusters of a few loud samples says nothing of the rest."""
    rng = np.random.default_rng(12)
    often = np.repeat(wandering(rng, 1.0, 30.0, n=N // 100, fs=1.0) * 0.02, 100)
    y = rng.standard_normal(N)
    y[rng.random(N) < often] *= 3.0
    level = Level(y, FS, 1.0)
    _, foretold = level.smoothed(*level.fit()[:2])
    assert level.shown(foretold) < SPREAD
    level = Level(wandering(rng, 0.2, 30.0) * rng.standard_normal(N), FS, 1.0)
    _, foretold = level.smoothed(*level.fit()[:2])
    assert level.shown(foretold) == pytest.approx(1.0, abs=0.15)


def test_the_level_of_half_a_minute_is_looked_at_in_shorter_blocks():
    """A level that wanders by 35 % over a second, and no level of noise that keeps its own: the
    p-values of a steady level fall below 1e-4 once in two thousand records (measured on 12,000).
    """
    n, fs = 6_400, 200.0
    rng = np.random.default_rng(4)
    level = wandering(rng, 0.35, 1.0, fs, n)
    found = analyse("gyro_x", level * rng.standard_normal(n), fs, None)
    assert [s.effect for s in found.steps] == ["wandering_level"]
    steady = [unsteady(rng.standard_normal(n), fs)[0] for _ in range(60)]
    assert min(steady) > -4


def test_spikes_on_noise_with_heavy_tails_are_both_named():
    rng = np.random.default_rng(3)
    x = rng.standard_t(5, 40_000) * np.sqrt(3 / 5)
    alone = [s.effect for s in analyse("accel_x", x, 100.0, None).steps]
    assert alone == ["heavy_tails"]
    x[rng.integers(0, len(x), 80)] += 20 * rng.standard_normal(80)
    steps = {s.effect: s.parameters for s in analyse("accel_x", x, 100.0, None).steps}
    assert set(steps) == {"spikes", "heavy_tails"}
    # 80 in 400 s; the smallest drown in the tails
    assert steps["spikes"]["rate"] == pytest.approx(0.2, rel=0.3)
    assert steps["spikes"]["scale"] == pytest.approx(20.0, rel=0.25)


def test_noise_that_grows_all_along_is_a_change_with_a_duration():
    """A straight rise to 2.5 times: the noise at the start, and the factor, to a few per cent."""
    rng = np.random.default_rng(10)
    x = SD * np.linspace(1.0, 2.5, N) * rng.standard_normal(N)
    found = analyse("gyro_x", x, FS, None)
    (step,) = found.steps
    p = step.parameters
    assert step.effect == "noise_level_change" and step.confidence > 0.9
    assert p["ratio"] == pytest.approx(2.5, rel=0.05)
    assert p["time"] + p["duration"] == pytest.approx(N / FS, rel=0.05)
    assert "the noise grows from" in step.where and found.unexplained is None


def test_tails_longer_to_one_side_are_leaning_ones_and_clicks_and_a_bent_scale_are_not():
    tails = HeavyTails(12.0, 0.3)
    x = tails.given(np.random.default_rng(5).standard_normal(40_000), 1.0, np.random.default_rng(6))
    gain, found, sd = leaning(x, 12.0)
    assert gain > 20 and abs(found.lean - 0.3) < 4 * sd < 0.2
    for strange in ("bent", "clicks"):
        y = np.random.default_rng(7).standard_normal(40_000)
        assert leaning(unknown(strange, y, 100.0, np.random.default_rng(8), 1.0), 12.0) is None


def test_tails_on_steps_as_wide_as_the_noise_keep_their_freedom():
    """Rounding errors are even: counted with them, tails of 7 pass for 11."""
    rng = np.random.default_rng(21)
    x = np.rint(0.9 * rng.standard_t(7, N) * np.sqrt(5 / 7) + 0.3)
    found = analyse("accel_y", x, FS, None)
    steps = {s.effect: s for s in found.steps}
    assert set(steps) == {"resolution", "heavy_tails"}
    low, high = steps["heavy_tails"].intervals["freedom"]
    # one interval of 95 % may miss by a quarter of its width
    assert low - (high - low) / 4 < 7.0 < high + (high - low) / 4
    assert found.unexplained is None


def test_normal_noise_on_few_levels_has_no_tails():
    rng = np.random.default_rng(22)
    for sd in (0.7, 0.9, 1.4):
        x = np.rint(sd * rng.standard_normal(N) + 0.2)
        assert [s.effect for s in analyse("accel_y", x, FS, None).steps] == ["resolution"]


def test_tails_of_a_channels_own_noise_beside_noise_in_common():
    """Half of the power is normal noise of the record: the excess of the sum, 6 / 4, is a quarter
    of 6, which is that of a freedom of 5.
    """
    rng = np.random.default_rng(23)
    x = SD * rng.standard_t(5, N) * np.sqrt(3 / 5) + SD * rng.standard_normal(N)
    found = analyse("accel_y", x, FS, None, of_record=OfRecord(shared=1e-4))
    (step,) = [s for s in found.steps if s.effect == "heavy_tails"]
    # the likeliest freedom of a sum that is not Student's is not that of its fourth moment
    assert step.parameters["freedom"] == pytest.approx(5.0, abs=1.0)


def test_a_given_model_with_the_tails_of_the_record_explains_it():
    rng = np.random.default_rng(24)
    model = Sum((WhiteNoise(N=1e-4),), (HeavyTails(6.0),))
    x = SD * rng.standard_t(6, N) * np.sqrt(4 / 6)
    found = analyse("gyro_x", x, FS, model)
    assert not found.steps and found.unexplained is None
    (step,) = analyse("gyro_x", x, FS, Sum(model.terms, (HeavyTails(20.0),))).steps
    assert step.effect == "heavy_tails"
