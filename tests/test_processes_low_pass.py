"""What a low-pass filter of the sensor does to spectra and to draws."""

import tracemalloc

import numpy as np
import pytest
from scipy.signal import welch

from imu_lib.processes import (
    Autoregressive,
    Flicker,
    GaussMarkov,
    LowPass,
    RandomWalk,
    Sinusoid,
    Sum,
    WhiteNoise,
)

FS = 100.0


@pytest.mark.parametrize(
    "low_pass", [LowPass(taps=8), LowPass(order=3, cutoff=20.0), LowPass(smoothing=1, cutoff=9.0)]
)
def test_phase_and_gain_of_a_filter_are_those_of_its_response_to_an_impulse(low_pass):
    _, before = low_pass.grid(FS)
    x = np.zeros(4096 + before)
    x[before] = 1.0
    h = np.fft.rfft(low_pass.run(x, FS, 4096))
    f = np.fft.rfftfreq(4096, 1 / FS)
    on = (f > 0) & (f < 0.49 * FS) & (np.abs(h) > 1e-3)
    assert np.max(np.abs(np.angle(h[on] * np.exp(-1j * low_pass.phase(f[on], FS))))) < 1e-3
    assert np.allclose(np.abs(h[on]) ** 2, low_pass.gain(f[on], FS), atol=1e-6)


def test_spectrum_folded_from_many_images_holds_a_few_of_them():
    """Block means of a long record fold a hundred images and more onto 130,000 frequencies."""
    f = np.linspace(0.01, 0.5, 2000)
    entry = Sum((GaussMarkov(1.0, 3.0), WhiteNoise(0.1)), (LowPass(taps=300, rate=300.0),))
    tracemalloc.start()
    psd = entry.psd(f, 1.0)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 30 * f.nbytes  # 300 images, their gains and terms were 600 arrays and more
    assert np.allclose(psd[::500], entry.psd(f[::500], 1.0))


@pytest.mark.parametrize(
    "term",
    [WhiteNoise(1.0), GaussMarkov(1.0, 0.03), GaussMarkov(1.0, 30.0), RandomWalk(1.0), Flicker(1.0)]
    + [Sinusoid(1.0, 40.0), Autoregressive((0.5, -0.3), 1.0, 1000.0)],
    ids=lambda t: f"{t.name} {t.memory:g}",
)
@pytest.mark.parametrize("taps", [10, 15])
def test_what_moves_within_a_moving_average_is_averaged_in_simulation(term, taps):
    """Read out at 100 Hz, an average of the last samples of 1 kHz of a walk or a line is no sample
    of it: nearly three times less noise at 50 Hz."""
    entry = Sum((term,), (LowPass(taps=taps, rate=1000.0),))
    x = entry.simulate(1 << 14, FS, np.random.default_rng(8))
    if isinstance(term, Sinusoid):
        gain = entry.low_pass.gain(40.0, 1000.0)
        assert 2 * np.var(x) == pytest.approx(gain, rel=0.01)
        return
    f, seen = welch(x, FS, nperseg=256)
    high = f > 35.0
    ratio = np.mean(seen[high] / entry.psd(f[high], FS))
    assert ratio == pytest.approx(1.0, abs=0.1)  # 2 % is one standard error
