"""What is left beyond chance and is too small to matter: said, and no doubt about the names."""

import numpy as np
import pytest
from scipy.stats import norm

from imu_lib import gap
from imu_lib.gap import normality, residual_tests
from imu_lib.gap.channel import analyse
from imu_lib.gap.check import Check
from imu_lib.gap.coherence import cross_spectra
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.shared_noise import shared_noise
from imu_lib.gap.table import table
from imu_lib.model import Model
from imu_lib.processes import Sum, WhiteNoise
from imu_lib.record import Record

FS, N = 100.0, 250_000


def gamma(rng, skewness, n=N):
    """Standard samples of that skewness."""
    k = 4.0 / skewness**2
    return (rng.gamma(k, size=n) - k) / np.sqrt(k)


def closed(x):
    base = Model(channels={"gyro_x": Sum((WhiteNoise(1.0 / np.sqrt(FS)),))}, rate=FS)
    return gap.close(Record({"gyro_x": x}, FS, name="test"), base, simulations=0, jobs=1)


@pytest.mark.parametrize("freedom", [20, 60])
def test_the_error_of_the_tail_is_that_of_the_quantile(freedom):
    rng = np.random.default_rng(freedom)
    u = rng.standard_t(freedom, 10**6)
    u /= np.std(u)
    true = np.quantile(u, norm.cdf(3.0)) / 3.0 - 1.0
    # Cornish and Fisher's first order lies above by a part in ten; counted to 0.3 %
    assert true - 0.005 < normality.tail_error(u) < 1.3 * true + 0.005


def test_a_small_skewness_is_said_and_is_no_doubt():
    found = closed(gamma(np.random.default_rng(1), 0.06))
    result = found.channels["gyro_x"].result
    assert result.unexplained is None and not result.steps
    (small,) = result.small
    assert "skewness +0.06" in small or "skewness +0.05" in small
    entry = found.to_json()["channels"]["gyro_x"]
    assert entry["unexplained"] is None and entry["small_departures"] == [small]
    assert small in " ".join(table(found).split())
    text = " ".join(sentences(found))
    assert "Nothing is left without a name; small departures" in text and "gyro_x move no" in text


def test_a_skewness_that_moves_the_limits_is_left_without_a_name():
    result = closed(gamma(np.random.default_rng(2), 0.3)).channels["gyro_x"].result
    assert "skewness +0." in result.unexplained and not result.small


@pytest.mark.parametrize("named, small", [((), True), (("spikes",), False), (("ramp",), True)])
def test_beside_an_effect_on_single_samples_every_departure_counts(named, small):
    tests = [Check("distribution", -9.0, "shape", 0.4), Check("psd", -1.0, "level")]
    worst, said = residual_tests.weighed(tests, named)
    assert (worst.where, said) == (("level", ["shape"]) if small else ("shape", []))


@pytest.mark.parametrize(("minutes", "period"), [(5, 60.0), (5, 30.0), (2, 21.0)])
def test_a_slow_wave_in_a_short_record_is_no_noise(minutes, period):
    """Some cycles in minutes, too few for a line of the spectrum."""
    fs = 50.0
    t = np.arange(round(minutes * 60 * fs)) / fs
    x = 1.2e-3 * np.sqrt(fs) * np.random.default_rng(5).standard_normal(t.size)
    found = analyse("accel_x", x + 0.01 * np.sin(2 * np.pi * t / period + 0.4), fs, None)
    (step,) = found.steps
    assert step.effect == "sinusoid" and step.confidence > 0.9
    assert abs(step.parameters["frequency"] * period - 1) < 0.02


def test_a_skewness_says_whether_few_samples_make_it_or_all_of_them():
    rng = np.random.default_rng(8)
    leaning = normality.distribution(gamma(rng, 0.2, 60_000))[0].where
    x = rng.standard_normal(60_000)
    x[::600] += 5.0
    single = normality.distribution(x)[0].where
    assert "all of the distribution leans" in leaning and "single deviations" in single
    counts = f"{np.count_nonzero(x - x.mean() > 4 * x.std())} samples beyond +4"
    assert counts in single


@pytest.mark.parametrize(("share", "found"), [(0.008, False), (0.06, True)])
def test_noise_in_common_is_told_from_two_per_cent_of_the_power_on(share, found):
    rng = np.random.default_rng(9)
    common = rng.standard_normal(N)
    x = {
        c: np.sqrt(1 - share) * rng.standard_normal(N) + np.sqrt(share) * common
        for c in ("gyro_x", "gyro_y", "gyro_z")
    }
    process, note, left = shared_noise(cross_spectra(x, FS), FS)
    assert left is None and (process is not None) is found
    assert not found or note["share"] == pytest.approx(share, rel=0.3)


def test_noise_in_common_counts_by_its_share_of_the_quietest_channel():
    """8 % of one channel and next to nothing of two louder ones: left out, the first has a change
    of its own density."""
    rng = np.random.default_rng(10)
    common, own = 0.28 * rng.standard_normal(N), {"gyro_x": 0.96, "gyro_y": 3.0, "gyro_z": 4.0}
    x = {c: sd * rng.standard_normal(N) + common for c, sd in own.items()}
    process, _, left = shared_noise(cross_spectra(x, FS), FS)
    assert left is None and "gyro_x" in process.channels
    assert process.N == pytest.approx(0.28 / np.sqrt(FS), rel=0.25)
