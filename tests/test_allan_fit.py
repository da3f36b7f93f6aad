"""Reading off and joint fit of Allan curves: covariance, coverage in small, limits, templates."""

import numpy as np
import pytest

from imu_lib import allan, slopes
from imu_lib.allan.covariance import Quadrature
from imu_lib.processes import (
    Flicker,
    GaussMarkov,
    LowPass,
    Quantization,
    Ramp,
    RandomWalk,
    WhiteNoise,
)

FS = 10.0


@pytest.mark.parametrize(
    "model",
    [
        WhiteNoise(N=1.0),
        WhiteNoise(N=1.0) + RandomWalk(K=0.02),
        WhiteNoise(N=1.0) + GaussMarkov(sigma=0.5, correlation_time=40.0),
    ],
)
def test_covariance_of_the_curve(model):
    """From the model's spectrum, against the scatter of 800 draws."""
    n, rng = 4000, np.random.default_rng(1)
    m = np.array([1, 2, 4, 16, 64, 128, 256, 512, 1024])
    draws = np.array([squares(model.simulate(n, 1.0, rng), m) for _ in range(800)])
    quad = Quadrature(m, n, n - 2 * m + 1, 1.0)
    mine, seen = quad.covariance(model.psd(quad.f, 1.0)), np.cov(draws.T)
    sd = np.sqrt(np.diag(mine))
    # a standard deviation from 800 nearly chi-square draws is known to 3-5 %, a correlation to
    # 0.035
    assert np.abs(np.sqrt(np.diag(seen)) / sd - 1).max() < 0.15
    assert np.abs(mine / np.outer(sd, sd) - np.corrcoef(draws.T)).max() < 0.15


def squares(x, m):
    from imu_lib.allan.clusters import squared_differences

    return squared_differences(x, m, threads=1)[0] / 2


def test_fit_covers_in_small():
    """Half an hour at 10 Hz, 30 draws; the full study is benchmarks/interval_coverage.py."""
    truth = WhiteNoise(N=1.0) + GaussMarkov(sigma=0.5, correlation_time=20.0)
    rng, hits = np.random.default_rng(2), []
    for _ in range(30):
        found = allan.fit(
            allan.deviation(truth.simulate(18_000, FS, rng), FS), WhiteNoise() + GaussMarkov()
        )
        hits.append(
            [
                found[label].covers(value)
                for label, value in (("N", 1.0), ("sigma", 0.5), ("correlation_time", 20.0))
            ]
        )
    # 90 intervals at 95 %: five standard errors of the share are 11 %
    assert np.mean(hits) > 0.84, np.mean(hits, axis=0)


def test_absent_walk_gets_a_limit():
    rng = np.random.default_rng(3)
    limits = []
    for _ in range(10):
        found = allan.fit(
            allan.deviation(WhiteNoise(N=1.0).simulate(18_000, FS, rng), FS),
            WhiteNoise() + RandomWalk(),
        )
        if not found["K"].shown:
            assert found["K"].low == 0 and found.model.find("random_walk").K == 0
            limits.append(found["K"].high)
    assert len(limits) >= 6  # each absent term is shown by chance in 5 % of the draws
    # a walk as large as the limit would show: its variance at the longest averaging times is that
    # of the white noise
    assert 1e-4 < np.median(limits) < 1e-2


def test_limit_holds_a_faint_walk():
    rng, held = np.random.default_rng(4), 0
    model = WhiteNoise(N=1.0) + RandomWalk(K=4e-4)
    for _ in range(20):
        estimate = allan.fit(
            allan.deviation(model.simulate(18_000, FS, rng), FS), WhiteNoise() + RandomWalk()
        )["K"]
        held += estimate.low <= 4e-4 <= estimate.high
    assert held >= 16  # 20 draws at 95 %


def test_unknown_filter_does_not_bias_the_white_noise():
    model = (
        WhiteNoise(N=1.0) + GaussMarkov(sigma=0.5, correlation_time=20.0) + LowPass(taps=5, rate=FS)
    )
    curve = allan.deviation(model.simulate(200_000, FS, np.random.default_rng(5)), FS)
    start = allan.short_filter(curve)
    assert start is not None and 0.2 <= start <= 1.6
    found = allan.fit(curve, WhiteNoise() + GaussMarkov(), shortest=start, filtered=True)
    assert found["N"].covers(1.0) and abs(found["N"].value - 1.0) < 0.03
    told = allan.fit(curve, WhiteNoise() + GaussMarkov() + LowPass(taps=5, rate=FS))
    assert told["N"].covers(1.0) and told.p_value > 1e-3


def test_held_parameters_are_held():
    curve = allan.deviation(WhiteNoise(N=1.0).simulate(20_000, FS, np.random.default_rng(6)), FS)
    found = allan.fit(curve, WhiteNoise() + Flicker(B=0.01))
    assert found.model.find("flicker").B == 0.01 and set(found.parameters) == {"N"}
    for bad in (WhiteNoise(N=1.0), WhiteNoise() + Ramp(R=0.0) + LowPass(taps=5, rate=FS)):
        if bad == WhiteNoise(N=1.0):
            with pytest.raises(ValueError, match="nothing to fit"):
                allan.fit(curve, bad)
    with pytest.raises(ValueError, match="too few"):
        allan.fit(curve, WhiteNoise() + GaussMarkov(), longest=0.1)


def test_characterise_finds_the_five():
    rng = np.random.default_rng(7)
    model = Quantization(Q=0.1) + WhiteNoise(N=0.1) + Flicker(B=0.05) + RandomWalk(K=2e-3)
    found = allan.characterise(model.simulate(360_000, FS, rng), FS)
    assert set(found) == {"N", "B", "K", "Q", "R"} and not found["R"].shown
    for symbol, value in (("Q", 0.1), ("N", 0.1), ("B", 0.05), ("K", 2e-3)):
        # four intervals at 95 %; held to twice their half-width, which one draw in 10 000 would
        # leave
        middle, half = np.log(found[symbol].value), np.log(found[symbol].high / found[symbol].value)
        assert abs(np.log(value) - middle) < 2 * half, symbol


def test_a_record_that_no_sum_describes():
    """A quarter of the record at twice the noise: the model is granted an error, and the five
    still come out sane.
    """
    rng = np.random.default_rng(9)
    x = (
        WhiteNoise(N=1.0).simulate(200_000, FS, rng)
        + np.round(4 * GaussMarkov(sigma=1.0, correlation_time=3.0).simulate(200_000, FS, rng)) / 4
    )
    x[:50_000] *= 2
    found = allan.characterise(x, FS)
    for symbol, estimate in found.items():
        assert estimate.high < np.inf and (
            not estimate.shown or 0 < estimate.low < estimate.value < estimate.high
        ), symbol


def test_reading_off_white_and_walk():
    model = WhiteNoise(N=1.0) + RandomWalk(K=0.01)
    reading = allan.read_off(
        allan.deviation(model.simulate(360_000, FS, np.random.default_rng(8)), FS)
    )
    assert reading["N"].value == pytest.approx(1.0, rel=0.05) and reading[
        "K"
    ].value == pytest.approx(0.01, rel=0.25)
    assert not reading["Q"].shown and not reading["R"].shown
    assert [s.slope for s in slopes.rising(reading.segments)] == sorted(
        s.slope for s in slopes.rising(reading.segments)
    )


def test_reading_a_gauss_markov_process_off_the_flat_part():
    """Pitfall: sigma = 0.664 B and Tc from the flat part make the driving density about five times
    too small.
    """
    sigma, time = 1.0, 30.0
    tau = np.geomspace(1, 3000, 400)
    adev = np.sqrt(GaussMarkov(sigma=sigma, correlation_time=time).avar(tau))
    top = np.argmax(adev)
    assert adev[top] == pytest.approx(allan.PEAK, abs=2e-4) and tau[top] / time == pytest.approx(
        allan.PEAK_TIME, rel=0.02
    )
    ratio = (sigma**2 / time) / (allan.PEAK**2 / (allan.PEAK_TIME * time))
    assert 4.5 < ratio < 5.5


@pytest.mark.parametrize("slope", [-1.0, -0.5, 0.0, 0.5, 1.0])
def test_segments_of_a_pure_slope(slope):
    x = np.geomspace(0.01, 1000, 80)
    found = slopes.segments(x, 3.0 * x**slope, np.full(80, 0.01), [-1.0, -0.5, 0.0, 0.5, 1.0])
    assert len(found) == 1 and found[0].slope == slope and found[0].decades == pytest.approx(5.0)
    assert found[0].at(1.0) == pytest.approx(3.0)


def test_flat_place_is_the_top_and_stays_with_it():
    """A bump with a walk behind it: the top is meant, not the trough, whatever the grid; beside
    the trough, the trough.
    """
    markov = GaussMarkov(sigma=1.0, correlation_time=10.0)
    assert allan.flat_time(markov + WhiteNoise(N=1e-6), 0.1, 1e4) == pytest.approx(
        1.8926 * 10.0, rel=1e-3
    )
    model = WhiteNoise(N=0.3) + markov + RandomWalk(K=0.05)
    for longest in (1e3, 1.1e3, 2e3, 1e4):
        top = allan.flat_time(model, 0.1, longest)
        assert 15 < top < 30
        around = model.avar(top * np.array([0.97, 1.0, 1.03]))
        assert around[1] > around[0] and around[1] > around[2]
    trough = allan.flat_time(
        model, 0.1, 1e4, beside=150.0
    )  # where 2 sigma^2 Tc / tau and K^2 tau / 3 cross, 155 s
    around = model.avar(trough * np.array([0.97, 1.0, 1.03]))
    assert around[1] < around[0] and around[1] < around[2]


def test_flat_gradient():
    """Against differences of the whole: a bump's level goes with sigma, and with what else reaches
    under it.
    """

    def model_of(log):
        return WhiteNoise(N=np.exp(log[0])) + GaussMarkov(
            sigma=np.exp(log[1]), correlation_time=np.exp(log[2])
        )

    log = np.log([1.8, 1.0, 100.0])
    place = allan.flat_time(model_of(log), 0.1, 1e4)
    found = allan.flat_gradient(model_of, log, place)
    # both amplitudes together scale the level; in time the level depends on N^2 / Tc alone
    assert found[:2].sum() == pytest.approx(1.0, abs=1e-4) and found[2] == pytest.approx(
        -found[0] / 2, abs=1e-3
    )


def test_flat_interval_grows_with_the_level():
    model = WhiteNoise(N=1.8) + GaussMarkov(sigma=1.0, correlation_time=100.0)
    x = model.simulate(20_000, 1.0, np.random.default_rng(1))
    flat = allan.fit(allan.deviation(x, 1.0), WhiteNoise() + GaussMarkov()).flat
    # a standard error fixed at the fit would make the two equal
    assert np.log(flat.high / flat.value) > 1.1 * np.log(flat.value / flat.low) > 0
