"""Autoregressive models: against statsmodels, closed forms, and known truth."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from statsmodels.regression.linear_model import burg as statsmodels_burg
from statsmodels.regression.linear_model import yule_walker as statsmodels_yule_walker
from statsmodels.stats.diagnostic import acorr_ljungbox
from statsmodels.tsa.api import VAR, AutoReg

from imu_lib import autoregressive as ar
from imu_lib.autoregressive.stepwise import _triangle_by_qr, _triangle_from_products
from imu_lib.processes import Autoregressive, GaussMarkov

TRUTH = Autoregressive(phi=(1.2, -0.5, 0.1), sigma=2.0, rate=10.0)


@pytest.fixture(scope="module")
def x():
    return TRUTH.simulate(20_000, 10.0, np.random.default_rng(1)) + 5.0


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 8), st.integers(60, 500))
def test_burg_equals_statsmodels(seed, order, n):
    x = np.cumsum(np.random.default_rng(seed).standard_normal(n)) + 3
    phi, variance = statsmodels_burg(x, order=order)
    ours = ar.fit(x, order)
    np.testing.assert_allclose(ours.phi, phi, atol=1e-9)
    assert ours.sigma**2 == pytest.approx(variance, rel=1e-9)
    assert ours.stable


def test_one_pass_of_burg_holds_all_lower_orders(x):
    for order, model in enumerate(ar.burg(x, 6)[1:], start=1):
        np.testing.assert_allclose(model.phi, statsmodels_burg(x, order=order)[0], atol=1e-9)


def test_yule_walker_equals_statsmodels(x):
    phi, sigma = statsmodels_yule_walker(x, order=4, method="mle", result_object=False)[:2]
    ours = ar.fit(x, 4, method="yule_walker")
    np.testing.assert_allclose(ours.phi, phi, atol=1e-9)
    assert ours.sigma == pytest.approx(sigma, rel=1e-9)


def test_least_squares_equals_statsmodels(x):
    theirs = AutoReg(x, lags=3).fit()
    ours = ar.fit(x, 3, method="least_squares")
    np.testing.assert_allclose(ours.phi, theirs.params[1:], atol=1e-8)
    assert ours.mean == pytest.approx(theirs.params[0] / (1 - theirs.params[1:].sum()), rel=1e-6)


def test_stepwise_gives_every_order_on_the_same_samples(x):
    steps = ar.stepwise(x[:3000], 6)
    for order in range(7):
        theirs = AutoReg(x[:3000], lags=order, hold_back=6).fit()
        residual = np.sum(theirs.resid**2)
        assert steps.cross_products()[order, 0, 0] == pytest.approx(residual, rel=1e-9)
        np.testing.assert_allclose(steps.fit(order).phi, theirs.params[1:], atol=1e-8)


@pytest.fixture(scope="module")
def triad():
    rng = np.random.default_rng(2)
    A = np.array(
        [
            [[0.5, 0.1, 0.0], [0.0, 0.4, 0.2], [0.1, 0.0, 0.3]],
            [[0.2, 0, 0], [0, -0.1, 0], [0, 0.1, 0.1]],
        ]
    )
    C = np.array([[1.0, 0.3, 0.0], [0.3, 2.0, 0.5], [0.0, 0.5, 1.5]])
    e = rng.multivariate_normal(np.zeros(3), C, size=6000)
    v = np.zeros((6000, 3))
    for k in range(2, 6000):
        v[k] = [1.0, -2.0, 0.5] + A[0] @ v[k - 1] + A[1] @ v[k - 2] + e[k]
    return v[500:], A, C


def test_three_axes_together_equal_statsmodels_var(triad):
    v, A, C = triad
    theirs = VAR(v).fit(2, trend="c")
    ours = ar.stepwise(v, 2).vector_fit(2)
    np.testing.assert_allclose(ours.A, theirs.coefs, atol=1e-8)
    np.testing.assert_allclose(ours.intercept, theirs.intercept, atol=1e-7)
    np.testing.assert_allclose(ours.C, theirs.sigma_u, rtol=1e-8)
    np.testing.assert_allclose(
        ours.A_sd.transpose(0, 2, 1).reshape(6, 3), theirs.stderr_endog_lagged, rtol=1e-6
    )
    np.testing.assert_allclose(ours.residuals(v), theirs.resid, atol=1e-7)
    # ... and the truth within 4 standard errors of 18 coefficients.
    assert np.max(np.abs(ours.A - A) / ours.A_sd) < 4
    assert ours.stable
    assert ar.choose_order(v, 8).orders["sbc"] == 2


def test_several_axes_in_other_units_give_the_same_model(triad):
    v, _, _ = triad
    unit = np.array([1.0, 1e-5, 9.8])
    plain, scaled = (ar.stepwise(u, 2).vector_fit(2) for u in (v, v * unit))
    np.testing.assert_allclose(scaled.A, plain.A * unit[:, None] / unit, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(scaled.C, plain.C * np.outer(unit, unit), rtol=1e-8)


def test_moment_matrix_and_qr_agree_and_smooth_series_go_to_the_qr(triad):
    v = (triad[0] - triad[0].mean(axis=0)) / triad[0].std(axis=0)
    quick, exact = _triangle_from_products(v, 5), _triangle_by_qr(v, 5)
    np.testing.assert_allclose(np.abs(quick), np.abs(exact), atol=1e-8)
    smooth = np.convolve(np.cumsum(v[:, 0]), np.hanning(60), mode="valid")
    assert _triangle_from_products((smooth - smooth.mean())[:, None] / smooth.std(), 12) is None
    assert np.isfinite(ar.fit(smooth, 12, method="least_squares").sigma)


def test_intervals_of_the_coefficients_cover():
    # 300 realisations of an AR(2): 95 % of each coefficient; 91.5 % is 2.8 binomial standard
    # deviations below.
    truth = Autoregressive(phi=(0.7, -0.3), sigma=1.0, rate=1.0)
    hits = []
    for i in range(300):
        phi, sigma = ar.fit(truth.simulate(1000, 1.0, np.random.default_rng([3, i])), 2).estimates()
        hits.append(
            [p.covers(t) for p, t in zip(phi, truth.phi, strict=True)] + [sigma.covers(1.0)]
        )
    assert np.all(np.mean(hits, axis=0) > 0.915)


def test_criteria_find_the_order_and_stand_in_their_known_relations(x):
    choice = ar.choose_order(x, 12)
    assert choice.orders["sbc"] == choice.orders["mdl"] == 3
    assert choice.orders["aic"] >= 3 and choice.orders["fpe"] == choice.orders["aic"]
    np.testing.assert_allclose(np.diff(choice.mdl), np.diff(choice.sbc) * choice.n / 2, atol=1e-6)
    # FPE is AIC's first order: n ln FPE = AIC up to a constant, within n_p^2 / n.
    np.testing.assert_allclose(
        np.diff(choice.n * np.log(choice.fpe)), np.diff(choice.aic), atol=0.03
    )


def test_eq_4_is_bic_per_sample_with_delta_a_sum(x):
    choice = ar.choose_order(x, 5)
    for order in range(6):
        theirs = AutoReg(x, lags=order, hold_back=5).fit()
        n = theirs.resid.size
        bic = n * np.log(np.mean(theirs.resid**2)) + (order + 1) * np.log(n)
        assert choice.sbc[order] * n == pytest.approx(bic, rel=1e-9)


def test_sbc_finds_the_order_more_often_the_longer_the_record():
    truth = Autoregressive(phi=(0.4, 0.1), sigma=1.0, rate=1.0)
    found = []
    for n in (100, 600, 6000):
        orders = [
            ar.choose_order(truth.simulate(n, 1.0, np.random.default_rng([4, i])), 8).orders["sbc"]
            for i in range(40)
        ]
        found.append(np.mean(np.array(orders) == 2))
    assert found[0] < found[1] < found[2] and found[2] > 0.9


def test_knee_is_where_nothing_beyond_is_worth_the_tolerance():
    assert ar.knee([10.0, 6.0, 5.0, 4.51, 4.5, 4.499], tolerance=0.01) == 3
    assert ar.knee([10.0, 6.0, 5.0, 4.51, 4.5, 4.499], tolerance=0.2) == 2
    assert ar.knee([1.0, 1.0, 1.0]) == 0


def test_whiteness_equals_statsmodels_and_its_p_values_are_uniform(triad):
    rng = np.random.default_rng(5)
    e = rng.standard_normal(500)
    ours = ar.whiteness(e, fitted=2, lags=20)
    assert ours.ljung_box == pytest.approx(
        acorr_ljungbox(e - e.mean(), lags=[20], model_df=2).lb_pvalue.iloc[0]
    )
    model = VAR(triad[0]).fit(2)
    theirs = model.test_whiteness(nlags=15, adjusted=True)
    assert ar.whiteness(model.resid, fitted=2, lags=15).ljung_box == pytest.approx(
        theirs.pvalue, rel=1e-6
    )
    p = np.array(
        [
            (w.ljung_box, w.li_mcleod)
            for w in (ar.whiteness(rng.standard_normal(400), lags=20) for _ in range(500))
        ]
    )
    np.testing.assert_allclose(
        np.mean(p < 0.1, axis=0), 0.1, atol=0.04
    )  # three binomial standard deviations
    assert not ar.whiteness(np.convolve(e, [1, 0.5])).white


def test_autocovariance_solves_yule_walker():
    np.testing.assert_allclose(
        ar.autocovariance(TRUTH.phi, 2.0, 30), TRUTH.autocovariance(np.arange(31) / 10), rtol=1e-9
    )
    phi, sigma = ar.best_predictor(ar.autocovariance(TRUTH.phi, 2.0, 5), 5)
    np.testing.assert_allclose(phi, [*TRUTH.phi, 0, 0], atol=1e-10)
    assert sigma == pytest.approx(2.0)
    with pytest.raises(ValueError, match="not stationary"):
        ar.autocovariance([1.1], 1.0, 3)


def test_ar1_and_gauss_markov_are_one():
    process = GaussMarkov(sigma=3.0, correlation_time=20.0)
    model = ar.from_gauss_markov(process, 5.0)
    assert model.phi[0] == pytest.approx(np.exp(-1 / 100))
    lags = np.arange(0, 200)
    np.testing.assert_allclose(
        ar.autocovariance(model.phi, model.sigma, 199), process.autocovariance(lags / 5), rtol=1e-9
    )
    x = process.simulate(100_000, 5.0, np.random.default_rng(6))  # 1000 correlation times
    back = ar.to_gauss_markov(ar.fit(x, 1), 5.0)
    assert back["sigma"].covers(3.0) and back["correlation_time"].covers(20.0)
    assert back["correlation_time"].value == pytest.approx(
        20.0, rel=0.13
    )  # 4.5 % standard deviation, three of them
    with pytest.raises(ValueError, match="`model`"):
        ar.to_gauss_markov(ar.fit(x, 2), 5.0)


def test_sign_of_the_papers():
    model = ar.fit(TRUTH.simulate(5000, 10.0, np.random.default_rng(7)), 3)
    np.testing.assert_array_equal(model.alpha, -model.phi)
    # Table 2 of the 2013 paper, Acc X, third order, as printed: explodes with a real root at
    # 1.044.
    printed = -np.array([-2.582, 2.166, -0.585])
    assert np.max(np.abs(ar.poles(printed))) == pytest.approx(1.044, abs=1e-3)
    for others in (
        [-2.564, 2.136, -0.572],
        [-2.564, 2.131, -0.567],
        [-2.565, 2.133, -0.568],
        [-2.562, 2.128, -0.566],
    ):
        assert (
            np.max(np.abs(ar.poles(-np.array(others)))) < 1.01
        )  # rounding alone decides on which side of 1


def test_white_noise_through_the_wavelet_gives_the_papers_coefficients():
    # Pitfall: db4, six levels, approximation only, then Burg, on pure white noise. Table 2 has
    # about -2.56, 2.13, -0.57.
    from imu_lib import wavelet

    x = wavelet.denoise(
        np.random.default_rng(8).standard_normal(400_000), 6, threshold="approximation"
    )
    np.testing.assert_allclose(
        ar.fit(x, 3).alpha, [-2.524, 2.057, -0.533], atol=0.01
    )  # scatter over seeds 0.003


def test_residuals_are_the_prediction_errors(x):
    model = ar.fit(x, 3)
    e = model.residuals(x)
    by_hand = [
        x[k] - model.mean - model.phi @ (x[k - 3 : k][::-1] - model.mean) for k in range(3, 50)
    ]
    np.testing.assert_allclose(e[:47], by_hand, atol=1e-9)
    assert e.size == x.size - 3 and e.std() == pytest.approx(model.sigma, rel=1e-3)


def test_characterise_recovers_the_truth_and_is_quick(x):
    result = ar.characterise(x, 10.0)
    assert result["order"] == 3 and result["white"] is True
    assert all(p.covers(t) for p, t in zip(result["phi"], TRUTH.phi, strict=True))
    assert result["sigma"].covers(2.0)
    assert ar.fit(x, 3).process(10.0).rate == 10.0
    long = np.random.default_rng(9).standard_normal(2_520_000)
    start = time.process_time()
    assert ar.characterise(long, 100.0)["order"] == 0
    assert time.process_time() - start < 1.5  # 0.3 s on an idle core


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda x: ar.fit(x, 2, method="magic"), "method"),
        (lambda x: ar.fit(x, -1), "order"),
        (lambda x: ar.fit(x[:5], 3), "x"),
        (lambda x: ar.fit(np.append(x, np.inf), 1), "x"),
        (lambda x: ar.fit(np.ones(50), 1), "x"),
        (lambda x: ar.stepwise(x[:10], 8), "v"),
        (lambda x: ar.whiteness(x[:100], fitted=5, lags=4), "lags"),
    ],
)
def test_bad_arguments_are_named(x, call, word):
    with pytest.raises(ValueError, match=f"`{word}`"):
        call(x)


def test_a_vector_model_of_order_zero_is_its_mean_and_scatter():
    v = np.random.default_rng(20261122).normal(
        loc=[1.0, -2.0, 0.5], scale=[1.0, 2.0, 0.1], size=(5000, 3)
    )
    model = ar.stepwise(v, 3).vector_fit(0)
    assert model.order == 0 and model.poles.size == 0 and model.stable
    assert np.allclose(model.intercept, v[3:].mean(axis=0)) and np.allclose(
        model.C, np.cov(v[3:].T)
    )
    assert np.allclose(model.residuals(v), v - model.intercept)
