"""Vibration, heavy tails, a level that wanders, a temperature that lags, a clock that is off."""

import json

import numpy as np
import pytest
from scipy.signal import coherence, welch
from scipy.stats import kstest, t

from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.processes import (
    GaussMarkov,
    HeavyTails,
    LowPass,
    RateError,
    Sum,
    Temperature,
    Vibration,
    WanderingLevel,
    WhiteNoise,
    from_json,
)

FS = 100.0
TWO = ("gyro_x", "accel_z")


def vibration(**more):
    given = {"frequency": 13.0, "amplitude": (2e-3, 0.1), "channels": TWO, **more}
    return Vibration(**given)


@pytest.mark.parametrize("bandwidth", [0.0, 0.5, 6.0])
def test_a_vibration_has_its_power_at_its_frequency_on_each_channel(bandwidth):
    x = vibration(bandwidth=bandwidth).on(200_000, FS, np.random.default_rng(1))
    for name, amplitude in zip(TWO, (2e-3, 0.1)):
        f, p = welch(x[name], FS, nperseg=4096)
        assert f[np.argmax(p)] == pytest.approx(13.0, abs=max(0.05, bandwidth / 2))
        # half of the power of a Lorentzian line, nine tenths of a flat band with steep sides, lies
        # within its width at half height
        near = np.abs(f - 13.0) <= max(bandwidth / 2, 0.1)
        share = np.sum(p[near]) / np.sum(p)
        assert share == pytest.approx({0.0: 1.0, 0.5: 0.5, 6.0: 0.9}[bandwidth], abs=0.06)
        assert np.var(x[name]) == pytest.approx(
            amplitude**2 / 2, rel=0.05
        )  # 2000 correlation times
    _, c = coherence(x["gyro_x"], x["accel_z"], FS, nperseg=1024)
    assert c[int(13.0 / FS * 1024)] > 0.95


@pytest.mark.parametrize("bandwidth", [0.8, 6.0])
def test_a_measured_profile_is_the_spectrum_of_a_line_and_of_a_band(bandwidth):
    """A line keeps its amplitude, and its frequency takes its time; a band is normal noise."""
    at, density = (11.0, 12.5, 13.5, 17.0), (0.0, 1.0, 0.4, 0.0)
    v = vibration(bandwidth=bandwidth, profile_frequency=at, profile=density)
    assert from_json(json.loads(json.dumps(v.to_json())), on_record=True) == v
    x = v.on(200_000, FS, np.random.default_rng(5))["accel_z"]
    f, p = welch(x, FS, nperseg=1024)
    inside = (f > 11.2) & (f < 16.8)
    expected = np.interp(f, at, density)
    wrong = p[inside] / p.sum() - expected[inside] / expected.sum()
    # 200 s have some 500 frequencies of the line, and 190 segments of the band
    assert np.abs(wrong).max() < 0.15 * (expected / expected.sum()).max()
    assert np.var(x) == pytest.approx(0.005, rel=0.05)
    assert np.mean(x**4) / np.var(x) ** 2 == pytest.approx(3.0 if v.band else 1.5, abs=0.15)
    with pytest.raises(InputError, match="must rise"):
        vibration(profile_frequency=(2.0, 1.0), profile=(1.0, 1.0))


def test_a_forest_of_lines_is_drawn_at_once():
    rng = np.random.default_rng(6)
    lines = np.sort(rng.choice(np.arange(1, 400), 60, replace=False)) / 10.0 + 0.013
    v = vibration(harmonics=60, lines=tuple(lines), ratios=tuple(rng.uniform(0.2, 1.0, 60)))
    x = v.on(3000, FS, rng)["gyro_x"]
    shapes = np.exp(2j * np.pi * lines * np.arange(3000)[:, None] / FS)
    found, *_ = np.linalg.lstsq(np.c_[shapes.real, shapes.imag], x, rcond=None)
    # each is off by a sixteenth of an ordinate at the most, which turns it by an eighth of pi
    assert np.hypot(*found.reshape(2, 60)) == pytest.approx(2e-3 * v.shape, rel=0.1)


def test_harmonics_are_multiples_and_a_vibration_has_a_beginning_and_an_end():
    v = vibration(harmonics=3, start=20.0, stop=60.0, ratios=(1.0, 0.0, 0.5))
    x = v.on(10_000, FS, np.random.default_rng(2))["gyro_x"]
    assert not x[: int(19.9 * FS)].any() and not x[int(60.1 * FS) :].any()
    part = x[2000:6000]
    line = np.abs(np.fft.rfft(part)) / len(part) * 2
    assert line[np.rint(np.array([13, 26, 39]) * 40).astype(int)] == pytest.approx(
        [2e-3, 0.0, 1e-3], abs=1e-5
    )


def test_a_vibration_in_the_model_file_says_from_and_to():
    content = {
        "gyro_x": [{"process": "white_noise", "N": 1e-5}],
        "accel_z": [{"process": "white_noise", "N": 1e-5}],
        "record": [
            {"process": "vibration", "frequency": 13.0, "amplitude": [2e-3, 0.1], "bandwidth": 0.0,
             "harmonics": 2, "channels": list(TWO), "from": 10.0, "to": 30.0}
        ],
    }  # fmt: skip
    model = Model.from_json(content)
    assert json.loads(json.dumps(model.to_json()))["record"] == content["record"]
    x = model.simulate(5000, FS, np.random.default_rng(0))
    assert np.std(x["accel_z"][1000:3000]) == pytest.approx(0.1 * np.sqrt(0.625), rel=0.01)
    assert np.std(x["accel_z"][3100:]) < 1e-3
    with pytest.raises(InputError, match="amplitude"):
        from_json({**content["record"][0], "amplitude": [1.0, 2.0, 3.0]}, on_record=True)


def test_heavy_tails_are_students_and_keep_the_spectrum():
    model = Sum((WhiteNoise(0.01),), (HeavyTails(5.0),))
    x = model.simulate(100_000, FS, np.random.default_rng(3))
    assert kstest(x / np.sqrt(3 / 5) / 0.1, t(5).cdf).pvalue > 1e-3
    assert model.psd(1.0, FS) == WhiteNoise(0.01).psd(1.0, FS)
    assert np.var(x) == pytest.approx(0.01, rel=0.05)  # its kurtosis is 9: 3 sd are 0.03
    with pytest.raises(InputError, match="above 2"):
        HeavyTails(2.0)


@pytest.mark.parametrize("lean", [0.3, -0.6])
def test_tails_that_lean_have_the_distribution_that_is_fitted(lean):
    tails = HeavyTails(9.0, lean)
    x = Sum((WhiteNoise(0.01),), (tails,)).simulate(100_000, FS, np.random.default_rng(7)) / 0.1
    assert kstest(x, tails.below).pvalue > 1e-3
    assert np.mean(x) == pytest.approx(0.0, abs=0.015) and np.var(x) == pytest.approx(1.0, rel=0.05)
    assert np.sign(np.mean(x**3)) == np.sign(lean)
    u = np.linspace(-20, 20, 4001)
    density = np.exp(tails.log_density(u))
    below = np.cumsum(density) * (u[1] - u[0])
    assert below == pytest.approx(np.exp(tails.log_tails(u)[0]), abs=0.01)
    with pytest.raises(InputError, match="above 4"):
        HeavyTails(3.0, lean)


@pytest.mark.parametrize("low_pass", [LowPass(cutoff=25.0, order=2, rate=10 * FS), LowPass(taps=3)])
def test_heavy_tails_behind_a_filter_are_those_of_the_records_samples(low_pass):
    """Of an oversampled filter, too: its spectrum is the model's, and whitened it is Student's."""
    model = Sum((WhiteNoise(0.01),), (low_pass, HeavyTails(5.0)))
    x = model.simulate(100_000, FS, np.random.default_rng(3))
    f, power = welch(x, FS, nperseg=500)
    band = (f > 1) & (f < 0.3 * FS)
    assert np.mean(power[band] / model.psd(f[band], FS)) == pytest.approx(1.0, abs=0.05)
    z = np.fft.rfft(x)[1:-1]
    f = np.fft.rfftfreq(len(x), 1 / FS)[1:-1]
    seen = model.psd(f, FS) > 1e-4 * model.psd(1.0, FS)  # not the null of three taps
    white = np.fft.irfft(np.r_[0, np.where(seen, z / np.sqrt(model.psd(f, FS) * FS / 2), 0), 0])
    assert kstest(white / np.sqrt(3 / 5), t(5).cdf).pvalue > 1e-3


def test_the_level_wanders_as_a_gauss_markov_process_of_its_logarithm():
    level = np.log(WanderingLevel(0.35, 2.0).draw(400_000, FS, np.random.default_rng(4)))
    assert np.std(level) == pytest.approx(0.35, rel=0.1)  # 2000 correlation times
    lag = np.corrcoef(level[:-200], level[200:])[0, 1]
    assert lag == pytest.approx(np.exp(-1), abs=0.06)
    model = Sum((WhiteNoise(0.01), GaussMarkov(1.0, 100.0)), (WanderingLevel(0.35, 2.0),))
    x = Sum((WhiteNoise(0.01),), model.stages).simulate(400_000, FS, np.random.default_rng(5))
    assert np.mean(x**2) == pytest.approx(0.01, rel=0.1)
    assert model.psd(1.0, FS) == Sum(model.terms).psd(1.0, FS)


def test_a_temperature_with_lag_and_curvature():
    time = np.arange(20_000) / 10.0
    rise = 25.0 + 0.01 * time
    x = Temperature(slope=2.0, reference=25.0, curvature=0.5, lag=120.0).mean(time, rise)
    # behind a first-order delay a ramp lags by rate * lag (1 - exp(-t / lag))
    above = 0.01 * (time - 120.0 * (1 - np.exp(-time / 120.0)))
    assert x == pytest.approx(2.0 * above + 0.5 * above**2, abs=1e-9)
    # on block means the delay is the same, once the first block is eight lags behind
    blocks = Temperature(slope=2.0, reference=25.0, lag=120.0).mean(time[50::100], rise[50::100])
    assert blocks[100:] == pytest.approx(2 * above[50::100][100:], abs=2e-3)


def test_a_temperature_with_play_takes_another_way_down_than_up():
    time = np.arange(401.0)
    rise = 20.0 + np.r_[np.linspace(0, 10, 201), np.linspace(10, 0, 201)[1:]]
    x = Temperature(slope=2.0, reference=20.0, play=4.0).mean(time, rise)
    up, down = x[:201], x[200:]
    assert up == pytest.approx(2.0 * np.maximum(rise[:201] - 22.0, 0.0))
    assert down == pytest.approx(2.0 * np.minimum(8.0, rise[200:] - 18.0))


def test_a_clock_that_is_off_moves_every_frequency():
    model = Model({"gyro_x": Sum((WhiteNoise(1e-6),))}, record=(
        Vibration(frequency=20.0, amplitude=(1.0,), channels=("gyro_x",)), RateError(1.05)))  # fmt: skip
    x = model.simulate_record(20_000, FS, np.random.default_rng(6)).channels["gyro_x"]
    line = np.argmax(np.abs(np.fft.rfft(x))) * FS / len(x)
    assert line == pytest.approx(20.0 / 1.05, abs=FS / len(x))
    assert from_json({"process": "rate_error", "ratio": 1.05}, on_record=True) == RateError(1.05)
