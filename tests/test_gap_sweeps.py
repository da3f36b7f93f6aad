"""A tone whose frequency goes from one end of its band to the other."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from imu_lib.gap.effects.vibration import VIBRATION

FS, N = 125.0, 20_000


def swept(first, last):
    return np.sin(2 * np.pi * np.cumsum(np.linspace(first, last, N)) / FS)


def looked_at(**channels):
    view = SimpleNamespace(record=None, raw=channels, fs=FS, temperature=None, model=None)
    return VIBRATION.candidates(view)


@pytest.mark.parametrize("ends", [(22.0, 34.0), (52.0, 12.0)], ids=["slow", "far"])
def test_what_sweeps_on_two_channels_is_one_vibration(ends):
    rng = np.random.default_rng(1)
    tone = swept(*ends)
    raw = {c: a * tone + rng.standard_normal(N) for c, a in (("gyro_x", 0.8), ("accel_y", 0.6))}
    (found,) = looked_at(**raw)
    p = found.process
    assert found.doubt is None and set(p.channels) == set(raw) and "sweeps" in found.where
    assert p.frequency == pytest.approx(np.mean(ends), abs=0.15 * abs(np.ptp(ends)))
    assert p.bandwidth == pytest.approx(abs(np.ptp(ends)), rel=0.4)


def test_a_filter_that_bends_the_spectrum_of_another_channel_is_no_part_of_it():
    """What is 12 Hz wide rises by a third over its sides on the flank of a filter alone."""
    rng = np.random.default_rng(2)
    kernel = np.convolve(np.convolve([0.5, 0.5], [0.5, 0.5]), [0.5, 0.5])
    x, y = (lfilter(kernel, [1.0], rng.standard_normal(N)) for _ in range(2))
    (found,) = looked_at(gyro_x=x + 0.6 * swept(40.0, 27.0), accel_z=y)
    assert set(found.signal) == {"gyro_x"}
    assert "this channel alone" in found.doubt and "sweeps" in found.doubt
