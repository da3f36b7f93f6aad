"""Vibration found over all channels: lines, combs, lines that wander, parts of a record, bands."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal

from imu_lib.gap import record_vibrations
from imu_lib.gap.effects.vibration import VIBRATION
from imu_lib.processes import Vibration
from imu_lib.vibrations.band_removal import quietened

NAMES = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


def still(n, rng):
    """Six channels of white noise over a slow drift."""
    sd = (1e-3, 1e-3, 2e-3, 1e-2, 1e-2, 2e-2)
    drift = np.cumsum(rng.standard_normal((6, n)), axis=1)
    return {c: s * (rng.standard_normal(n) + 1e-3 * d) for c, s, d in zip(NAMES, sd, drift)}


def found_in(raw, fs, model=None):
    view = SimpleNamespace(record=None, raw=raw, fs=fs, temperature=None, model=model)
    return VIBRATION.candidates(view)


def wandering(n, fs, f, width, rng):
    """A sinusoid of amplitude 1 whose frequency is a slow normal process of sd `width` Hz."""
    pole = np.exp(-1 / (20 * fs))
    g = signal.lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(n))
    return np.sin(2 * np.pi * np.cumsum(f + width * g) / fs)


@pytest.mark.parametrize(("fs", "n", "f"), [(4.16, 12_000, 0.9), (100.0, 40_000, 21.0), (960.0, 100_000, 233.0)])  # fmt: skip
def test_a_line_on_three_channels_is_one_finding_at_any_rate(fs, n, f):
    rng = np.random.default_rng(1)
    raw = still(n, rng)
    for c, a in (("gyro_x", 4e-4), ("accel_y", 5e-3), ("accel_z", 8e-3)):
        raw[c] = raw[c] + a * np.sin(2 * np.pi * f * np.arange(n) / fs + len(c))
    (item,) = found_in(raw, fs)
    assert set(item.process.channels) == {"gyro_x", "accel_y", "accel_z"}
    assert item.process.frequency == pytest.approx(f, abs=2 * fs / n)
    amplitude = dict(zip(item.process.channels, item.process.amplitude))
    # twenty decibels over the noise of the band: its own scatter is ten per cent
    assert amplitude["accel_z"] == pytest.approx(8e-3, rel=0.25)
    assert item.process.bandwidth < 5 * fs / n and item.process.start is None


def test_a_line_that_wanders_for_a_part_of_the_record_has_its_times():
    fs, n = 50.0, 60_000
    rng = np.random.default_rng(2)
    raw, t = still(n, rng), np.arange(n) / fs
    line = wandering(n, fs, 9.3, 0.05, rng) * ((t > 300) & (t < 520))
    raw["gyro_y"] = raw["gyro_y"] + 1e-3 * line
    raw["accel_x"] = raw["accel_x"] + 1e-2 * line
    (item,) = found_in(raw, fs)
    p = item.process
    assert set(p.channels) == {"gyro_y", "accel_x"} and p.frequency == pytest.approx(9.3, abs=0.1)
    # a beginning is known to a block of a 360th of the record: 3.3 s
    assert p.start == pytest.approx(300, abs=8) and p.stop == pytest.approx(520, abs=8)
    # what it put into a channel is what was put in: the rest is white again
    rest = raw["accel_x"] - item.signal["accel_x"]
    f, power = signal.welch(rest, fs, nperseg=2048)
    near, around = np.abs(f - 9.3) < 0.15, (np.abs(f - 9.3) > 0.5) & (np.abs(f - 9.3) < 5)
    assert np.mean(power[near]) == pytest.approx(np.mean(power[around]), rel=0.15)


def test_a_comb_is_one_cause_with_its_multiples():
    fs, n = 200.0, 60_000
    rng = np.random.default_rng(3)
    raw, t = still(n, rng), np.arange(n) / fs
    for h, a in ((1, 1.0), (2, 0.6), (3, 0.0), (4, 0.5), (5, 0.4)):
        for c in ("accel_x", "accel_z"):
            raw[c] = raw[c] + 4e-3 * a * np.sin(2 * np.pi * 13.1 * h * t + h)
    (item,) = found_in(raw, fs)
    assert item.process.frequency == pytest.approx(13.1, abs=0.01)
    assert item.process.harmonics == 5
    assert item.process.ratios == pytest.approx((1.0, 0.6, 0.0, 0.5, 0.4), abs=0.15)


def test_noise_that_two_channels_share_in_a_band_is_that_band():
    fs, n = 100.0, 60_000
    rng = np.random.default_rng(4)
    raw = still(n, rng)
    band = signal.butter(4, (20, 32), "band", fs=fs, output="sos")
    shared = signal.sosfilt(band, rng.standard_normal(n))
    raw["gyro_x"] = raw["gyro_x"] + 1e-3 * shared
    raw["gyro_z"] = raw["gyro_z"] + 2e-3 * shared
    (item,) = found_in(raw, fs)
    p = item.process
    assert set(p.channels) == {"gyro_x", "gyro_z"}
    assert p.frequency - p.bandwidth / 2 == pytest.approx(20, abs=2)
    assert p.frequency + p.bandwidth / 2 == pytest.approx(32, abs=2)
    assert np.std(1e-3 * shared) * np.sqrt(2) == pytest.approx(p.amplitude[0], rel=0.3)


def test_what_is_no_vibration_is_not_named():
    rng = np.random.default_rng(5)
    fs, n = 100.0, 60_000
    raw, t = still(n, rng), np.arange(n) / fs
    raw["gyro_x"] = raw["gyro_x"] + 5e-4 * np.sin(2 * np.pi * 17 * t)  # a sinusoid of one channel
    ring = signal.lfilter([1], [1, -1.9 * np.cos(0.9), 0.9025], rng.standard_normal(n))
    raw["gyro_y"] = raw["gyro_y"] + 5e-4 * ring  # a resonance of one channel
    raw["accel_y"][n // 2 :] *= 1.5  # louder, everywhere
    white = rng.standard_normal(n)  # shared over the whole spectrum
    raw["accel_x"], raw["accel_z"] = raw["accel_x"] + 5e-3 * white, raw["accel_z"] + 1e-2 * white
    smooth = signal.butter(2, 20, fs=fs, output="sos")
    raw["gyro_z"] = signal.sosfilt(smooth, raw["gyro_z"])
    assert found_in(raw, fs) == []


@pytest.mark.parametrize("n", [60_000, 120_000])
def test_what_a_window_leaks_into_a_stop_band_is_no_vibration(n):
    """A hundred decibels below the noise nothing is left but the sidelobes of the window."""
    fs, cutoff = 50.0, 3.2
    f = np.pi * np.arange(n // 2 + 1) / n
    gain = 1 / np.sqrt(1 + (np.tan(f) / np.tan(np.pi * cutoff / fs)) ** 8)  # fourth order
    for seed in (1, 2):
        x = np.random.default_rng(seed).standard_normal(n)
        x = np.fft.irfft(np.fft.rfft(x) * gain, n)
        assert found_in({"accel_x": x}, fs) == []


def test_a_band_drawn_anew_has_the_level_beside_it():
    fs, n = 100.0, 120_000
    rng = np.random.default_rng(6)
    x = rng.standard_normal(n) + 3 * wandering(n, fs, 30.0, 0.1, rng)
    calm = quietened(x, fs, [(29.3, 30.7)], rng)
    f, power = signal.welch(calm, fs, nperseg=1024)
    inside = (f > 28) & (f < 32)
    # one-sided 2/fs; 200 segments and 40 ordinates: two per cent, and as much at the two edges
    assert np.mean(power[inside]) == pytest.approx(2 / fs, rel=0.05)
    part = quietened(x, fs, [(29.3, 30.7)], rng, start=300.0, stop=600.0)
    assert np.array_equal(part[: int(290 * fs)], x[: int(290 * fs)])


def test_the_skirt_of_a_strong_line_is_no_second_vibration():
    fs, n, rng = 100.0, 20_000, np.random.default_rng(0)
    names, sizes = ("gyro_x", "accel_y", "accel_z"), (1.5, 2.0, 4.0)
    line = Vibration(frequency=23.4, amplitude=sizes, bandwidth=0.07, channels=names)
    on = line.on(n, fs, rng)
    raw = {c: rng.standard_normal(n) + on[c] for c in names}
    (found,), _ = record_vibrations.vibrations(None, raw, fs, None, None)
    assert found.process.frequency == pytest.approx(23.4, abs=0.07)
    ((low, high),) = found.bands
    assert low < 23.3 and high > 23.5
    # a band of its own stays beside a line
    band = Vibration(frequency=23.8, amplitude=(1.0, 1.5, 2.0), bandwidth=3.0, channels=names)
    more = band.on(n, fs, rng)
    found, _ = record_vibrations.vibrations(
        None, {c: raw[c] + more[c] for c in names}, fs, None, None
    )
    assert any(f.process.bandwidth > 1.0 for f in found)


def test_a_tone_that_fades_on_one_channel_has_no_name_and_is_taken_out():
    rng = np.random.default_rng(9)
    n, fs = 30_000, 50.0
    t = np.arange(n) / fs
    raw = still(n, rng)
    raw["gyro_y"] = raw["gyro_y"] + 2e-3 * np.exp(-t / 150) * np.sin(2 * np.pi * 8.3 * t)
    named, left = record_vibrations.parted(found_in(raw, fs))
    assert named == [] and list(left) == ["gyro_y"]
    assert "tone at 8.3 Hz" in left["gyro_y"] and "rises and falls" in left["gyro_y"]


def test_the_hum_of_the_mains_on_one_channel_is_one_cause():
    rng = np.random.default_rng(10)
    n, fs = 60_000, 500.0
    t = np.arange(n) / fs
    raw = still(n, rng)
    mains, other = raw["gyro_z"], raw["gyro_x"]
    for k in (1, 2, 3):
        mains = mains + 3e-4 * np.sin(2 * np.pi * 50 * k * t + k)
        other = other + 3e-4 * np.sin(2 * np.pi * 37 * k * t + k)
    (item,) = found_in({**raw, "gyro_z": mains}, fs)
    assert item.process.channels == ("gyro_z",) and item.process.harmonics == 3
    # of any other frequency it is a periodic signal that has no name
    assert found_in({**raw, "gyro_x": other}, fs) == []


def test_a_band_that_comes_in_bursts_is_said_to():
    """Steps on a floor: every twenty seconds one for a second, on two channels."""
    rng = np.random.default_rng(12)
    n, fs = 40_000, 50.0
    band = signal.sosfilt(
        signal.butter(4, [14, 20], "band", fs=fs, output="sos"), rng.standard_normal(n)
    )
    raw = still(n, rng)
    for loud, words in (
        (np.ones(n), ""),
        (4.0 * (np.arange(n) / fs % 20 < 1), "in bursts, half of it"),
    ):
        felt = {c: raw[c] + 2e-3 * loud * band for c in ("gyro_x", "gyro_y")}
        (item,) = [i for i in found_in({**raw, **felt}, fs) if i.process.band]
        assert (words in item.evidence) if words else item.evidence == ""


def test_a_filter_that_is_switched_on_in_the_middle_shakes_nothing():
    """The fast end is there in the first half only, on all channels: pieces of it were vibrations
    that end at 150 s.
    """
    rng, n, fs = np.random.default_rng(12), 30_000, 100.0
    sos = signal.butter(2, 15.0, fs=fs, output="sos")
    raw = {}
    for c in ("gyro_x", "gyro_y", "accel_x"):
        x = rng.standard_normal(n)
        raw[c] = np.r_[x[: n // 2], signal.sosfilt(sos, x)[n // 2 :]]
    assert not found_in(raw, fs)


def test_each_channel_gets_the_lines_that_it_feels():
    fs, n, f = 100.0, 20_000, 13.1
    rng = np.random.default_rng(11)
    raw, t = still(n, rng), np.arange(n) / fs
    noise = {"gyro_z": 2e-3, "accel_x": 1e-2, "accel_y": 1e-2, "accel_z": 2e-2}
    felt = {
        "gyro_z": (0.0, 2e-3),
        "accel_x": (9e-3, 5e-3),
        "accel_y": (8e-3, 0.0),
        "accel_z": (0.0, 14e-3),
    }
    for c, own in felt.items():
        for h, a in enumerate(own, 1):
            raw[c] = raw[c] + a * np.sin(2 * np.pi * h * (f * t + rng.random()))
    found = found_in(raw, fs)
    assert len(found) == 2 and all(f"{f}" in item.where for item in found)
    total = {c: np.zeros(n) for c in felt}
    for item in found:
        for c, x in item.process.on(n, fs, rng).items():
            total[c] += x
    for c, own in felt.items():
        own_noise = 4 * noise[c] ** 2 / n  # in one ordinate, of a squared amplitude
        for h, a in enumerate(own, 1):
            power = np.abs(2 * np.mean(total[c] * np.exp(-2j * np.pi * h * f * t))) ** 2
            # three standard deviations of what the noise adds to a line
            slack = 3 * np.sqrt(2 * a**2 * own_noise) + 10 * own_noise
            assert power == pytest.approx(a**2, abs=slack), (c, h)
