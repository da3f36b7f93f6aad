"""Wavelet de-noising: against PyWavelets, closed forms, and its own causal definition."""

import numpy as np
import pytest
import pywt
from hypothesis import given, settings
from hypothesis import strategies as st

from imu_lib import wavelet
from imu_lib.wavelet.shrinkage import hybrid_threshold, sure_threshold


@pytest.fixture(scope="module")
def series():
    rng = np.random.default_rng(1)
    return rng.standard_normal(6000) + 0.05 * np.cumsum(rng.standard_normal(6000))


def test_sure_threshold_minimises_the_written_out_risk():
    # Stein's estimate n - 2 #{|z| <= t} + sum min(|z|, t)^2, evaluated at every |z| without the
    # cumulative sums.
    z = np.random.default_rng(2).standard_normal((4, 57))
    for row, chosen in zip(z, sure_threshold(z)):
        risk = [
            row.size - 2 * np.sum(np.abs(row) <= t) + np.sum(np.minimum(np.abs(row), t) ** 2)
            for t in np.abs(row)
        ]
        assert chosen == np.abs(row)[np.argmin(risk)]


def test_sure_is_an_unbiased_estimate_of_the_risk():
    # Stein: at a fixed threshold the estimate's mean is the true squared error; 4000 draws, 4
    # standard errors.
    rng = np.random.default_rng(3)
    truth = np.repeat([0.0, 3.0], [90, 10])
    z = truth + rng.standard_normal((4000, 100))
    t = 1.2
    sure = 100 - 2 * np.sum(np.abs(z) <= t, axis=1) + np.sum(np.minimum(np.abs(z), t) ** 2, axis=1)
    loss = np.sum((pywt.threshold(z, t) - truth) ** 2, axis=1)
    difference = sure - loss
    assert abs(difference.mean()) < 4 * difference.std() / np.sqrt(4000)


def test_hybrid_takes_the_universal_threshold_on_pure_noise():
    z = np.random.default_rng(4).standard_normal((1, 4096))
    assert hybrid_threshold(z)[0] == pytest.approx(np.sqrt(2 * np.log(4096)))


def test_universal_threshold_equals_pywavelets_by_hand(series):
    coefficients = pywt.wavedec(series, "db4", mode="symmetric", level=4)
    total = sum(c.size for c in coefficients)
    for i in range(1, 5):
        sigma = np.median(np.abs(coefficients[i])) / 0.6744897501960817
        coefficients[i] = pywt.threshold(
            coefficients[i], sigma * np.sqrt(2 * np.log(total)), "soft"
        )
    expected = pywt.waverec(coefficients, "db4", mode="symmetric")[: series.size]
    np.testing.assert_allclose(
        wavelet.denoise(series, 4, threshold="universal"), expected, atol=1e-12
    )


@pytest.mark.parametrize("threshold", ["sure", "hybrid", "universal", "approximation"])
@pytest.mark.parametrize(
    ("level", "window", "name"),
    [(3, 256, "db4"), (4, 301, "db4"), (5, 700, "sym5"), (2, 40, "haar")],
)
def test_sliding_form_is_the_last_sample_of_the_window_denoised_alone(
    series, threshold, level, window, name
):
    fast = wavelet.denoise(
        series, level, wavelet=name, threshold=threshold, causal=True, window=window, refresh=1
    )
    for k in (window - 1, window, 1500, 5999):
        alone = wavelet.denoise(
            series[k - window + 1 : k + 1], level, wavelet=name, threshold=threshold
        )[-1]
        assert fast[k] == pytest.approx(alone, abs=1e-9)  # rounding of the FFT filters


@pytest.mark.parametrize("causal", ["sliding", "block"])
def test_causal_forms_do_not_see_the_future(series, causal):
    changed = series.copy()
    changed[4096:] += 100.0  # a block boundary of the block form
    before, after = (wavelet.denoise(s, 6, causal=causal)[:4096] for s in (series, changed))
    np.testing.assert_allclose(before, after, atol=1e-9)
    whole = wavelet.denoise(series, 6) - wavelet.denoise(changed, 6)
    assert np.max(np.abs(whole[:4096])) > 1  # the whole-record form does


def test_block_form_delivers_each_block_from_the_window_that_ends_with_it(series):
    out = wavelet.denoise(series, 4, causal="block", window=512, block=100)
    end = 512 + 7 * 100
    np.testing.assert_allclose(
        out[end - 100 : end], wavelet.denoise(series[end - 512 : end], 4)[-100:], atol=1e-12
    )
    np.testing.assert_allclose(
        out[-88:], wavelet.denoise(series[-512:], 4)[-88:], atol=1e-12
    )  # 5488 = 54 blocks + 88


def test_span_of_db4_level_7_at_100_hz():
    assert wavelet.span(100.0, 7) == pytest.approx(8.89)


def test_noise_left_by_the_low_pass_is_its_closed_form():
    # Mid-record: a projection that keeps 2^-J of the dimensions. Edge: the norm of the last row.
    # Standard error of a
    # variance from n correlated samples: about sqrt(2 * 2^J / n), here 0.9 % and, of the standard
    # deviation, half.
    x = np.random.default_rng(5).standard_normal(400_000)
    middle = wavelet.denoise(x, 4, threshold="approximation").std()
    edge = wavelet.denoise(x, 4, threshold="approximation", causal=True)[1000:].std()
    assert middle == pytest.approx(2**-2, rel=0.02)
    assert edge == pytest.approx(wavelet.edge_response(4).noise_gain, rel=0.02)
    assert edge > 1.5 * middle


def test_edge_response_lags_a_ramp_as_it_says():
    t = np.arange(3000.0)
    out = wavelet.denoise(t, 5, threshold="approximation", causal=True)
    np.testing.assert_allclose(t[1500:] - out[1500:], wavelet.edge_response(5).delay, atol=1e-6)


def test_band_gains_add_up_to_one_and_pass_white_noise_as_they_say():
    f = np.linspace(0, 50, 401)
    rows = wavelet.gain(f, 100.0, 5)
    np.testing.assert_allclose(rows.sum(axis=0), 1.0, atol=1e-9)
    share = rows[:, :-1].mean(axis=1)
    np.testing.assert_allclose(share, [2**-1, 2**-2, 2**-3, 2**-4, 2**-5, 2**-5], atol=2e-3)
    half_power = f[np.argmin(np.abs(wavelet.gain(f, 100.0, 1)[1] - 0.5))]
    assert half_power == pytest.approx(25.0, abs=0.2)  # D1 and A1 meet at fs / 4


def test_band_variance_adds_up_to_the_variance(series):
    x = series[:5888]  # a multiple of 2^8
    assert wavelet.band_variance(x, 8).sum() == pytest.approx(x.var())


def test_level_from_the_motion_band_is_the_papers():
    # Section 5.6 of the 2013 paper: 5 Hz at 100 Hz -> three levels; 0.78 Hz -> 6; 0.39 Hz -> 7
    # (Table 7).
    assert [wavelet.level_for_band(f, 100.0) for f in (5.0, 0.78, 0.39)] == [3, 6, 7]


def test_choice_of_level_stops_before_the_band_that_moves():
    rng = np.random.default_rng(6)
    n, fs = 60_000, 100.0
    static, noise = rng.standard_normal((2, n))
    # A sine in the middle of D6, D4, D2 with twice the band's noise; db4 leaves a tenth of it in
    # the band above.
    for f, level in ((1.1, 5), (4.4, 3), (17.6, 1)):
        amplitude = np.sqrt(4 * 2.0 ** -(level + 1))
        choice = wavelet.choose_level(
            noise + amplitude * np.sin(2 * np.pi * f * np.arange(n) / fs), static, fs
        )
        assert choice.level == level
        assert choice.p_value[level] < 1e-6
        assert choice.limit == fs / 2 ** (level + 1)
    assert wavelet.choose_level(noise, static, fs).level == 8


def test_first_level_noise_scale_fails_on_filtered_noise_as_the_docs_say():
    # A 15-tap average leaves little in D1, so a scale taken there is too small for the deeper
    # levels.
    x = np.convolve(
        np.random.default_rng(7).standard_normal(40_000), np.full(15, 1 / 15), mode="valid"
    )
    per_level = wavelet.denoise(x, 6).std()
    first = wavelet.denoise(x, 6, noise="first_level").std()
    assert first > 1.5 * per_level


def test_columns_are_denoised_one_by_one(series):
    two = np.column_stack([series, series[::-1]])
    np.testing.assert_array_equal(wavelet.denoise(two, 3)[:, 1], wavelet.denoise(two[:, 1], 3))


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 4), st.floats(-1e3, 1e3), st.integers(120, 400), st.booleans())
def test_a_constant_passes_every_form_unchanged(level, value, n, causal):
    x = np.full(n, value)
    np.testing.assert_allclose(
        wavelet.denoise(x, level, causal=causal), x, atol=1e-9 * max(1.0, abs(value))
    )


def test_summary_of_thresholds(series):
    summary = wavelet.thresholds(series, 5)
    assert summary.sigma.shape == (5,)
    assert np.all((summary.kept >= 0) & (summary.kept <= 1))
    np.testing.assert_array_equal(
        wavelet.thresholds(series, 5, threshold="approximation").energy_kept, 0.0
    )


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"level": 12}, "level"),
        ({"level": -1}, "level"),
        ({"level": 2.5}, "level"),
        ({"threshold": "magic"}, "threshold"),
        ({"noise": "x"}, "noise"),
        ({"mode": "x"}, "mode"),
        ({"causal": "x"}, "causal"),
        ({"causal": True, "window": 20, "level": 3}, "window"),
    ],
)
def test_bad_arguments_are_named(series, options, word):
    arguments = {"level": 3, **options}
    with pytest.raises(ValueError, match=f"`{word}`"):
        wavelet.denoise(series, arguments.pop("level"), **arguments)


def test_samples_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="not finite"):
        wavelet.denoise(np.array([1.0, np.nan] * 100), 2)
