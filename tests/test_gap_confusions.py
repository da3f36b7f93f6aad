"""What was once taken for something else: pairs of causes that look alike until the one thing that
tells them apart is looked at.
"""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt

from imu_lib.gap import close
from imu_lib.gap.channel import analyse
from imu_lib.gap.coherence import cross_spectra
from imu_lib.gap.effects.saturation import Saturation
from imu_lib.gap.residual_tests import stationarity
from imu_lib.gap.shared_noise import shared_noise
from imu_lib.model import Model
from imu_lib.processes import (
    Autoregressive,
    CommonMode,
    GaussMarkov,
    LowPass,
    RandomWalk,
    Resolution,
    Sum,
    Temperature,
    WhiteNoise,
)
from imu_lib.samples.innovations import Smooth, whitened

FS, N = 100.0, 180_000
WHITE = WhiteNoise(N=2e-4)
SD = 2e-3  # of a sample of that noise


@pytest.mark.parametrize("order, cutoff", [(2, 5.0), (3, 10.0), (4, 5.0), (4, 16.0)])
def test_a_stop_band_holds_no_independent_samples(order, cutoff):
    """Blocks of filtered noise scatter more than blocks of as many independent samples: that is no
    change of level.
    """
    x = sosfilt(
        butter(order, cutoff, fs=FS, output="sos"), np.random.default_rng(order).standard_normal(N)
    )
    smooth = Smooth(x, FS)
    y = whitened(x, smooth)
    energy = np.mean(y[: N // 500 * 500].reshape(-1, 500) ** 2, axis=1)
    # the scatter of 360 block energies is known to 1 / sqrt(720): five standard deviations
    assert abs(
        np.std(energy) / np.mean(energy) / np.sqrt(2 / (500 * smooth.independent)) - 1
    ) < 5 / np.sqrt(720)
    assert min(c.log_p for c in stationarity(y, FS, smooth)) > -4


@pytest.mark.parametrize(
    "stages",
    [
        (LowPass(order=3, cutoff=12.0, rate=FS),),
        (LowPass(taps=7, rate=FS), Resolution(lsb=1e-3)),
        (LowPass(order=3, cutoff=13.0, rate=FS), Resolution(lsb=6e-4)),
    ],
    ids=["filter", "average-grid", "filter-grid"],
)
def test_a_base_with_a_filter_and_a_grid_leaves_nothing(stages):
    """The grids are 1.3 and 0.6 standard deviations of the output wide: neighbours often agree,
    and none is frozen.
    """
    base = Sum((WHITE,), stages)
    found = analyse("gyro_x", base.simulate(N, FS, np.random.default_rng(2)), FS, base)
    assert found.steps == [] and found.unexplained is None


def test_missing_samples_of_filtered_noise_are_no_resonance():
    base = Sum((WHITE,), (LowPass(order=2, cutoff=20.0, rate=FS),))
    x = base.simulate(N, FS, np.random.default_rng(3))
    for start in np.random.default_rng(4).integers(100, N - 100, 20):
        x[start : start + 12] = np.nan
    found = analyse("gyro_x", x, FS, base)
    assert found.steps == [] and found.unexplained is None


def test_spectra_of_two_filtered_channels_do_not_cohere():
    rng = np.random.default_rng(5)
    channels = {
        name: np.cumsum(rng.standard_normal(N)) * 1e-6
        + sosfilt(butter(order, cutoff, fs=FS, output="sos"), rng.standard_normal(N))
        for name, order, cutoff in (("gyro_x", 2, 10.0), ("gyro_y", 4, 13.0))
    }
    assert shared_noise(cross_spectra(channels, FS), FS) == (None, {}, None)


def test_noise_that_alternates_is_no_quantization():
    x = Sum((WHITE, Autoregressive(phi=(-0.45,), sigma=1e-3, rate=FS))).simulate(
        N, FS, np.random.default_rng(6)
    )
    (step,) = analyse("gyro_x", x, FS, Sum((WHITE,))).steps
    low, high = step.intervals["sigma"]
    assert (
        step.effect == "autoregressive" and len(step.parameters["phi"]) == 1 and low < 1e-3 < high
    )


def test_a_correlation_time_far_from_the_given_one_is_one_changed_parameter():
    given = GaussMarkov(sigma=1e-4, correlation_time=50.0)
    x = Sum((WHITE, given.with_(correlation_time=1.5))).simulate(N, FS, np.random.default_rng(7))
    (step,) = analyse("gyro_x", x, FS, Sum((WHITE, given))).steps
    assert (step.effect, step.parameters["name"]) == ("parameter_change", "correlation_time")
    low, high = step.intervals["to"]
    assert low < 1.5 < high


def test_a_frozen_sample_at_the_end_of_the_range_is_no_rail():
    x = np.round(np.random.default_rng(8).standard_normal(20_000), 1)
    at = int(np.argmin(x))
    x[at : at + 30] = x.min()
    assert Saturation().detect(x, 0.1, None) is None
    clipped = np.maximum(x, np.quantile(x, 0.02))
    assert Saturation().detect(clipped, 0.1, None).process.low == pytest.approx(clipped.min())


@pytest.mark.parametrize("shift", np.linspace(0.0, 0.5, 6))
@pytest.mark.parametrize("step", (2.0, 3.0, 4.0))
def test_steps_coarser_than_the_noise_are_no_rail(shift, step):
    x = np.random.default_rng(8).standard_normal(12_000)
    assert Saturation().detect(step * np.rint(x / step + shift), step, None) is None


def test_a_curved_regression_on_the_temperature_is_named_with_its_curvature():
    rng = np.random.default_rng(9)
    temperature = 25 + 5 * lfilter([1], [1, -0.9999], rng.standard_normal(N)) / 70
    x = WHITE.simulate(N, FS, rng) + 1e-5 * (temperature - 22) ** 2
    found = analyse("gyro_x", x, FS, Sum((WHITE,)), temperature=temperature)
    (step,) = found.steps
    assert step.effect == "temperature" and found.unexplained is None
    assert step.parameters["curvature"] == pytest.approx(1e-5, rel=0.1)
    straight = WHITE.simulate(N, FS, rng) + Temperature(slope=1e-4, reference=25.0).mean(
        np.arange(N) / FS, temperature
    )
    (step,) = analyse("gyro_x", straight, FS, Sum((WHITE,)), temperature=temperature).steps
    assert step.effect == "temperature"


def test_pulses_once_a_second_are_no_sinusoids():
    x = WHITE.simulate(N, FS, np.random.default_rng(10))
    x[:: int(FS)] += 1.2 * SD
    found = analyse("gyro_x", x, FS, Sum((WHITE, RandomWalk(K=1e-7))))
    assert found.unexplained is not None and all(s.confidence <= 0.5 for s in found.steps)


@pytest.mark.parametrize("filtered", [None, 1], ids=["behind", "before"])
def test_noise_in_common_is_found_on_either_side_of_the_filters(filtered):
    base = Model(
        channels={
            c: Sum((WhiteNoise(N=n),), (LowPass(order=2, cutoff=25.0, rate=FS),))
            for c, n in (("gyro_x", 1e-4), ("gyro_y", 8e-5))
        },
        rate=FS,
    )
    truth = Model(
        channels=base.channels,
        record=(CommonMode(N=5e-5, channels=("gyro_x", "gyro_y"), filtered=filtered),),
        rate=FS,
    )
    record = truth.simulate_record(N, FS, np.random.default_rng(11))
    found = close(record, base, simulations=0, jobs=1)
    ((where, step),) = found.steps
    assert (where, step.effect, step.parameters.get("filtered")) == (
        "record",
        "common_mode",
        filtered,
    )
    assert abs(step.parameters["N"] / 5e-5 - 1) < 0.03 and found.record_unexplained is None
    # the grown model, held, leaves nothing in a second record
    again = truth.simulate_record(N, FS, np.random.default_rng(12))
    once_more = close(again, found.model, simulations=0, jobs=1)
    assert once_more.steps == [] and once_more.record_unexplained is None


def test_noise_in_common_before_filters_of_different_kinds():
    """Each turns its phase by another amount; every channel was given a larger N, with full
    confidence.
    """
    filters = {
        "gyro_x": (LowPass(taps=8, rate=FS),),
        "gyro_y": (),
        "gyro_z": (LowPass(order=3, cutoff=25.0, rate=FS),),
    }
    base = Model(channels={c: Sum((WhiteNoise(N=1e-4),), f) for c, f in filters.items()}, rate=FS)
    truth = Model(
        channels=base.channels,
        record=(CommonMode(N=5e-5, channels=tuple(filters), filtered=1),),
        rate=FS,
    )
    found = close(
        truth.simulate_record(N, FS, np.random.default_rng(14)), base, simulations=0, jobs=1
    )
    ((where, step),) = found.steps
    assert (where, step.effect, step.parameters.get("filtered"), step.parameters["channels"]) == (
        "record",
        "common_mode",
        1,
        list(filters),
    )
    assert abs(step.parameters["N"] / 5e-5 - 1) < 0.05 and found.record_unexplained is None


def test_noise_in_common_of_channels_that_a_model_lacks_is_drawn_for_none():
    model = Model(
        channels={"accel_x": Sum((WHITE,))},
        record=(CommonMode(N=1.0, channels=("gyro_x", "gyro_y")),),
        rate=FS,
    )
    assert set(model.simulate(10, FS, np.random.default_rng(13))) == {"accel_x"}


def test_a_slow_change_of_the_level_is_one_step_with_its_duration():
    rng = np.random.default_rng(11)
    n, fs = 40_000, 50.0
    t = np.arange(n) / fs
    x = 1e-3 * rng.standard_normal(n)
    slow = analyse("gyro_x", x + 3e-4 * np.clip((t - 350) / 60, 0, 1), fs, None)
    (step,) = slow.steps
    assert step.effect == "step" and step.confidence > 0.9 and slow.unexplained is None
    assert step.parameters["time"] == pytest.approx(350, abs=20)
    assert step.parameters["duration"] == pytest.approx(60, rel=0.5)
    assert step.parameters["amplitude"] == pytest.approx(3e-4, rel=0.15)
    # a sudden one has none
    (sudden,) = analyse("gyro_x", x + 3e-4 * (t > 350), fs, None).steps
    assert sudden.effect == "step" and "duration" not in sudden.parameters
