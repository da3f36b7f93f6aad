"""The likelihood of the gap workflow: closed forms of the slow end, recovery of known parameters,
whitening.
"""

import numpy as np
import pytest

from imu_lib.ensembles.draws import Draws
from imu_lib.ensembles.ensemble import draw, index
from imu_lib.gap.channel import _doubtful
from imu_lib.gap.data import Data
from imu_lib.gap.effects import CATALOGUE
from imu_lib.gap.preprocess import OfRecord
from imu_lib.gap.steps import Step
from imu_lib.likelihood import Statistics, density, tapered
from imu_lib.likelihood.evidence import maximum
from imu_lib.likelihood.problem import Problem
from imu_lib.likelihood.slot import Slot
from imu_lib.likelihood.statistics import cosines
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    GaussMarkov2,
    LowPass,
    Quantization,
    Ramp,
    RandomWalk,
    Sum,
    WarmUp,
    WhiteNoise,
)
from imu_lib.processes import Step as StepProcess
from imu_lib.samples.blocks import statistics

FS, M = 100.0, 400
PROCESSES = [
    WhiteNoise(1e-3),
    Quantization(1e-3),
    Flicker(1e-3),
    RandomWalk(1e-4),
    GaussMarkov(1e-3, 1.0),
    GaussMarkov(1e-3, 50.0),
    GaussMarkov2(1e-3, 30.0),
]


def test_parameters_of_a_known_sum_are_recovered_within_their_intervals():
    rng = np.random.default_rng(20240101)
    truth = [WhiteNoise(1e-3), GaussMarkov(3e-4, 30.0)]
    x = sum(p.simulate(180_000, FS, rng) for p in truth)
    data = Data(x, FS)
    slots = [
        Slot(0, ("N",), (-20.0,), (5.0,), (7.0,)),
        Slot(1, ("sigma", "correlation_time"), (-20.0, -3.0), (5.0, 7.0), (7.0, 9.0)),
    ]
    fit = maximum(Problem(data.stats, [WhiteNoise(2e-3), GaussMarkov(1e-4, 100.0)], slots))
    want = np.log([1e-3, 3e-4, 30.0])
    # four standard deviations: one seed in some ten thousand would fail by chance
    assert np.all(np.abs(fit.vector - want) < 4 * np.sqrt(np.diag(fit.cov)))
    assert np.sqrt(fit.cov[0, 0]) < 0.005


def test_a_drift_column_takes_its_amplitude():
    rng = np.random.default_rng(3)
    data = Data(WhiteNoise(1e-3).simulate(120_000, FS, rng) + 1e-6 * np.arange(120_000) / FS, FS)
    shapes = data.stats.regressors_of(data.columns(data.grid_time[:, None]))
    fit = maximum(Problem(data.stats, [WhiteNoise(1e-3)], regressors=shapes))
    assert abs(fit.beta[0] - 1e-6) < 4 * np.sqrt(fit.beta_cov[0, 0])


@pytest.mark.parametrize("n", [6_000, 6_001, 90_001])
def test_columns_are_the_cosine_coefficients_of_the_drift(n):
    """Of shapes evaluated on a grid, and of a step in closed form, against the transform of all
    samples: to a hundredth of the whole, what a grid of four points a block makes of an edge less.
    """
    data, t = Data(np.random.default_rng(1).standard_normal(n), FS), np.arange(n) / FS
    whole = data.stats.slow_ordinates(np.ones(len(data.stats.power)))
    assert len(whole) == data.orders
    for effect, process in (
        (CATALOGUE["ramp"], Ramp(R=1.0)),
        (CATALOGUE["warm_up"], WarmUp(amplitude=1.0, time_constant=0.1 * n / FS)),
        (CATALOGUE["step"], StepProcess(amplitude=1.0, time=0.3127 * n / FS)),
    ):
        exact = cosines(process.mean(t), FS)[: data.orders]
        column = effect.columns([process], data)[:, 0]
        assert np.linalg.norm(column - exact) < 0.01 * np.linalg.norm(exact)


def test_split_statistics_have_the_level_of_white_noise_and_no_leak_in_a_stop_band():
    x = WhiteNoise(1e-3).simulate(60_000, FS, np.random.default_rng(4))
    stats = statistics(x, FS)
    level = stats.power.sum() / stats.count.sum()
    assert abs(level / 2e-6 - 1) < 5 * np.sqrt(2 / stats.count.sum())
    assert tapered.padded(60_001) >= 60_001
    # behind a filter of fourth order this band is far below what an untapered transform spreads
    model = Sum((WhiteNoise(1e-3),), (LowPass(order=4, cutoff=1.0, rate=FS),))
    x = model.simulate(60_000, FS, np.random.default_rng(5))
    stats = statistics(x, FS)
    deep = np.abs(stats.frequency - 25.0) < 5.0
    expected = stats.layout.spectrum(model.terms, model.low_pass)
    ratio = (stats.power[deep] / expected[deep]).sum() / stats.count[deep].sum()
    assert abs(ratio - 1) < 5 * np.sqrt(2 / stats.count[deep].sum())
    bare = Statistics.of(x, FS).between(20.0, 30.0)
    assert np.median(bare.power / bare.count / density(bare, model)) > 10  # an untapered transform


def test_evidence_is_the_integral_of_the_likelihood_over_the_priors():
    """Of one amplitude, whose posterior is near normal: Laplace's method against the sum."""
    x = WhiteNoise(1e-3).simulate(2_000, FS, np.random.default_rng(6))
    slot = Slot(0, ("N",), (-20.0,), (5.0,), (np.log(1e3),))
    problem = Problem(statistics(x, FS), [WhiteNoise(2e-3)], [slot])
    fit = maximum(problem)
    theta = fit.vector[0] + np.linspace(-0.3, 0.3, 601)
    values = np.array([problem.loglike(np.array([v])) for v in theta])
    integral = fit.ll + np.log(np.sum(np.exp(values - fit.ll)) * 0.001 / np.log(1e3))
    assert fit.evidence == pytest.approx(integral, abs=0.02)


def test_bands_left_out_say_nothing_and_electronics_add_their_density():
    rng = np.random.default_rng(7)
    x = WhiteNoise(1e-3).simulate(60_000, FS, rng)
    clean, loud = (
        statistics(x, FS),
        statistics(x + 1e-2 * np.sin(2 * np.pi * 20 * np.arange(60_000) / FS), FS),
    )
    blind = np.abs(clean.frequency - 20.0) < 2.0
    terms, slot = [WhiteNoise(2e-3)], Slot(0, ("N",), (-20.0,), (5.0,), (7.0,))
    a, b = (maximum(Problem(s.without(blind), terms, [slot])) for s in (clean, loud))
    assert a.vector == pytest.approx(b.vector, abs=1e-4)
    step = 4e-3
    rounded = np.round(x / step) * step
    extra = np.full(len(clean.power), step**2 / 6 / FS)
    found = maximum(Problem(statistics(rounded, FS), terms, [slot], extra=extra))
    assert abs(found.vector[0] - np.log(1e-3)) < 5 * np.sqrt(found.cov[0, 0])


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_noise_behind_a_filter_inside_the_sensor_is_drawn_with_its_folded_spectrum(rate):
    """The ensemble's short cut against the filter itself, run as fast as the sensor is read and
    ten times as fast.
    """
    model = Sum(
        (
            WhiteNoise(N=1e-3),
            GaussMarkov(sigma=5e-3, correlation_time=0.02),
            GaussMarkov(sigma=2e-3, correlation_time=40.0),
            RandomWalk(K=1e-3),
        ),
        (LowPass(order=2, cutoff=10.0, rate=rate),),
    )
    spectra = []
    for x in (
        draw(model, Draws(3, 200_000, 100.0)),
        model.simulate(200_000, 100.0, np.random.default_rng(3)),
    ):
        spectra.append(np.abs(np.fft.rfft(x * np.hanning(len(x)))[1:]) ** 2)
    bins = np.geomspace(2000, 99_000, 9).astype(int)
    for a, b in zip(bins[:-1], bins[1:]):
        assert abs(spectra[0][a:b].mean() / spectra[1][a:b].mean() - 1) < 5 * np.sqrt(
            2 * 2 / (b - a)
        )  # a Hann window halves the ordinates


def test_models_of_a_simulation_share_what_they_have_in_common():
    base = Sum((WhiteNoise(N=1e-3), GaussMarkov(sigma=5e-3, correlation_time=20.0)))
    grown = base + GaussMarkov(sigma=3e-3, correlation_time=2.0)
    draws = Draws([5, 1], 50_000, 100.0)
    added = draw(grown, draws) - draw(base, draws)
    alone = GaussMarkov(sigma=3e-3, correlation_time=2.0).simulate(
        50_000, 100.0, draws.rng("gauss_markov", 1)
    )
    assert np.allclose(added, alone, atol=1e-15)
    # the second process of a kind is independent of the first: 50 s / 2 s blocks leave a
    # correlation of some 1 / sqrt(250)
    first = draw(base, draws) - draw(Sum((base.terms[0],)), draws)
    assert abs(np.corrcoef(added, first)[0, 1]) < 5 / np.sqrt(250)
    assert not np.allclose(draw(base, draws), draw(base, Draws([5, 2], 50_000, 100.0)))


def test_gap_index_is_one_for_one_more_simulation_and_counts_standard_deviations():
    rng = np.random.default_rng(4)

    def draw_statistics(shift=0.0):
        return {
            "psd": rng.standard_normal(32),
            "allan": shift + rng.standard_normal(10),
            "distribution": np.array([-4.0]),
        }

    rows = [draw_statistics() for _ in range(100)]
    values = [index(draw_statistics(), rows).value for _ in range(50)]
    assert (
        abs(np.mean(values) - 1) < 0.1 and np.std(values) < 0.2
    )  # 42 statistics: a scatter of 1 / sqrt(84)
    moved = index(draw_statistics(shift=10.0), rows)
    assert (
        3.5 < moved.value < 7 and 7 < moved.domains["allan"] < 13
    )  # ten of 43 statistics at ten standard deviations
    # a statistic that all simulations share is given a scatter of two per cent, not of rounding
    assert index({**rows[0], "distribution": np.array([-4.001])}, rows).value < 1.5
    assert index({**rows[0], "distribution": np.array([-3.0])}, rows).domains["distribution"] > 10


def test_what_the_make_of_another_effect_explains_has_no_high_confidence():
    def step(effect, **parameters):
        return Step(effect, parameters, {}, "", 1.0, {}, [])

    slope = [step("low_pass", cutoff=10.0), step("quantization", Q=1e-5)]
    (shaken,) = _doubtful([step("autoregressive", phi=[0.27, -0.41])], OfRecord(band=True))
    assert shaken.confidence == 0.5 and shaken.indistinguishable == ["vibration"]
    assert [s.confidence < 0.9 for s in _doubtful(slope, OfRecord())] == [False, True]
    change = step(
        "parameter_change", process="white_noise", name="N", **{"from": 1.0e-3, "to": 0.99e-3}
    )
    assert _doubtful([change], OfRecord())[0].confidence == 1.0
    assert (
        _doubtful([change], OfRecord(1e-3))[0].confidence < 0.9
    )  # 2 % of the density of the noise in common
    assert (
        _doubtful([step("resolution", lsb=1e-3), step("quantization", Q=1e-5), change], OfRecord())[
            2
        ].confidence
        < 0.9
    )
