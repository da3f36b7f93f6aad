"""A bias that follows the temperature behind a lag, along a bent characteristic."""

import numpy as np
import pytest

from imu_lib.gap.channel import analyse
from imu_lib.processes import Sum, WhiteNoise
from imu_lib.processes.temperature import behind_play

FS, N = 20.0, 60_000
WHITE = Sum((WhiteNoise(N=2e-4),))


def warming(n=N, fs=FS):
    """A room that is heated and swings."""
    t = np.arange(n) / fs
    return 22 + 14 * (1 - np.exp(-t / 700)) + 1.5 * np.sin(2 * np.pi * t / 900)


def behind(temperature, lag):
    """The temperature behind a first-order delay, by Euler's rule."""
    out = np.empty_like(temperature)
    out[0] = temperature[0]
    for k in range(1, len(out)):
        out[k] = out[k - 1] + (temperature[k] - out[k - 1]) / (FS * lag)
    return out


@pytest.mark.parametrize("base", [WHITE, None], ids=["given", "free"])
def test_a_lag_and_a_curvature_are_found_with_the_slope_at_25_degrees(base):
    rng = np.random.default_rng(1)
    room = warming()
    u = behind(room, 150.0) - 25.0
    x = 2e-4 * np.sqrt(FS) * rng.standard_normal(N) + 1e-5 * u + 3e-6 * u**2
    found = analyse("gyro_x", x, FS, base, temperature=room)
    (step,) = (s for s in found.steps if s.effect == "temperature")
    p = step.parameters
    assert p["reference"] == 25.0
    assert p["curvature"] == pytest.approx(3e-6, rel=0.25)
    # the fitted base leaves the lag little room to show
    assert p["lag"] == pytest.approx(150.0, rel=0.25 if base else 0.7)
    low, high = step.intervals["lag"]
    assert low < p["lag"] < high


def test_another_way_down_than_up_is_a_temperature_with_play():
    t = np.arange(N) / FS
    oven = 30 + 12 * np.sin(2 * np.pi * t / 1100)
    x = 2e-4 * np.sqrt(FS) * np.random.default_rng(5).standard_normal(N)
    x += 2e-5 * behind_play(oven, 6.0)
    (step,) = analyse("gyro_x", x, FS, None, temperature=oven).steps
    assert step.effect == "temperature" and step.parameters["play"] == pytest.approx(6.0, rel=0.25)


def test_a_straight_characteristic_stays_straight():
    rng = np.random.default_rng(2)
    room = warming()
    x = 2e-4 * np.sqrt(FS) * rng.standard_normal(N) + 2e-5 * (room - 25)
    (step,) = analyse("gyro_x", x, FS, WHITE, temperature=room).steps
    assert step.effect == "temperature"
    assert not {"curvature", "lag", "play"} & set(step.parameters)


def test_a_transient_beside_a_straight_characteristic_is_no_curvature():
    """Both bend as the room warms; noises that follow the sum are likelier than either alone."""
    rng = np.random.default_rng(3)
    room, t = warming(), np.arange(N) / FS
    x = 2e-4 * np.sqrt(FS) * rng.standard_normal(N) - 6e-5 * (room - 25) + 6e-4 * np.exp(-t / 250)
    found = analyse("gyro_x", x, FS, WHITE, temperature=room)
    steps = {s.effect: s for s in found.steps}
    assert set(steps) == {"temperature", "warm_up"}
    assert "curvature" not in steps["temperature"].parameters
    low, high = steps["warm_up"].intervals["time_constant"]
    assert low < 250 < high
