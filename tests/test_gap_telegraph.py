"""Two levels against the Gaussian process of the same spectrum."""

import gap_generator as generator
import gap_noises as noises
import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from imu_lib.gap.chain import posterior
from imu_lib.gap.channel import analyse
from imu_lib.gap.two_levels import (
    _amplitude,
    _beyond_spectrum,
    _cosines,
    decoded,
)
from imu_lib.processes import Sum, Telegraph, from_json

FS, N = 100.0, 180_000


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_a_path_says_beyond_its_spectrum_is_exact_under_white_noise(seed):
    """Probability of a two-level series by the forward recursion and of the Gaussian one from its
    covariance, the mean integrated out.
    """
    rng = np.random.default_rng(seed)
    n, a, flip, var = 600, 1.3, 0.03, 0.8
    y = a * ((np.cumsum(rng.random(n) < flip) % 2) - 0.5) + np.sqrt(var) * rng.standard_normal(n)
    y -= y.mean()
    means = np.linspace(-0.5, 0.5, 201)
    at = np.array(
        [posterior(y - m, a, flip, var)[1] - 0.5 * np.sum((y - m) ** 2) / var for m in means]
    )
    levels = (
        logsumexp(at)
        + np.log(means[1] - means[0])
        + 0.5 * np.sum(y**2) / var
        - 0.5 * np.log(2 * np.pi * var / n)
    )
    basis = np.linalg.svd(np.eye(n) - 1 / n)[0][:, : n - 1]
    own = basis.T @ (0.25 * a * a * toeplitz((1 - 2 * flip) ** np.arange(n))) @ basis
    white = var * np.eye(n - 1)
    gaussian = multivariate_normal.logpdf(
        basis.T @ y, cov=own + white
    ) - multivariate_normal.logpdf(basis.T @ y, cov=white)
    middle = means[np.argmax(at)]
    s, ll, _ = posterior(y - middle, a, flip, var)
    got = _beyond_spectrum(y, y - middle, s - 0.5, a, flip, ll, var, 1.0)
    assert levels - gaussian > 5
    assert (
        abs(got - (levels - gaussian)) < 1.0
    )  # Whittle's likelihood of a short series is good to some tenths


def test_the_distance_of_the_levels_is_unbiased_beside_a_drift():
    rng = np.random.default_rng(2)
    n, a, var, k = 3000, 1.0, 1.0, 0.02
    values, sds = [], []
    ratio = k**2 / (
        k**2 + var * 4 * np.sin(np.pi * np.arange(n) / (2 * n)) ** 2
    )  # share of a walk in walk and noise
    for _ in range(60):
        w = np.cumsum(rng.random(n) < 0.01) % 2 - 0.5
        y = a * w + np.cumsum(k * rng.standard_normal(n)) + np.sqrt(var) * rng.standard_normal(n)
        value, sd = _amplitude(_cosines(y), _cosines(w), 0.0, var, 1 - ratio)
        values.append(value)
        sds.append(sd)
    assert abs(np.mean(values) - a) < 4 * np.std(values) / np.sqrt(60)
    assert (
        0.7 < np.std(values) / np.mean(sds) < 1.3
    )  # 60 draws: 9 % scatter of a standard deviation


@pytest.mark.parametrize("rate, seed", [(0.02, 3), (0.06, 4)])
def test_levels_lost_in_the_noise_are_told_from_a_gauss_markov_process(rate, seed):
    """The step is a tenth of the noise of a sample; the spectrum alone gains the same for either
    name.
    """
    base = [{"process": "white_noise", "N": 2e-4}]
    rng = np.random.default_rng(seed)
    x = generator.noise(base[0], N, FS, rng)
    f = np.arange(1, N // 2 + 1) * FS / N
    shape = noises.spectrum({"process": "telegraph", "rate": rate, "amplitude": 1.0}, f, FS)
    a = noises.strength(
        lambda v: noises.gain_spectral(noises.base_psd(base, f, FS), v * v * shape), 300
    )
    truth = {
        "telegraph": {"process": "telegraph", "rate": rate, "amplitude": a},
        "gauss_markov": {"process": "gauss_markov", "sigma": a / 2, "correlation_time": 0.5 / rate},
    }
    for name, entry in truth.items():
        found = analyse(
            "gyro_x",
            x + generator.noise(entry, N, FS, rng),
            FS,
            Sum.of(from_json(e) for e in base),
        )
        assert [s.effect for s in found.steps if s.effect in truth] == [name]


@pytest.mark.parametrize("flips", [True, False])
def test_levels_beside_a_changed_parameter_are_not_taken_for_it(flips):
    """A Gauss-Markov process of the base that is four times as strong as the model says follows the
    levels, too: alone in the record, it has no levels.
    """
    rng, fs, n = np.random.default_rng(5), 50.0, 90_000
    white = {"process": "white_noise", "N": 2e-4}
    slow = {"process": "gauss_markov", "sigma": 3e-5, "correlation_time": 60.0}
    parts = [white, {**slow, "sigma": 1.2e-4}]
    if flips:
        parts += [{"process": "telegraph", "amplitude": 4e-4, "rate": 0.02}]
    x = sum(generator.noise(entry, n, fs, rng) for entry in parts)
    found = analyse("gyro_x", x, fs, Sum.of(from_json(e) for e in (white, slow)))
    sure = {s.effect for s in found.steps if s.confidence > 0.9}
    assert sure == ({"telegraph"} if flips else set())
    # of the change a record of half an hour shows that, and not surely which noise has changed
    (other,) = (s for s in found.steps if s.effect != "telegraph")
    assert "parameter_change" in (other.effect, *other.indistinguishable)


def test_the_spread_of_the_rate_is_that_of_many_records():
    """Where a dwell hardly stands out of the noise: counted flips alone would say it three times as
    well as it is known.
    """
    rng, noise, off = np.random.default_rng(3), 1e-3, []
    for _ in range(40):
        rate = float(np.exp(rng.uniform(np.log(0.1), np.log(1.0))))
        true = Telegraph(amplitude=noise * np.sqrt(8.0 * rate), rate=rate)
        x = noise * np.sqrt(FS) * rng.standard_normal(40_000) + true.simulate(40_000, FS, rng)
        found = decoded(x, FS, true, noise**2)
        distance, often = found.spread()
        off.append(
            (
                np.log(found.process.rate / rate) / often,
                np.log(found.process.amplitude / true.amplitude) / distance,
                often * np.sqrt(found.flips),
            )
        )
    off = np.array(off)
    # 40 records: a scatter of 1 / sqrt(80), three times that
    assert np.all(np.abs(np.std(off[:, :2], axis=0) - 1) < 0.34)
    assert np.median(off[:, 2]) > 2
