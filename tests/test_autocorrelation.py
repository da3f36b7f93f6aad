"""Autocorrelation: against statsmodels, Bartlett's formula and exact means, and the coverage of
its intervals.
"""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from statsmodels.tsa.stattools import acf

from imu_lib import autocorrelation as ac
from imu_lib.processes import GaussMarkov, RandomWalk, WhiteNoise


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000), st.integers(12, 900), st.floats(-1e3, 1e3))
def test_autocorrelation_and_bartlett_bands_equal_statsmodels(seed, n, offset):
    x = np.cumsum(np.random.default_rng(seed).standard_normal(n)) + offset
    lags = min(n - 2, 100)
    rho, band = acf(x, nlags=lags, fft=True, alpha=0.05, result_object=False)
    ours = ac.autocorrelation(x, 10.0, max_lag=lags / 10.0)
    np.testing.assert_allclose(ours.rho, rho, atol=1e-9)
    np.testing.assert_allclose(np.column_stack(ours.interval()), band, atol=1e-9)


def test_many_and_few_lags_agree():
    x = np.random.default_rng(1).standard_normal(5000)
    np.testing.assert_allclose(ac.autocovariance(x, 50), ac.autocovariance(x, 300)[:51], atol=1e-14)


def test_white_noise_stays_in_its_band():
    # 5 % of 400 independent lags outside: standard deviation 1.1 %; four of them.
    curve = ac.autocorrelation(np.random.default_rng(2).standard_normal(200_000), 1.0, max_lag=400)
    assert curve.share_outside == pytest.approx(0.05, abs=0.044)


def _ar1(reps, n, phi, rng):
    w = rng.standard_normal((reps, n))
    w[:, 1:] *= np.sqrt(1 - phi**2)
    return lfilter([1.0], [1.0, -phi], w, axis=1)


def test_mean_and_covariance_of_sample_autocovariances_over_realisations():
    n, lags, phi, reps = 1000, 20, 0.8, 4000
    x = _ar1(reps, n, phi, np.random.default_rng(3))
    x -= x.mean(axis=1, keepdims=True)
    sample = (
        np.array([np.einsum("ij,ij->i", x[:, : n - h], x[:, h:]) for h in range(lags + 1)]).T / n
    )
    gamma = phi ** np.arange(n)
    expected = ac.expected_autocovariance(gamma, n, lags)
    # The mean is exact: five standard errors at most over 21 lags.
    assert np.max(np.abs(sample.mean(axis=0) - expected) / (sample.std(axis=0) / np.sqrt(reps))) < 5
    # Bartlett's formula is for n -> infinity: here T = 220 Tc, 3 % for that and 5 % for 4000 draws
    # of a variance.
    ratio = np.cov(sample.T).diagonal() / ac.bartlett_covariance(gamma, n, lags).diagonal()
    np.testing.assert_allclose(ratio, 1.0, atol=0.08)
    mean_removed = expected - (1 - np.arange(lags + 1) / n) * gamma[: lags + 1]
    assert np.all(mean_removed < 0)  # removing the mean pulls the whole curve down


def _fits(model, fs, duration, reps, seed):
    return [
        ac.fit_gauss_markov(
            model.simulate(int(duration * fs), fs, np.random.default_rng([seed, i])), fs
        )
        for i in range(reps)
    ]


@pytest.mark.parametrize(
    ("model", "fs", "duration"),
    [
        (GaussMarkov(sigma=1.0, correlation_time=10.0) + WhiteNoise(N=0.0), 2.0, 2000.0),
        (GaussMarkov(sigma=1.0, correlation_time=100.0) + WhiteNoise(N=2.24), 1.0, 20_000.0),
        (GaussMarkov(sigma=1.0, correlation_time=100.0) + WhiteNoise(N=2.24), 1.0, 5000.0),
        (
            GaussMarkov(sigma=1.0, correlation_time=4.0) + WhiteNoise(N=0.6) + RandomWalk(K=0.1),
            2.0,
            6000.0,
        ),
    ],
    ids=["alone", "under white noise", "50 correlation times", "with a walk"],
)
def test_intervals_cover_as_they_say(model, fs, duration):
    # 24 realisations and two parameters: 95 % nominal, 19 of 24 or fewer has a probability of
    # 0.0009.
    fits = _fits(model, fs, duration, 24, 4)
    truth = model.terms[0]
    assert np.mean([f.sigma.covers(truth.sigma) for f in fits]) > 19 / 24
    assert np.mean([f.correlation_time.covers(truth.correlation_time) for f in fits]) > 19 / 24
    # ... and not because they are wide: their width is the scatter of 24 estimates, known to 15 %.
    scatter = np.std(np.log([f.sigma.value for f in fits if f.sigma.shown]))
    width = np.median([np.log(f.sigma.high / f.sigma.low) for f in fits if f.sigma.shown]) / 3.92
    assert 0.6 < width / scatter < 1.6


def test_plain_least_squares_intervals_do_not_cover():
    # The reason for the covariance: independent-lag intervals of the same fit miss the truth most
    # of the time.
    from scipy.optimize import curve_fit

    x = _ar1(60, 4000, np.exp(-0.05), np.random.default_rng(5))
    hits = []
    for row in x:
        curve = ac.autocorrelation(row, 1.0, max_lag=100)
        best, covariance = curve_fit(
            lambda t, s, tc: s * np.exp(-t / tc),
            curve.lag,
            curve.rho * curve.variance,
            p0=(1.0, 20.0),
        )
        hits.append(abs(best[1] - 20.0) < 1.96 * np.sqrt(covariance[1, 1]))
    assert np.mean(hits) < 0.6


def test_two_hundred_correlation_times_give_ten_percent_of_the_variance():
    # Brown and Hwang's rule, T = 200 Tc; 2000 realisations give the scatter to 1.6 %, the removed
    # mean costs 1 %.
    assert ac.variance_uncertainty(2000.0, 10.0) == pytest.approx(0.1)
    assert ac.record_for(10.0) == pytest.approx(2000.0)
    variance = np.var(_ar1(2000, 4000, np.exp(-1 / 20), np.random.default_rng(6)), axis=1)
    assert np.std(variance) / np.mean(variance) == pytest.approx(0.1, rel=0.06)
    assert np.std(np.sqrt(variance)) == pytest.approx(0.05, rel=0.07)


def test_white_noise_is_rarely_taken_for_a_process():
    # At most 1 in 100; 5 of 150 would be a rate of 1 % with probability 0.02.
    fits = _fits(WhiteNoise(N=1.0), 10.0, 1000.0, 150, 7)
    shown = sum(f.sigma.shown for f in fits)
    assert shown < 5
    absent = next(f for f in fits if not f.sigma.shown)
    assert absent.sigma.value is None and absent.sigma.low == 0 and 0 < absent.sigma.high < 1
    assert absent.N.covers(1.0)


def test_reading_off_is_right_without_white_noise_and_wrong_with_it():
    rng = np.random.default_rng(8)
    process = GaussMarkov(sigma=2.0, correlation_time=5.0)
    x = process.simulate(200_000, 20.0, rng)  # 2000 correlation times: 3 % of the variance
    sigma, tc = ac.read_off(ac.autocorrelation(x, 20.0, max_lag=60.0))
    assert sigma == pytest.approx(2.0, rel=0.06) and tc == pytest.approx(5.0, rel=0.12)
    noisy = ac.autocorrelation(x + 4 * rng.standard_normal(x.size), 20.0, max_lag=60.0)
    assert ac.read_off(noisy)[1] < 0.1


def test_a_filter_of_the_electronics_is_not_a_process():
    white = np.random.default_rng(9).standard_normal(600_000)
    x = lfilter(np.ones(15) / 15, 1.0, white)[14::10]  # 15 taps at 1 kHz, then 100 Hz
    assert not ac.fit_gauss_markov(x, 100.0).sigma.shown


def test_a_pure_walk_has_no_upper_limit_of_correlation_time_that_means_anything():
    fit = ac.fit_gauss_markov(
        RandomWalk(K=1.0).simulate(20_000, 1.0, np.random.default_rng(10)), 1.0
    )
    assert not fit.sigma.shown or fit.correlation_time.high > 1000 or fit.K.covers(1.0)


def test_result_speaks_for_itself():
    x = GaussMarkov(sigma=1.0, correlation_time=3.0).simulate(
        20_000, 10.0, np.random.default_rng(11)
    )
    fit = ac.fit_gauss_markov(x, 10.0)
    assert fit.process.correlation_time == fit.correlation_time.value
    assert fit.lag.shape == fit.autocovariance.shape == fit.fitted.shape
    assert ac.characterise(x, 10.0) == {
        "sigma": fit.sigma,
        "correlation_time": fit.correlation_time,
    }
    scaled = ac.characterise(1e-6 * x + 9.8, 10.0)
    assert scaled["sigma"].value == pytest.approx(1e-6 * fit.sigma.value, rel=1e-6)


def test_seven_hours_at_100_hz_take_no_time():
    model = GaussMarkov(sigma=2e-4, correlation_time=280.0) + WhiteNoise(N=7e-4)
    x = model.simulate(2_520_000, 100.0, np.random.default_rng(12))
    start = time.process_time()
    result = ac.characterise(x, 100.0)
    assert time.process_time() - start < 1.0  # 0.2 s on an idle core
    assert result["sigma"].shown


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda x: ac.autocorrelation(x, 1.0, max_lag=1e9), "max_lag"),
        (lambda x: ac.autocorrelation(x, 1.0, detrend="cubic"), "detrend"),
        (lambda x: ac.autocorrelation(np.ones(50), 1.0), "x"),
        (lambda x: ac.fit_gauss_markov(x[:20], 1.0), "x"),
        (lambda x: ac.fit_gauss_markov(np.ones(100), 1.0), "x"),
        (lambda x: ac.fit_gauss_markov(np.append(x, np.nan), 1.0), "x"),
    ],
)
def test_bad_arguments_are_named(call, word):
    with pytest.raises(ValueError, match=f"`{word}`"):
        call(np.random.default_rng(13).standard_normal(200))
