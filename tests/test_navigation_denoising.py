"""Wavelet levels under motion."""

import numpy as np
import pytest

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.navigation import denoising


def test_levels_trade_noise_for_motion():
    """White noise on a 0.3 Hz sine at 100 Hz: level 6 (0.78 Hz) keeps the sine, level 8 (0.2 Hz)
    removes it.
    """
    rng = np.random.default_rng(1)
    t = np.arange(2**14) / 100.0
    truth = np.sin(2 * np.pi * 0.3 * t)
    forms = ("SURE, whole record", "SURE, noise of level 1", "low-pass, whole record")
    study = denoising.level_study(truth, truth + rng.normal(0, 0.1, t.size), forms=forms)
    assert study.rms["SURE, whole record"][0] == pytest.approx(
        0.1, rel=0.03
    )  # 3 % is three deviations of 14,000 samples
    # a level halves the power of white noise: 2^(-3/2) at level three, to the 2 % that 1,800
    # coefficients leave
    assert study.noise[3] == pytest.approx(0.1 * 2**-1.5, rel=0.06)
    low_pass = study.rms["low-pass, whole record"]
    assert np.allclose(
        np.hypot(study.loss, study.noise)[:6], low_pass[:6], rtol=0.05
    )  # independent: the cross term is small
    assert low_pass[8] > 0.5 and 4 <= study.best("low-pass, whole record") <= 6
    # told the noise, SURE keeps what sticks out of it; a motion that never pauses is taken for the
    # level's own noise
    assert study.rms["SURE, noise of level 1"][8] < 0.1 < 0.5 < study.rms["SURE, whole record"][8]


def test_integration_averages_what_denoising_removes():
    """RMS after one and two integrations of white noise over T: sigma sqrt(T / fs) and that times
    T / sqrt(3).
    """
    rng = np.random.default_rng(2)
    x = rng.normal(0, 1.0, 3000 * 400)
    once = denoising.after_integration(x, 100.0, 30.0, integrals=1)
    twice = denoising.after_integration(x, 100.0, 30.0)
    assert once == pytest.approx(np.sqrt(0.3), rel=0.12)  # 400 windows: 3.5 % standard deviation
    assert twice == pytest.approx(np.sqrt(0.3) * 30 / np.sqrt(3), rel=0.12)
    with pytest.raises(ValueError, match="`duration`"):
        denoising.after_integration(x[:100], 100.0, 30.0)


def drive_with(speed, **more):
    n = len(speed)
    t = np.arange(n) / 100.0
    velocity = np.column_stack([speed, np.zeros(n), np.zeros(n)])
    return Drive(
        t,
        np.zeros((n, 3)),
        np.zeros((n, 3)),
        gnss_time=t,
        gnss_position=np.zeros((n, 3)),
        gnss_velocity=velocity,
        **more,
    )


def test_moving_and_still():
    speed = np.concatenate(
        [np.zeros(1000), np.full(3000, 10.0), np.zeros(2000), np.full(800, 10.0)]
    )
    moving, still = denoising.moving_and_still(drive_with(speed))
    assert (moving.start, moving.stop) == (1000, 4000) and (still.start, still.stop) == (4000, 6000)
    with pytest.raises(InputError, match="never stands"):
        denoising.moving_and_still(drive_with(np.full(2000, 5.0)))
