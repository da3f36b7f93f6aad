"""Filters inside the sensor, spikes and clipping where the noise is coloured or the grid coarse:
named, and nothing else with them.
"""

import gap_generator as generator
import numpy as np
import pytest

from imu_lib.gap.channel import analyse
from imu_lib.processes import GaussMarkov, LowPass, Sum, WhiteNoise

FS, N = 100.0, 180_000
WHITE = WhiteNoise(N=2e-4)
SD = 2e-3  # of a sample of that noise


@pytest.mark.parametrize(
    "stage",
    [
        LowPass(taps=3, rate=FS),
        LowPass(taps=8, rate=FS),
        LowPass(taps=14, rate=10 * FS),
        LowPass(taps=45, rate=10 * FS),
        LowPass(order=1, cutoff=12.0, rate=10 * FS),
        LowPass(order=4, cutoff=20.0, rate=10 * FS),
        LowPass(order=4, cutoff=8.0, rate=FS),
        LowPass(smoothing=1, cutoff=9.0, rate=FS),
    ],
    ids=lambda s: f"{s.taps or s.order or 'smoothing'}-{s.rate:g}",
)
def test_a_filter_is_named_by_its_make_and_leaves_nothing_behind(stage):
    x = Sum((WHITE, GaussMarkov(sigma=1e-4, correlation_time=60.0)), (stage,)).simulate(
        N, FS, np.random.default_rng(1)
    )
    found = analyse("gyro_x", x, FS, Sum((WHITE, GaussMarkov(sigma=1e-4, correlation_time=60.0))))
    (step,) = found.steps
    assert found.unexplained is None
    make = [step.parameters.get(name) for name in ("taps", "order", "smoothing", "rate")]
    assert (step.effect, make) == (
        "low_pass",
        [stage.taps, stage.order, stage.smoothing, stage.rate],
    ) and step.confidence > 0.9
    if stage.tunable:
        low, high = step.intervals["cutoff"]
        assert (
            abs(step.parameters["cutoff"] - stage.cutoff) < high - low
        )  # four standard deviations


def test_spikes_in_noise_that_is_not_white_are_counted_once():
    """Their neighbours are surprised, too, where noise is differenced: these are shadows."""
    rng = np.random.default_rng(2)
    x = generator.noise({"process": "white_noise", "N": 2e-4}, N, FS, rng) + generator.noise(
        {"process": "quantization", "Q": 2e-5}, N, FS, rng
    )
    hit = rng.random(N) < 0.0015
    found = analyse("gyro_x", x + hit * rng.standard_normal(N) * 50 * SD, FS, Sum((WHITE,)))
    spikes = next(s for s in found.steps if s.effect == "spikes")
    low, high = spikes.intervals["rate"]
    assert (
        abs(spikes.parameters["rate"] / (hit.mean() * FS) - 1) < 0.15
    )  # spikes below some standard deviations are not seen
    assert high / low < 2
    assert {s.effect for s in found.steps} == {
        "spikes",
        "quantization",
    } and found.unexplained is None


@pytest.mark.parametrize("step", [0.3, 0.8, 1.5])
def test_clipping_before_a_coarse_grid_is_named_without_a_change_of_noise(step):
    """Steps in standard deviations of the noise."""
    x = (
        generator.noise({"process": "white_noise", "N": 2e-4}, N, FS, np.random.default_rng(3))
        + 1e-3
    )
    lsb = step * SD
    clipped = np.rint(np.minimum(x, np.quantile(x, 0.97)) / lsb) * lsb
    found = analyse("gyro_x", clipped, FS, Sum((WHITE,)))
    assert {s.effect for s in found.steps} == {"resolution", "saturation"}
