"""Spectral density: scipy's Welch, gaps, degrees of freedom, coverage of the averaged density,
lines.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from imu_lib import spectrum
from imu_lib.processes import Flicker, LowPass, Quantization, RandomWalk, WhiteNoise


@settings(max_examples=20, deadline=None)
@given(
    st.integers(64, 500), st.sampled_from(["hann", "boxcar", "hamming"]), st.integers(0, 2**32 - 1)
)
def test_equals_scipy(n, window, seed):
    x = np.random.default_rng(seed).standard_normal(n)
    mine = spectrum.welch(x, 7.0, segment=48, window=window)
    f, psd = signal.welch(x, 7.0, nperseg=48, window=window)
    assert np.array_equal(mine.f, f[1:]) and np.allclose(mine.psd, psd[1:], rtol=1e-13, atol=0)


def test_stretches_between_gaps():
    """Missing samples cut the record: the estimate is the mean over the segments of its whole
    stretches.
    """
    x = np.random.default_rng(1).standard_normal(5000)
    x[2000:2100] = np.nan
    x[2500] = np.inf
    mine = spectrum.welch(x, 1.0, segment=512)
    parts = [(2000 - 256) // 256, 0, (2499 - 256) // 256]
    first, last = (signal.welch(p, 1.0, nperseg=512)[1][1:] for p in (x[:2000], x[2501:]))
    assert mine.count == parts[0] + parts[2]
    assert np.allclose(mine.psd, (parts[0] * first + parts[2] * last) / mine.count, rtol=1e-12)


@pytest.mark.parametrize("window", ["hann"])
def test_degrees_of_freedom(window):
    """Scatter of 400 estimates of white noise, before and after averaging over frequencies."""
    rng = np.random.default_rng(2)
    raw = [
        spectrum.welch(rng.standard_normal(8 * 256), 1.0, segment=256, window=window)
        for _ in range(400)
    ]
    averaged = [spectrum.average(one) for one in raw]
    for found in (raw, averaged):
        psd = np.array([one.psd for one in found])
        seen = 2 * psd.mean(axis=0) ** 2 / psd.var(axis=0)
        middle = slice(3, -3)  # the ends hold less than two degrees of freedom each
        # a variance from 400 draws is known to 7 %, its median over tens of frequencies to 2 %;
        # neighbours in the
        # averaged bands are correlated a little beyond what is counted
        assert np.median(seen[middle] / found[0].dof[middle]) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize(
    "model",
    [
        WhiteNoise(N=0.5),
        WhiteNoise(N=0.5) + RandomWalk(K=0.01),
        Quantization(Q=0.5) + Flicker(B=0.1),
    ],
)
def test_averaged_density_covers_the_closed_form(model):
    rng, hits = np.random.default_rng(3), []
    for _ in range(60):
        one = spectrum.average(spectrum.welch(model.simulate(20_000, 10.0, rng), 10.0))
        truth = model.psd(one.f, 10.0)
        hits.append((one.low <= truth) & (truth <= one.high))
    share = np.mean(hits, axis=0)
    # 60 draws at 95 %: four standard errors of one band are 11 %; the lowest bands of a walk leak
    # a little
    assert np.mean(share) > 0.92 and share[4:].min() > 0.8


@pytest.mark.parametrize(
    ("symbol", "process"),
    [
        ("N", WhiteNoise(N=0.3)),
        ("K", RandomWalk(K=0.02)),
        ("B", Flicker(B=0.4)),
        ("Q", Quantization(Q=0.02)),
    ],
)
def test_line_of_a_single_noise(symbol, process):
    x = process.simulate(400_000, 20.0, np.random.default_rng(4))
    reading = spectrum.read_off(spectrum.average(spectrum.welch(x, 20.0)))
    assert reading[symbol].value == pytest.approx(getattr(process, symbol), rel=0.04)
    others = [s for s in "NBKQ" if s != symbol]
    assert not any(reading[s].shown for s in others)


def test_coefficients_of_exact_lines():
    f = np.array([0.01])
    for symbol, process in (
        ("N", WhiteNoise(N=2.0)),
        ("B", Flicker(B=2.0)),
        ("K", RandomWalk(K=2.0)),
        ("Q", Quantization(Q=2.0)),
    ):
        slope = spectrum.LINES[symbol]
        level = process.psd(f, 1000.0)[0] / f[0] ** slope
        assert spectrum.coefficient(symbol, level, 1000.0) == pytest.approx(2.0, rel=1e-6)


def test_filter_is_not_read_as_a_noise():
    model = WhiteNoise(N=1.0) + RandomWalk(K=0.3) + LowPass(taps=15, rate=1000.0)
    found = spectrum.characterise(model.simulate(400_000, 100.0, np.random.default_rng(5)), 100.0)
    # folding lifts the white noise by 5.4 %; the walk below it adds up to a few per cent to a line
    assert found["N"].value == pytest.approx(1.054, rel=0.03) and found["K"].value == pytest.approx(
        0.3, rel=0.2
    )
    assert not found["Q"].shown


def test_bad_arguments():
    for call, word in (
        (lambda: spectrum.welch(np.zeros(5), 1.0), "`x`"),
        (lambda: spectrum.welch(np.zeros((9, 9)), 1.0), "`x`"),
        (lambda: spectrum.welch(np.zeros(100), -1.0), "`fs`"),
        (lambda: spectrum.welch(np.zeros(100), 1.0, segment=200), "`segment`"),
        (lambda: spectrum.welch(np.full(100, np.nan), 1.0), "`segment`"),
    ):
        with pytest.raises(ValueError, match=word):
            call()
