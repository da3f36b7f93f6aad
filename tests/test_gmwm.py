"""Generalised method of wavelet moments: its moments are half the Allan variance, its fits agree
with the likelihood.
"""

import numpy as np
import pytest

from imu_lib import allan, gmwm, likelihood, preset
from imu_lib.processes import GaussMarkov, RandomWalk, Sum, WhiteNoise

FS = 100.0


def test_wavelet_variance_is_half_the_allan_variance():
    x = np.random.default_rng(1).standard_normal(5000)
    nu = gmwm.wavelet_variance(x, FS)
    curve = allan.deviation(x, FS)
    for m, value in zip(nu.m, nu.variance):
        if m in curve.m:
            assert value == pytest.approx(
                curve.avar[np.flatnonzero(curve.m == m)[0]] / 2, rel=1e-10
            )
    assert np.all(nu.low < nu.variance) and np.all(nu.variance < nu.high)


def test_covariance_of_the_moments_is_what_draws_show():
    """Scatter of 300 draws against the model's covariance. A variance of few degrees of freedom is
    skew: its scatter over
    300 draws is known to 4 % at the short scales and to 10 % at the longest, three of which are
    the tolerances.
    """
    model = WhiteNoise(N=0.1) + GaussMarkov(sigma=1.0, correlation_time=2.0)
    draws = np.array(
        [
            gmwm.wavelet_variance(
                model.simulate(4096, 10.0, np.random.default_rng([2, s])), 10.0
            ).variance
            for s in range(300)
        ]
    )
    moments = gmwm.wavelet_variance(model.simulate(4096, 10.0, np.random.default_rng(3)), 10.0)
    problem = gmwm._Moments(moments, WhiteNoise() + GaussMarkov())
    theta = np.log([0.1, 1.0, 2.0])
    assert np.allclose(problem.predict(theta), draws.mean(axis=0), rtol=0.15)
    ratio = draws.std(axis=0) / np.sqrt(np.diag(problem.covariance(theta)))
    assert np.all(np.abs(ratio[:6] - 1) < 0.12) and np.all(np.abs(ratio[6:] - 1) < 0.3)


@pytest.mark.parametrize("weights", ["optimal", "diagonal"])
def test_fit_agrees_with_the_likelihood(weights):
    model = preset("3dm-gx3-25")["accel_x"]
    x = model.simulate(360_000, FS, np.random.default_rng(4))
    template = WhiteNoise() + GaussMarkov() + RandomWalk() + model.low_pass
    found, yardstick = gmwm.fit(x, FS, template, weights=weights), likelihood.fit(x, FS, template)
    for label, e in found.parameters.items():
        other = yardstick[label]
        sd = (other.high - other.low) / 4
        assert abs(e.value - other.value) < 3 * sd, (
            label
        )  # two estimators of nearly the same efficiency
        assert e.low < e.value < e.high
    assert (found.p_value is None) == (weights == "diagonal")
    if found.p_value is not None:
        assert found.p_value > 1e-3


def test_bad_calls_are_refused():
    with pytest.raises(ValueError, match="`x`"):
        gmwm.wavelet_variance(np.ones(4), FS)
    with pytest.raises(ValueError, match="`weights`"):
        gmwm.fit(np.random.default_rng(1).standard_normal(1000), FS, WhiteNoise(), weights="none")
    with pytest.raises(ValueError, match="too few"):
        gmwm.fit(
            np.random.default_rng(1).standard_normal(20),
            FS,
            WhiteNoise() + GaussMarkov() + RandomWalk(),
        )


def test_start_is_not_chosen_by_the_longest_scales():
    """A draw whose few longest windows, at equal weight, let a slow Gauss-Markov process pass for
    the walk.
    """
    model = preset("3dm-gx3-25")["accel_x"]
    x = model.simulate(2_520_000, 100.0, np.random.default_rng([9, 3]))
    found = gmwm.fit(
        x,
        100.0,
        Sum(
            tuple(t.with_(**{p.name: None for p in t.parameters}) for t in model.terms),
            model.stages,
        ),
    )
    # standard errors are 1.5, 4 and 3.5 %: four of each
    for label, truth, rel in (
        ("sigma", 1.307e-3, 0.06),
        ("correlation_time", 2.369, 0.16),
        ("K", 2.914e-4, 0.14),
    ):
        assert found[label].value == pytest.approx(truth, rel=rel)
