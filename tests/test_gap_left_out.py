"""What a tilt parts from the stretch that the model is of is looked at, too."""

import numpy as np

from imu_lib import gap
from imu_lib.record import Record

FS, N, G, TILTED = 50.0, 11_500, 9.80665, 130.0


def tilted(seed):
    """An accelerometer that is tilted by 0.2 rad."""
    rng, t = np.random.default_rng(seed), np.arange(N) / FS
    angle = 0.2 * (t > TILTED)
    raw = {"accel_x": G * np.sin(angle), "accel_y": np.zeros(N), "accel_z": G * np.cos(angle)}
    return {c: x + 5e-3 * rng.standard_normal(N) for c, x in raw.items()}, t, rng


def test_a_vibration_and_a_louder_noise_behind_a_tilt_are_told():
    raw, t, rng = tilted(3)
    phase = 2 * np.pi * 12.0 * t + np.cumsum(0.12 * rng.standard_normal(N))
    raw["accel_x"] += 4e-3 * np.sin(phase) * ((t > 165) & (t < 205))
    raw["accel_y"] += 5e-3 * np.sin(phase + 1.0) * ((t > 165) & (t < 205))
    raw["accel_z"] += 6e-3 * rng.standard_normal(N) * (t > 190)
    found = gap.close(Record(raw, FS), simulations=0, jobs=1)
    assert found.stretch[1] < TILTED
    shaking = [s for s in found.record_steps if s.effect == "vibration"]
    assert len(shaking) == 1
    p = shaking[0].parameters
    assert abs(p["frequency"] - 12.0) < 0.3 and abs(p["from"] - 165) < 5 and abs(p["to"] - 205) < 5
    assert "noise_level_change on accel_z" in found.record_unexplained
    assert any(v.frequency == p["frequency"] for v in found.model.record if v.name == "vibration")


def test_a_calm_stretch_behind_a_tilt_adds_nothing():
    found = gap.close(Record(tilted(4)[0], FS), simulations=0, jobs=1)
    # a turn within one sample is a knock as well
    assert {s.effect for s in found.record_steps} - {"disturbance"} == {"tilt"}
    assert found.record_unexplained is None
