"""Given the model that a record was drawn from, the workflow finds nothing: each process answers for
its own spectrum. The records are drawn by plain numpy.
"""

import numpy as np
import pytest
from scipy.signal import lfilter

from imu_lib import processes
from imu_lib.errors import UndefinedFormError
from imu_lib.gap.channel import analyse
from imu_lib.processes import (
    Autoregressive,
    Flicker,
    GaussMarkov,
    GaussMarkov2,
    LowPass,
    Quantization,
    RandomWalk,
    Sinusoid,
    Spikes,
    Stuck,
    Sum,
    Telegraph,
    WhiteNoise,
)
from imu_lib.samples.blocks import statistics

FS = 100.0
RESONANCE = (2 * 0.999 * np.cos(0.05), -(0.999**2))
NOISES = [
    WhiteNoise(1e-3),
    Quantization(1e-3),
    Flicker(1e-3),
    RandomWalk(1e-4),
    GaussMarkov(1e-3, 0.3),
    GaussMarkov(1e-3, 60.0),
    GaussMarkov2(1e-3, 20.0),
    Telegraph(1e-3, 0.05),
    Autoregressive((np.exp(-1 / 2000),), 1.0, FS),
    Autoregressive((-0.9,), 1.0, FS),
    Autoregressive(RESONANCE, 1.0, FS),
    Autoregressive((0.5, 0.3, 0.19), 1.0, FS),
]


def integral(psd, lags, m, fs, points=800_000):
    """Covariance of differenced block means from a spectrum, by the midpoint rule."""
    f = (np.arange(points) + 0.5) / points * fs / 2
    half = np.pi * f * m / fs
    density = psd(f) * (2 * np.sin(half) ** 2 / (m * np.sin(np.pi * f / fs))) ** 2
    return np.array([np.mean(density * np.cos(2 * half * j)) for j in lags]) * fs / 2


@pytest.mark.parametrize("process", NOISES, ids=lambda p: f"{p.name}")
def test_every_noise_has_the_power_that_the_likelihood_expects(process):
    """Over draws of it above white noise that is as strong at 1 Hz, as every sensor has some: each
    band to five standard deviations.
    """
    draws, n = 30, 12_000
    white = WhiteNoise(np.sqrt(process.psd(np.array([1.0]), FS)[0] / 2))
    rngs = [np.random.default_rng([11, k]) for k in range(draws)]
    drawn = [
        statistics(process.simulate(n, FS, rng) + white.simulate(n, FS, rng), FS) for rng in rngs
    ]
    ratio = sum(s.power for s in drawn) / drawn[0].layout.spectrum([process, white])
    count = draws * drawn[0].count
    # a hundredth more for what the ends of a record of two minutes add to a steep spectrum
    assert np.all(np.abs(ratio / count - 1) < 5 * np.sqrt(2 / count) + 0.01)


def test_every_process_of_the_catalogue_answers_or_says_that_it_cannot():
    answered = {p.name for p in NOISES}
    layout = statistics(np.random.default_rng(1).standard_normal(3000), FS).layout
    for name, kind in {**processes.OF_CHANNEL, **processes.OF_RECORD}.items():
        least = {"count": 1, "other": 4.0, "ratio": 4.0}
        values = {p.name: least.get(p.kind, 0.5) for p in kind.parameters if not p.optional}
        if name in answered or name == "low_pass":
            continue
        try:
            shape = layout.shape(kind(**values))
        except UndefinedFormError:
            continue
        assert np.all(np.isfinite(shape)) and np.all(shape >= 0), name


@pytest.mark.parametrize(
    "low_pass",
    [
        LowPass(order=1, cutoff=0.01),
        LowPass(order=4, cutoff=0.02),
        LowPass(smoothing=1, cutoff=0.5),
        LowPass(taps=15, rate=1000.0),
    ],
    ids=repr,
)
def test_allan_variance_behind_a_filter_is_the_integral_of_the_spectrum(low_pass):
    model = Sum((WhiteNoise(1.0), RandomWalk(0.02), GaussMarkov(0.1, 30.0)), (low_pass,))
    sizes = np.array([1, 10, 100, 1000])
    want = [integral(lambda f: model.psd(f, FS), [0], m, FS)[0] / 2 for m in sizes]
    # the lowest cell of the grid is wide beside the walk's: 0.1 %
    assert np.allclose(model.avar(sizes / FS, FS), want, rtol=2e-3)


def drawn(process, n, rng):
    """A realisation by code that shares nothing with the package's."""
    if process.name == "telegraph":
        waits = rng.exponential(1 / process.rate, int(4 * process.rate * n / FS) + 20)
        flips = np.searchsorted(np.cumsum(waits), np.arange(n) / FS)
        return process.amplitude * ((flips + rng.integers(2)) % 2 - 0.5)
    phi = np.array(process.phi)
    x = lfilter([1.0], np.concatenate([[1.0], -phi]), rng.standard_normal(n + 60_000))
    return process.sigma * x[-n:]


SLOW = [
    Telegraph(3e-3, 0.05),
    Autoregressive((np.exp(-1 / 2000),), 1e-4, FS),
    Autoregressive((2 * 0.9995 * np.cos(1e-3), -(0.9995**2)), 3e-6, FS),
]


@pytest.mark.parametrize("process", SLOW, ids=lambda p: f"{p.name}{len(getattr(p, 'phi', []))}")
def test_nothing_is_found_in_a_record_of_the_given_model(process):
    rng = np.random.default_rng(7)
    n = 120_000
    x = 1e-2 * rng.standard_normal(n) + drawn(process, n, rng)
    found = analyse("gyro_x", x, FS, Sum((WhiteNoise(1e-2 / np.sqrt(FS)), process)), seed=1)
    assert [s.effect for s in found.steps] == [] and found.unexplained is None


@pytest.mark.parametrize("seed", [9, 10])
@pytest.mark.parametrize("times", [1.0, 3.0])
def test_two_levels_that_stand_out_are_found_only_where_they_are_not_those_of_the_model(
    times, seed
):
    """A dwell of theirs is seen by eye; where it is that of the model, nothing is missing."""
    rng, n = np.random.default_rng(seed), 120_000
    noise, levels = WhiteNoise(N=2.5e-4), Telegraph(6.5e-4, 2e-2)
    x = noise.N * np.sqrt(FS) * rng.standard_normal(n) + times * drawn(levels, n, rng)
    result = analyse("gyro_x", x, FS, Sum((noise, levels)), seed=1)
    assert ([s.effect for s in result.steps] == []) == (times == 1.0), result.steps
    assert result.unexplained is None


def test_samples_that_are_frozen_as_the_model_says_are_no_noise_of_their_own():
    """Runs of half a second: their samples say nothing, whether a model foresees them or not."""
    rng, n, length = np.random.default_rng(12), 150_000, 50
    x = 3e-3 * rng.standard_normal(n)
    for start in rng.integers(0, n - length, 24):
        x[start : start + length + 1] = x[start]
    base = Sum((WhiteNoise(3e-3 / np.sqrt(FS)),), (Stuck(24 * length / n, length),))
    found = analyse("gyro_x", x, FS, base, seed=1)
    assert [s.effect for s in found.steps] == [] and found.unexplained is None


def test_nothing_is_found_behind_a_given_slow_filter():
    rng = np.random.default_rng(8)
    a = 1 - np.exp(-2 * np.pi * 0.05 / FS)
    x = lfilter([a], [1.0, a - 1.0], rng.standard_normal(150_000))[-120_000:]
    # the cutoff at which |a / (1 - (1 - a) e^-iw)|^2 is one half
    cutoff = FS / (2 * np.pi) * np.arccos(1 - a * a / (2 * (1 - a)))
    base = Sum((WhiteNoise(1 / np.sqrt(FS)),), (LowPass(smoothing=1, cutoff=cutoff),))
    found = analyse("gyro_x", x, FS, base, seed=1)
    assert [s.effect for s in found.steps] == [] and found.unexplained is None


@pytest.mark.parametrize("flips", [4, 9])
def test_the_flips_of_a_given_telegraph_are_no_steps(flips):
    """Few of them in a record, each plain to see: the spectrum knows less of them than their path."""
    n, fs = 60_000, 20.0
    rng, noise = np.random.default_rng(flips), WhiteNoise(N=2e-4)
    levels = Telegraph(amplitude=4.4e-4, rate=flips * fs / n)
    for _ in range(2):
        x = noise.N * np.sqrt(fs) * rng.standard_normal(n)
        x += levels.amplitude * (np.cumsum(rng.random(n) < levels.rate / fs) % 2)
        found = analyse("gyro_x", x, fs, Sum((noise, levels)), seed=1)
        assert [s.effect for s in found.steps] == [] and found.unexplained is None
        assert levels in found.model.terms


def test_the_small_ones_of_given_spikes_are_no_heavy_tails():
    """Half of the heights lie where noise is seen, too."""
    rng, n = np.random.default_rng(13), 200_000
    x = rng.standard_normal(n) * 2e-3
    x += (rng.random(n) < 0.007) * rng.standard_normal(n) * 1.5e-2
    base = Sum((WhiteNoise(N=2e-3 / np.sqrt(FS)),), (Spikes(rate=0.007 * FS, scale=1.5e-2),))
    found = analyse("gyro_x", x, FS, base, seed=1)
    assert [s.effect for s in found.steps] == [] and found.unexplained is None


def test_a_given_path_that_is_half_seen_is_judged_as_noise_as_well():
    """Beside a slow noise the path takes some of that, too."""
    rng, n, fs = np.random.default_rng(5), 60_000, 20.0
    noise, slow, levels = WhiteNoise(N=2.8e-4), GaussMarkov(5.6e-5, 170.0), Telegraph(5.7e-4, 0.054)
    x = noise.N * np.sqrt(fs) * rng.standard_normal(n)
    flips = np.cumsum(rng.random(n) < -np.expm1(-levels.rate / fs))
    x += levels.amplitude * (flips % 2) + slow.simulate(n, fs, rng)
    found = analyse("gyro_x", x, fs, Sum((noise, slow, levels)), seed=1)
    assert [s.effect for s in found.steps] == [] and found.unexplained is None


def a_line(amplitude, phase, n=15_000, fs=50.0):
    rng, t = np.random.default_rng(21), np.arange(n) / fs
    x = 1e-4 * np.sqrt(fs) * rng.standard_normal(n)
    return x + amplitude * np.sin(2 * np.pi * 7.0 * t + phase), fs


HUM = WhiteNoise(1e-4) + Sinusoid(amplitude=3.5e-4, frequency=6.99995, phase=0.09)


@pytest.mark.parametrize("phase", [0.09, 1.2, 3.2])
def test_a_line_in_another_phase_is_the_line_that_was_given(phase):
    """A model grown on one day keeps the phase of that day."""
    x, fs = a_line(3.5e-4, phase)
    found = analyse("gyro_x", x, fs, HUM)
    assert not found.steps and found.unexplained is None
    assert abs(np.exp(1j * found.model.find("sinusoid").phase) - np.exp(1j * phase)) < 0.2


def test_a_line_that_is_gone_or_stronger_is_told():
    x, fs = a_line(0.0, 0.0)
    assert [s.effect for s in analyse("gyro_x", x, fs, HUM).steps] == ["sinusoid"]
    x, fs = a_line(7e-4, 1.2)
    (step,) = analyse("gyro_x", x, fs, HUM).steps
    assert step.effect == "sinusoid"
    assert abs(step.parameters["amplitude"] / 3.5e-4 - 1) < 0.1
