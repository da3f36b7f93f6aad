"""One pass over a long channel: equal to what is computed at once, and merged from halves."""

import numpy as np
import pytest
from scipy.fft import dct

from imu_lib import allan, autocorrelation, autoregressive, likelihood, passes, spectrum
from imu_lib.characterise.channel import statistics
from imu_lib.processes import GaussMarkov, RandomWalk, Sinusoid, WhiteNoise
from imu_lib.spectrum import one_pass

FS, N = 200.0, (1 << 19) + 12_345


@pytest.fixture(scope="module")
def x():
    model = WhiteNoise(1e-3) + GaussMarkov(2e-3, 15.0) + RandomWalk(1e-5)
    # a constant ten thousand times the noise, as gravity is
    return model.simulate(N, FS, np.random.default_rng(0)) + 9.8


@pytest.fixture(scope="module")
def whole(x):
    return passes.over_array(x, FS)


def test_moments(x, whole):
    assert whole.mean == pytest.approx(x.mean(), rel=1e-14)
    assert whole.variance == pytest.approx(x.var(), rel=1e-12)


def test_allan_is_the_overlapped_one(x, whole):
    curve = whole.allan()
    full = allan.deviation(x, FS, taus=curve.tau)
    assert curve.m.size > 60 and curve.m[-1] == pytest.approx(N / 3, rel=0.02)
    ratio = curve.adev / full.adev
    np.testing.assert_allclose(ratio[curve.m < 128], 1, rtol=1e-12)  # every start, as there
    # a stride of a 64th of the cluster: windows that differ by less than their own scatter
    assert np.all(np.abs(ratio - 1) < 0.05 / np.sqrt(2 * curve.edf) + 1e-12)
    np.testing.assert_allclose(curve.edf, full.edf, rtol=0.02)


def test_autocorrelation_and_autoregression_are_those_of_the_whole(x, whole):
    for symbol, estimate in autocorrelation.characterise(x, FS).items():
        assert whole.autocorrelation()[symbol].value == pytest.approx(estimate.value, rel=1e-9)
    found, other = autoregressive.characterise(x, FS), whole.autoregressive()
    assert (found["order"], found["white"]) == (other["order"], other["white"])
    for a, b in zip(found["phi"], other["phi"], strict=True):
        assert (b.value, b.high) == pytest.approx((a.value, a.high), rel=1e-9)
    assert other["sigma"].value == pytest.approx(found["sigma"].value, rel=1e-12)


def test_likelihood_loses_nothing(x, whole):
    """The same fit within a tenth of its intervals, and intervals of the same width."""
    template = WhiteNoise() + GaussMarkov() + RandomWalk()
    once = likelihood.fit(x, FS, template)
    here = likelihood.fit(statistics([whole], FS), None, template)
    for name in ("N", "sigma", "correlation_time"):
        a, b = once[name], here[name]
        assert abs(b.value - a.value) < 0.1 * (a.high - a.low), name
        assert b.high - b.low == pytest.approx(a.high - a.low, rel=0.1), name
    assert here.p_value > 1e-3


def test_slow_coefficients_are_those_of_the_whole_transform(x, whole):
    (n, slow), _ = whole.scales()
    full = dct(x[:n] - x.mean(), norm="ortho")[1 : slow.size + 1]
    # what the filter's stop band lets through: 1e-6 of an ordinate of the fast noise
    assert np.abs(slow - full).max() < 1e-5 * np.abs(full[-1000:]).max()


def test_spectrum_is_welchs_at_both_ends(x, whole):
    once = spectrum.characterise(x, FS)
    here = one_pass.characterise(whole.spectrum())
    assert here["N"].value == pytest.approx(once["N"].value, rel=0.01)
    np.testing.assert_allclose(
        whole.spectrum().psd[:10], spectrum.average(spectrum.welch(x, FS)).psd[:10], rtol=1e-4
    )


@pytest.mark.parametrize("cut", [N // 2, 200_003])
def test_two_halves_are_the_whole(x, whole, cut):
    first = passes.Pass(N, FS, centre=whole.centre)
    second = passes.Pass(N, FS, centre=whole.centre, begin=cut)
    for low in range(0, N, 77_777):  # other pieces than the whole was fed with
        part = x[low : low + 77_777]
        first.feed(part[: max(cut - low, 0)])
        second.feed(part[max(cut - low, 0) :])
    first.merge(second)
    first.finish()
    np.testing.assert_allclose(first.allan().adev, whole.allan().adev, rtol=1e-12)
    np.testing.assert_allclose(first.spectrum().psd, whole.spectrum().psd, rtol=1e-10)
    a, b = statistics([first], FS), statistics([whole], FS)
    np.testing.assert_allclose(a.power, b.power, rtol=1e-10)
    assert first.variance == pytest.approx(whole.variance, rel=1e-12)
    for one, other in zip(
        first.autoregressive()["phi"], whole.autoregressive()["phi"], strict=True
    ):
        assert one.value == pytest.approx(other.value, rel=1e-9)
    for symbol, estimate in whole.autocorrelation().items():
        assert first.autocorrelation()[symbol].value == pytest.approx(estimate.value, rel=1e-9)


def test_a_line_is_found_and_left_out(x):
    line = Sinusoid(1e-3, 37.0).simulate(N, FS, np.random.default_rng(1))
    found = statistics([passes.over_array(x + line, FS, curves=False)], FS, exclude_lines=True)
    frequency, rms = found.lines[0]
    # a bin of the segments is 0.05 Hz wide; their mirrored edges spread the line
    assert frequency == pytest.approx(37.0, abs=0.1)
    assert rms == pytest.approx(1e-3 / np.sqrt(2), rel=0.1)


def test_a_pass_that_is_not_whole_is_refused(x):
    half = passes.Pass(N, FS)
    half.feed(x[:100_000])
    with pytest.raises(ValueError, match="has seen"):
        half.finish()
    with pytest.raises(ValueError, match="another stretch"):
        half.merge(passes.Pass(N + 1, FS, begin=100_000))
