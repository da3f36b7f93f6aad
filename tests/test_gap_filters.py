"""Filters of the sensor: with a floor in their stop band, as decimators, on a grid, beside a level
that changes.
"""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from imu_lib.drawing.record import draw_channel
from imu_lib.gap.channel import analyse
from imu_lib.gap.effects import CATALOGUE
from imu_lib.gap.effects.competitor import most_beside_filter
from imu_lib.processes import LowPass, ReadOutNoise, Sum, WhiteNoise, from_json
from imu_lib.samples.innovations import Smooth, whitened

FS, N = 100.0, 16_000


def white(seed, n=N):
    return 1e-3 * np.random.default_rng(seed).standard_normal(n)


def test_a_filter_before_a_noisy_converter_is_found_with_its_floor():
    """The floor lies 30 dB below what is let through, and bends the stop band of every filter."""
    x = lfilter(*butter(3, 0.5), white(1)) + 0.03 * white(2)
    found = analyse("gyro_x", x, FS, None)
    (step,) = found.steps
    assert step.effect == "low_pass" and step.confidence > 0.9 and found.unexplained is None
    assert step.parameters["order"] == 3 and step.parameters["cutoff"] == pytest.approx(
        25, rel=0.03
    )
    (floor,) = [t for t in found.model.terms if isinstance(t, ReadOutNoise)]
    assert floor.N == pytest.approx(3e-5 / np.sqrt(FS), rel=0.2)
    assert "floor" in step.where


def test_noise_behind_a_filter_is_drawn_behind_it():
    low_pass = LowPass(cutoff=10.0, order=4, rate=FS)
    model = Sum((WhiteNoise(N=1e-4), ReadOutNoise(N=1e-5)), (low_pass,))
    x = model.simulate(60_000, FS, np.random.default_rng(3))
    power = np.abs(np.fft.rfft(np.hanning(len(x)) * x)) ** 2 * 16 / 3 / (FS * len(x))
    f = np.fft.rfftfreq(len(x), 1 / FS)
    for low, high in ((1.0, 5.0), (40.0, 49.0)):  # 12,000 ordinates or more: 1 % twice over
        part = (f > low) & (f < high)
        assert np.mean(power[part]) == pytest.approx(np.mean(model.psd(f[part], FS)), rel=0.06)
    pieces = draw_channel(model, 60_000, FS, np.random.default_rng(3), size=7_000)
    assert np.allclose(np.concatenate(list(pieces)), x, atol=1e-12)
    assert from_json(ReadOutNoise(N=1e-5).to_json()) == ReadOutNoise(N=1e-5)


def test_moving_averages_in_a_row_are_a_decimator():
    stage = LowPass(taps=3, order=3, rate=FS)
    assert stage.gain(stage.cutoff, FS) == pytest.approx(0.5) and not stage.tunable
    rng = np.random.default_rng(4)
    box = np.ones(3) / 3
    kernel = np.convolve(np.convolve(box, box), box)
    f = np.linspace(0.1, 49.0, 40)
    response = kernel @ np.exp(-2j * np.pi * np.outer(np.arange(7), f) / FS)
    assert stage.gain(f, FS) == pytest.approx(np.abs(response) ** 2, abs=1e-12)
    turned = np.exp(1j * stage.phase(f, FS)) * np.sqrt(stage.gain(f, FS))
    assert turned == pytest.approx(response, abs=1e-9)
    x = rng.standard_normal(500)
    padded = np.concatenate([np.zeros(6), x])
    assert stage.run(padded, FS, 500) == pytest.approx(lfilter(kernel, [1.0], x))
    found = analyse("gyro_x", lfilter(kernel, [1.0], white(5)), FS, None)
    assert [s.effect for s in found.steps] == ["low_pass"] and found.unexplained is None
    named = found.steps[0].parameters
    assert (named["taps"], named["order"]) == (3, 3) and found.steps[0].confidence > 0.9


def test_rounding_in_a_stop_band_says_nothing_of_the_level():
    """Behind the filter half of the spectrum is rounding, which stays when the noise doubles."""
    x = lfilter(*butter(4, 0.4), white(6)) * np.linspace(1.0, 2.0, N)
    x = np.rint(x / 4e-4) * 4e-4
    y = whitened(x, Smooth(x, FS).above(2 * (4e-4) ** 2 / 12 / FS))
    assert np.std(y) == pytest.approx(1.0, abs=0.02)
    early, late = np.std(y[: N // 8]), np.std(y[-N // 8 :])
    assert late / early == pytest.approx(1.9375 / 1.0625, rel=0.05)  # 4 sd: 2,000 samples, 2/3 free
    bare = whitened(x, Smooth(x, FS))
    assert np.std(bare[-N // 8 :]) / np.std(bare[: N // 8]) < 1.6
    found = analyse("gyro_x", x, FS, None)
    (step,) = [s for s in found.steps if s.effect == "noise_level_change"]
    assert step.parameters["ratio"] == pytest.approx(2.0, rel=0.1) and step.confidence > 0.9


def test_a_noise_that_forgets_within_some_samples_may_be_a_filter():
    quick, slow = {"correlation_time": 0.02}, {"correlation_time": 2.0}
    assert most_beside_filter(quick, []) == 0.5 and most_beside_filter(slow, []) == 1.0
    assert most_beside_filter(quick, [CATALOGUE["low_pass"]]) < 0.5
