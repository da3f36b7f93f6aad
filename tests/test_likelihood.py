"""The likelihood of a whole model: exact where it can be checked, efficient, and with intervals
that mean what they say.
"""

import numpy as np
import pytest
from scipy.fft import dct
from scipy.linalg import toeplitz
from scipy.stats import kstest, norm

from imu_lib import preset
from imu_lib.errors import UndefinedFormError
from imu_lib.likelihood import (
    CANDIDATES,
    Statistics,
    choose,
    density,
    fast_end,
    fit,
    flat_level,
    log_likelihood,
    residuals,
)
from imu_lib.likelihood.kernel import weights
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    GaussMarkov2,
    LowPass,
    Quantization,
    Ramp,
    RandomWalk,
    Saturation,
    Sinusoid,
    Step,
    Sum,
    Temperature,
    WarmUp,
    WhiteNoise,
)

FS = 100.0
GYRO = WhiteNoise(N=7e-4) + GaussMarkov(sigma=2.3e-4, correlation_time=60.0)


def draw(model, seed, n=360_000, fs=FS, **options):
    return model.simulate(n, fs, np.random.default_rng(seed), **options)


def exact_covariance(model, n, fs):
    """Of the cosine coefficients 1 .. n-1, from autocovariances and the walk's min(j, k)."""
    k = np.arange(n)
    total = np.zeros((n, n))
    for term in model.terms:
        if term.name == "random_walk":
            total += term.K**2 / fs * np.minimum.outer(k, k)
        else:
            total += toeplitz(term.autocovariance(k / fs, fs))
    basis = dct(np.eye(n), norm="ortho", axis=0)[1:]
    return basis @ total @ basis.T


MODELS = {
    "white": WhiteNoise(N=1.0) + GaussMarkov(sigma=0.0, correlation_time=1.0),
    "walk": WhiteNoise(N=0.3) + RandomWalk(K=0.05),
    "Gauss-Markov": WhiteNoise(N=1.0) + GaussMarkov(sigma=0.7, correlation_time=6.0),
    "as long as a quarter of the record": WhiteNoise(N=0.3)
    + GaussMarkov(sigma=0.7, correlation_time=150.0),
    "second order": WhiteNoise(N=0.3) + GaussMarkov2(sigma=0.7, correlation_time=30.0),
    "quantization": WhiteNoise(N=0.3) + Quantization(Q=1.0),
}


@pytest.mark.parametrize("name", MODELS)
def test_expected_ordinates_are_the_exact_variances(name):
    """Within 0.6 %: what the leakage of coefficients above the 40th may leave out (2 Tc / T, Tc =
    T/20 at most there).
    """
    n, fs = 600, 1.0
    stats = Statistics.of(np.random.default_rng(1).standard_normal(n), fs, width=1e-9)
    expected = density(stats, MODELS[name])
    exact = 2 / fs * np.diag(exact_covariance(MODELS[name], n, fs))
    assert np.allclose(expected[:40], exact[:40], rtol=6e-3)
    assert np.allclose(expected[40:], exact[40:], rtol=6e-3 if name != "second order" else 3e-2)


def test_quantization_behind_a_filter_has_its_own_ends():
    """Those of the bare one would take more from the first ordinates than the filter leaves. What
    they share with the filtered samples next to them, some taps of n, is left out.
    """
    n, fs, taps = 600, 1.0, 12
    stats = Statistics.of(np.random.default_rng(1).standard_normal(n), fs, width=1e-9)
    behind = LowPass(taps=taps, rate=fs)
    expected = density(stats, Sum((Quantization(Q=1.0),), (behind,)))
    response = np.convolve(np.full(taps, 1 / taps), [1.0, -1.0]) * fs
    own = np.correlate(response, response, "full")[len(response) - 1 :]
    basis = dct(np.eye(n), norm="ortho", axis=0)[1:]
    exact = 2 / fs * np.diag(basis @ toeplitz(np.r_[own, np.zeros(n - len(own))]) @ basis.T)
    assert (expected > 0).all()
    assert np.allclose(expected[:80], exact[:80], rtol=0.06)


@pytest.mark.parametrize("name", ["walk", "Gauss-Markov", "as long as a quarter of the record"])
def test_coefficients_are_as_good_as_independent(name):
    """The covariance of the estimates from the exact covariance of the coefficients equals the
    inverse information that treats them as independent, to 1 % in the standard deviations."""
    n, fs, model = 600, 1.0, MODELS[name]
    covariance = exact_covariance(model, n, fs)
    labels = [(label, index, key) for label, index, key in model.labels()]
    slopes = []
    for label, index, key in labels:
        value = getattr(list(model)[index], key)
        up, down = (
            np.diag(exact_covariance(model.with_values({label: value * f}), n, fs))
            for f in (1.001, 0.999)
        )
        slopes.append((up - down) / 0.002 / np.diag(covariance))
    slopes = np.array(slopes)
    information = 0.5 * slopes @ slopes.T
    score = 0.5 * (slopes / np.diag(covariance)) @ covariance**2 @ (slopes / np.diag(covariance)).T
    claimed = np.linalg.inv(information)
    true = claimed @ score @ claimed
    assert np.allclose(np.sqrt(np.diag(claimed)), np.sqrt(np.diag(true)), rtol=0.01)


def test_kernel_rows_are_exact_for_walk_and_white():
    u, matrix = weights(40)
    assert np.allclose(matrix @ np.ones_like(u), 1.0, atol=1e-12)
    p = np.arange(1, 41)
    assert np.allclose(
        matrix @ u**-2 * (p / 2) ** 2, 1.0, atol=1e-4
    )  # the nodes end at 1e-4 cycles a record


def test_loglikelihood_is_that_of_the_coefficients():
    x = draw(WhiteNoise(N=1e-3) + RandomWalk(K=1e-5), 1, n=3000)
    stats = Statistics.of(x, FS, width=1e-9)
    model = WhiteNoise(N=1.2e-3) + RandomWalk(K=1e-5)
    c = dct(x - x.mean(), norm="ortho")[1:] * np.sqrt(2 / FS)
    sd = np.sqrt(density(stats, model))
    expected = norm.logpdf(c, scale=sd).sum() + 0.5 * len(c) * np.log(2 * np.pi)
    assert log_likelihood(stats, model) == pytest.approx(expected, rel=1e-12)


def test_the_mean_is_a_nuisance():
    x = draw(GYRO, 2, n=20_000)
    assert np.allclose(Statistics.of(x + 9.81, FS).power, Statistics.of(x, FS).power, rtol=1e-6)


def test_scores_are_standard_normal_under_the_truth():
    model = preset("3dm-gx3-25")["accel_z"]
    scores = residuals(Statistics.of(draw(model, 3), FS), model)
    assert kstest(scores, "norm").pvalue > 0.01  # of one fixed draw


def test_fit_finds_the_twin():
    model = preset("3dm-gx3-25")["accel_x"]
    template = WhiteNoise() + GaussMarkov() + RandomWalk() + model.low_pass
    found = fit(draw(model, 4), FS, template)
    # relative error of one hour's estimates: 0.1, 3, 10 and 10 %; four of them is the tolerance
    for label, index, key, tolerance in (
        ("N", 0, "N", 0.005),
        ("sigma", 1, "sigma", 0.12),
        ("correlation_time", 1, "correlation_time", 0.4),
        ("K", 2, "K", 0.4),
    ):
        truth = getattr(model.terms[index], key)
        assert found[label].value == pytest.approx(truth, rel=tolerance)
        assert found[label].low < found[label].value < found[label].high
    assert found.p_value > 1e-3
    assert found.loglike >= log_likelihood(found.statistics, model) - 1e-6
    assert flat_level(found).low < flat_level(found).value < flat_level(found).high


def test_intervals_cover():
    """Forty records of 200 correlation times: 120 intervals, no fewer than the binomial 3-sigma
    limit below 95 %.
    """
    model = WhiteNoise(N=0.1) + GaussMarkov(sigma=1.0, correlation_time=2.0)
    hits = []
    for seed in range(40):
        found = fit(draw(model, seed, n=4000, fs=10.0), 10.0, WhiteNoise() + GaussMarkov())
        hits += [
            found["N"].covers(0.1),
            found["sigma"].covers(1.0),
            found["correlation_time"].covers(2.0),
        ]
    assert 0.95 - 3 * np.sqrt(0.95 * 0.05 / 120) <= np.mean(hits)


def test_an_absent_term_has_an_upper_limit_that_holds():
    found = fit(draw(GYRO, 5), FS, WhiteNoise() + GaussMarkov() + RandomWalk())
    assert found["K"].value is None and found["K"].low == 0 and 0 < found["K"].high < 1e-4
    with_limit = log_likelihood(found.statistics, found.model.noise + RandomWalk(K=found["K"].high))
    assert with_limit < found.loglike - 0.5  # the limit itself is unlikely


def test_held_parameters_stay_and_warm_starts_agree():
    x = draw(GYRO, 6)
    stats = Statistics.of(x, FS)
    held = fit(stats, None, WhiteNoise(N=7e-4) + GaussMarkov(correlation_time=60.0))
    assert set(held.parameters) == {"sigma"} and held.model.terms[0].N == 7e-4
    cold = fit(stats, None, WhiteNoise() + GaussMarkov(), estimates=False)
    warm = fit(
        stats, None, WhiteNoise() + GaussMarkov(), starts=[GYRO], grid=False, estimates=False
    )
    assert warm.loglike == pytest.approx(cold.loglike, abs=1e-4)


def test_stretches_count_once_each():
    x = draw(GYRO, 7)
    parts = Statistics.of([x[:150_000], x[200_000:]], FS)
    assert parts.count.sum() == 310_000 - 2
    found = fit(parts, None, WhiteNoise() + GaussMarkov())
    assert found["N"].covers(7e-4) and found["sigma"].covers(2.3e-4)


@pytest.mark.parametrize(
    "drift, template, label, truth",
    [
        (Ramp(R=3e-6), Ramp(), "R", 3e-6),
        (
            Sinusoid(amplitude=3e-4, frequency=12.3, phase=0.5),
            Sinusoid(frequency=12.3),
            "amplitude",
            3e-4,
        ),
        (
            WarmUp(amplitude=3e-3, time_constant=300.0),
            WarmUp(time_constant=300.0),
            "amplitude",
            3e-3,
        ),
        (Step(amplitude=9e-4, time=1234.56), Step(), "amplitude", 9e-4),
    ],
)
def test_drifts_are_found_with_the_noise(drift, template, label, truth):
    found = fit(draw(GYRO + drift, 8, n=200_000), FS, WhiteNoise() + GaussMarkov() + template)
    assert found[label].low - 1e-12 <= truth <= found[label].high + 1e-12 or found[
        label
    ].value == pytest.approx(truth, rel=0.25)
    assert any(type(term) is type(drift) for term in found.model.terms)
    # the whole model, its drift included, is as likely as the fit says
    stats = Statistics.of(draw(GYRO + drift, 8, n=200_000), FS)
    assert log_likelihood(stats, found.model) == pytest.approx(found.loglike, abs=0.05)


def test_step_time_is_found_to_the_sample_when_it_stands_out():
    x = draw(WhiteNoise(N=1e-4) + Step(amplitude=2e-2, time=777.77), 9, n=150_000)
    found = fit(x, FS, WhiteNoise() + RandomWalk() + Step())
    assert found["time"].value == pytest.approx(777.77, abs=1e-9)


def test_temperature_is_a_regressor():
    t = np.linspace(0, 8, 100_000)
    temperature = 20 + t + np.sin(t)
    x = draw(GYRO + Temperature(slope=1e-3, reference=20.0), 10, n=100_000, temperature=temperature)
    found = fit(x, FS, WhiteNoise() + GaussMarkov() + Temperature(), temperature=temperature)
    assert found["slope"].covers(1e-3)


def test_filter_cutoff_is_fitted():
    x = draw(GYRO + LowPass(cutoff=20.0, order=2), 11)
    found = fit(x, FS, WhiteNoise() + GaussMarkov() + LowPass(order=2))
    assert found["cutoff"].value == pytest.approx(
        20.0, rel=0.005
    )  # its relative standard error is 0.1 %
    assert found.p_value > 1e-3


def test_fast_end_names_the_filter():
    moving = fast_end(draw(preset("3dm-gx3-25")["gyro_x"], 12), FS)
    taps = moving.stages[0]
    assert taps.taps / taps.rate == pytest.approx(0.015, rel=0.07)  # one step of the search's grid
    assert fast_end(draw(GYRO, 13), FS).stages == ()
    rounded = fast_end(draw(GYRO + Quantization(Q=3e-5), 14), FS)
    assert [t.name for t in rounded.extra] == ["quantization"]


@pytest.mark.parametrize(
    "name, truth",
    [
        ("white", WhiteNoise(N=7e-4) + LowPass(taps=1)),
        ("white + flicker", WhiteNoise(N=7e-4) + Flicker(B=2e-4)),
        (
            "white + Gauss-Markov",
            WhiteNoise(N=7e-4) + GaussMarkov(sigma=4e-4, correlation_time=20.0),
        ),
    ],
)
def test_choice_finds_what_made_the_record(name, truth):
    chosen = choose(draw(truth, 15), FS)
    assert chosen.name == name
    assert chosen.p_value > 1e-3
    assert sum(chosen.weights.values()) == pytest.approx(1.0)
    assert [row[0] for row in chosen.rows()][0] == name and len(chosen.rows()) == len(CANDIDATES)


def test_lines_are_left_out_and_listed():
    x = draw(GYRO + Sinusoid(amplitude=2e-3, frequency=17.0), 16)
    stats = Statistics.of(x, FS, exclude_lines=True)
    assert stats.lines[0][0] == pytest.approx(17.0, abs=0.01)
    assert stats.lines[0][1] == pytest.approx(
        2e-3 / np.sqrt(2), rel=0.1
    )  # the line's power leaks past a few ordinates
    assert fit(stats, None, WhiteNoise() + GaussMarkov())["N"].covers(7e-4)
    assert Statistics.of(draw(GYRO, 16), FS, exclude_lines=True).lines == ()


@pytest.mark.parametrize(
    "x, message",
    [
        (np.zeros(100), "constant"),
        (np.ones(4), "8 samples"),
        (np.array([1.0, np.nan] * 10), "finite"),
        (np.ones((3, 50)), "one dimension"),
    ],
)
def test_bad_records_are_refused(x, message):
    with pytest.raises(ValueError, match=message):
        Statistics.of(x, FS)


def test_bad_models_are_refused():
    stats = Statistics.of(draw(GYRO, 17, n=2000), FS)
    with pytest.raises(ValueError, match="`model`"):
        fit(stats, None, Ramp(R=1.0))
    with pytest.raises(ValueError, match="`criterion`"):
        choose(stats, None, criterion="hqc")
    with pytest.raises(UndefinedFormError):
        log_likelihood(stats, GYRO + Saturation(limit=1.0))


def test_a_record_in_many_pieces_computes_its_weights_once():
    """Stretches of every length between gaps ask for as many matrices as there are single bands."""
    from imu_lib.likelihood import kernel, layout

    assert kernel.weights.cache_parameters()["maxsize"] > layout.SINGLES
