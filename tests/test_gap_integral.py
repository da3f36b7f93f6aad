"""Increments of a rounded angle: its quantization is known by the grid, and no rounding of the
samples is named beside it.
"""

import numpy as np
import pytest

from imu_lib.gap.channel import analyse
from imu_lib.gap.effects.resolution import grid_of
from imu_lib.processes import (
    GaussMarkov,
    LowPass,
    Quantization,
    Resolution,
    Sum,
    WhiteNoise,
    from_json,
)

FS, N = 100.0, 180_000
BASE = Sum((WhiteNoise(N=1e-3), GaussMarkov(sigma=1e-3, correlation_time=60.0)))
#: Steps of the grid in standard deviations of a sample.
STEPS = (0.5, 1.2)


def _of_grid(share):
    return Quantization.of_grid(share * 1e-3 * np.sqrt(FS), FS)


def test_a_sum_rounds_its_integral_and_its_spectrum_is_that_of_quantization():
    q = _of_grid(0.5)
    model = Sum((*BASE.terms, q), (LowPass(order=2, cutoff=15.0, rate=FS),))
    x = model.simulate(400_000, FS, np.random.default_rng(1))
    step = q.Q * np.sqrt(12) * FS
    assert np.allclose(x / step, np.rint(x / step), atol=1e-6)
    f = np.fft.rfftfreq(400_000, 1 / FS)
    power = (
        np.abs(np.fft.rfft((x - x.mean()) * np.hanning(400_000))) ** 2 * 2 / FS / (0.375 * 400_000)
    )
    for low, high in (
        (1.0, 5.0),
        (12.0, 18.0),
        (30.0, 40.0),
        (45.0, 50.0),
    ):  # behind the filter, where only the rounding is left
        on = (f >= low) & (f < high)
        want = model.psd(f[on], FS).mean()
        assert abs(power[on].mean() / want - 1) < 5 * np.sqrt(2 / on.sum())
    assert from_json(q.to_json()) == q
    # the closed forms are those of quantization
    plain = Sum((*BASE.terms, Quantization(Q=q.Q)))
    tau = np.array([0.01, 1.0, 100.0])
    assert np.allclose(Sum((*BASE.terms, q)).avar(tau, FS), plain.avar(tau, FS))


@pytest.mark.parametrize("share", STEPS)
def test_the_quantization_of_a_rounded_angle_is_named_alone(share):
    q = _of_grid(share)
    x = (BASE + q).simulate(N, FS, np.random.default_rng(20))
    found = analyse("gyro_x", x, FS, BASE)
    assert [s.effect for s in found.steps] == ["quantization"] and found.unexplained is None
    assert found.steps[0].parameters["Q"] == pytest.approx(q.Q, rel=1e-6)
    # the model that was found has nothing left to say of a second record, and a model that knows Q
    # but not the grid neither
    again = (BASE + q).simulate(N, FS, np.random.default_rng(21))
    for base in (found.model, BASE + Quantization(Q=q.Q)):
        assert analyse("gyro_x", again, FS, base).steps == []


def test_rounding_of_samples_is_not_taken_for_that_of_an_angle():
    x = Sum(BASE.terms, (Resolution(lsb=8e-3),)).simulate(N, FS, np.random.default_rng(22))
    assert [s.effect for s in analyse("gyro_x", x, FS, BASE).steps] == ["resolution"]
    both = Sum((*BASE.terms, Quantization(Q=1.5e-5)), (Resolution(lsb=4e-3),)).simulate(
        N, FS, np.random.default_rng(23)
    )
    found = analyse("gyro_x", both, FS, BASE)
    assert [s.effect for s in found.steps] == ["resolution", "quantization"]
    assert found.steps[1].parameters["Q"] == pytest.approx(
        1.5e-5, rel=0.05
    )  # its interval is 2 % wide


def test_a_grid_too_fine_to_tell_is_named_with_both_makes():
    q = _of_grid(0.1)
    (step,) = analyse(
        "gyro_x", (BASE + q).simulate(N, FS, np.random.default_rng(25)), FS, BASE
    ).steps
    assert {step.effect, *step.indistinguishable} == {
        "resolution",
        "quantization",
    } and step.confidence <= 0.5


def test_a_grid_is_seen_behind_a_few_samples_that_lie_off_it():
    rng = np.random.default_rng(24)
    x = np.rint(rng.standard_normal(20_000) * 5) * 0.1
    x[rng.choice(20_000, 100, replace=False)] += rng.standard_normal(100)
    assert grid_of(x)[0] == pytest.approx(0.1)
    assert grid_of(rng.standard_normal(20_000)) is None
