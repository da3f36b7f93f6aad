"""A name is kept where what was found behaves as the name says: tones that do not are no vibration,
and one that goes on and off has its times.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from gap_unknowns import unknown
from scipy import signal

from imu_lib.gap.effects.vibration import VIBRATION
from imu_lib.vibrations.episodes import episodes

FS, N = 100.0, 24_000


def found_in(raw):
    view = SimpleNamespace(record=None, raw=raw, fs=FS, temperature=None, model=None)
    return VIBRATION.candidates(view)


@pytest.mark.parametrize("kind", ["chirp", "fading_tone", "square_wave"])
def test_a_tone_of_one_channel_that_is_no_vibration_is_not_named(kind):
    named = 0
    for seed in range(6):
        rng = np.random.default_rng([seed, 77])
        raw = {c: rng.standard_normal(N) for c in ("gyro_x", "gyro_y")}
        raw["gyro_x"] = unknown(kind, raw["gyro_x"], FS, rng, 1.0)
        named += any(not f.doubt for f in found_in(raw))
    # in four minutes some lie too near the noise to tell how they behave
    assert named <= 1


def test_what_the_sampling_folds_of_a_periodic_signal_is_no_line_of_its_own():
    """The twenty-seventh multiple beside the nineteenth was a vibration that wanders."""
    t, rng = np.arange(90_000) / FS, np.random.default_rng(9)
    raw = {"gyro_x": rng.standard_normal(90_000) + 0.6 * np.sign(np.sin(2 * np.pi * 2.1741 * t))}
    assert not [f for f in found_in(raw) if not f.doubt]


def test_a_machine_that_goes_on_and_off_is_named_with_its_times():
    t, rng = np.arange(N) / FS, np.random.default_rng(8)
    raw = {c: rng.standard_normal(N) for c in ("gyro_x", "gyro_y", "accel_z")}
    times = ((20.0, 60.0), (95.0, 120.0), (170.0, 230.0))
    on = sum(((t > a) & (t < b)) * 1.0 for a, b in times)
    for c in ("gyro_x", "accel_z"):
        raw[c] = raw[c] + 0.5 * on * np.sin(2 * np.pi * 17.3 * t + len(c))
    found = sorted(found_in(raw), key=lambda f: f.process.start)
    assert len(found) == 3
    for item, (start, stop) in zip(found, times):
        assert item.process.frequency == pytest.approx(17.3, abs=0.02)
        # a block of a 360th of the record, and as much for the noise
        assert item.process.start == pytest.approx(start, abs=1.5)
        assert item.process.stop == pytest.approx(stop, abs=1.5)


def test_noise_has_no_episodes():
    rng = np.random.default_rng(2)
    assert all(episodes(rng.exponential(size=3000), 1, 300.0) is None for _ in range(60))


def test_the_same_resonance_of_three_channels_is_no_vibration():
    rng = np.random.default_rng(9)
    r, w = 0.85, 2 * np.pi * 31.0 / FS
    ring = ([1.0], [1.0, -2 * r * np.cos(w), r * r])
    own = {
        c: signal.lfilter(*ring, rng.standard_normal(N)) for c in ("gyro_x", "gyro_y", "accel_z")
    }
    assert found_in(own) == []
    shared = signal.lfilter(*ring, rng.standard_normal(N))
    (item,) = found_in({c: 0.7 * shared + rng.standard_normal(N) for c in own})
    assert item.process.frequency == pytest.approx(31.0, abs=3)
