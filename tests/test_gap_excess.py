"""What a vibration put into its channels: its power, the shape of its spectrum, its bursts."""

import numpy as np
import pytest

from imu_lib.gap.effects.vibration import VIBRATION
from imu_lib.gap.record_vibrations import RecordView
from imu_lib.processes import Vibration

FS, N = 100.0, 30_000


def found(x):
    """The strongest vibration of the channels."""
    view = RecordView(None, x, FS, None, None)
    return max(VIBRATION.candidates(view), key=lambda item: item.gain).process


def shaken(frequency, amplitude, rng):
    """Two channels of white noise and a line of steady amplitude that goes its way."""
    wave = amplitude * np.cos(2 * np.pi * np.cumsum(frequency) / FS)
    return {c: rng.standard_normal(N) + k * wave for c, k in (("gyro_x", 1.0), ("gyro_z", 0.5))}


def test_a_fan_that_races_now_and_then_has_its_profile():
    """Twenty hertz, and every ten seconds for one up to twenty-six."""
    rng = np.random.default_rng(1)
    t = np.arange(N) / FS
    wander = np.interp(t, np.arange(301), 0.3 * rng.standard_normal(301))
    races = 6.0 * np.maximum(1.0 - np.abs(t % 10.0 - 5.0), 0.0)
    p = found(shaken(20.0 + wander + races, 1.5, rng))
    assert p.frequency == pytest.approx(20.0, abs=0.3)
    assert dict(zip(p.channels, p.amplitude))["gyro_x"] == pytest.approx(1.5, rel=0.1)
    at, density = np.array(p.profile_frequency), np.array(p.profile)
    share = np.cumsum((density[1:] + density[:-1]) * np.diff(at))
    beyond = 1.0 - np.interp(21.5, at[1:], share / share[-1])
    # it is there for 15 % of the time, of which the furthest is a band of its own; a Lorentzian
    # line as wide at half height has 2 % there
    assert 0.05 < beyond < 0.2


def test_steps_on_a_floor_come_in_bursts():
    """A band of noise that is there a tenth of the time, for a second at a time."""
    rng = np.random.default_rng(2)
    band = Vibration(25.0, (2.0, 1.0), 10.0, channels=("gyro_x", "gyro_z"))
    loud = np.repeat(rng.random(N // 100) < 0.1, 100) / np.sqrt(0.1)
    x = {c: rng.standard_normal(N) + loud * v for c, v in band.on(N, FS, rng).items()}
    p = found(x)
    assert dict(zip(p.channels, p.amplitude))["gyro_x"] == pytest.approx(2.0, rel=0.15)
    steady = found({c: rng.standard_normal(N) + v for c, v in band.on(N, FS, rng).items()})
    assert steady.wander is None
    # the fourth moment of a lognormal amplitude is that of the bursts, within the scatter of 30
    assert 3.0 * np.exp(4 * p.wander**2) == pytest.approx(3.0 / 0.1, rel=0.5)
    assert 0.2 < p.wander_time < 1.5


def test_a_line_in_the_skirt_of_one_that_wanders_is_left_where_it_is():
    """Its power beside what is taken out for the wandering one is what it was."""
    rng = np.random.default_rng(4)
    t = np.arange(N) / FS
    wander = 0.5 * np.interp(t, np.arange(301), rng.standard_normal(301))
    races = 6.0 * np.maximum(1.0 - np.abs(t % 10.0 - 5.0), 0.0)
    x = shaken(20.0 + wander + races, 1.5, rng)
    line = 0.2 * np.cos(2 * np.pi * 23.037 * t)
    x["gyro_x"] = x["gyro_x"] + line
    view = RecordView(None, x, FS, None, None)
    item = max(VIBRATION.candidates(view), key=lambda item: item.gain)
    wave = np.exp(-2j * np.pi * 23.037 * t)
    taken = abs(np.mean(item.signal["gyro_x"] * wave))
    assert (
        taken < 0.3 * abs(np.mean(x["gyro_x"] * wave))
        and max(item.process.profile_frequency) > 23.5
    )


def test_a_line_that_no_channel_shows_alone_is_seen_on_all_of_them():
    """Amplitude 0.08 in noise of 1: each has 40 nats in one ordinate, some 20 in segments."""
    rng = np.random.default_rng(9)
    wave = np.exp(2j * np.pi * 17.3 * np.arange(N) / FS)
    names = ("gyro_x", "gyro_y", "accel_z")
    quiet = {c: rng.standard_normal(N) for c in names}
    view = RecordView(None, quiet, FS, None, None)
    assert not VIBRATION.candidates(view)
    p = found(
        {c: x + 0.08 * (wave * np.exp(2j * k)).real for k, (c, x) in enumerate(quiet.items())}
    )
    assert p.frequency == pytest.approx(17.3, abs=0.01) and p.channels == names
