"""Jumps of several accelerometers at one time are a tilt, and the verdict tells what jumped."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from imu_lib.gap import close
from imu_lib.gap.channel import ChannelResult
from imu_lib.gap.sentences import data_faults
from imu_lib.gap.steps import Step
from imu_lib.gap.table import on_channel
from imu_lib.gap.tilt_jumps import as_tilts
from imu_lib.processes import Sum
from imu_lib.record import Record

FS, N, G = 50.0, 20_000, 9.80665


def step(effect, sure=0.99, **parameters):
    return Step(effect, parameters, {}, "", sure, {"effect": "none", "confidence": 0.0}, [])


def jumped(gyro_noise, *, turn=True, along=0.0, takes=0.0):
    """(results, what was prepared) of a unit that was tilted twice by some tenths of a milliradian,
    each time within `takes` s.
    """
    rng, t = np.random.default_rng(2), np.arange(N) / FS
    raw = {f"gyro_{a}": gyro_noise * rng.standard_normal(N) for a in "xyz"}
    force = np.array([0.1, -0.2, -G])
    raw |= {f"accel_{a}": f + 5e-3 * rng.standard_normal(N) for a, f in zip("xyz", force)}
    steps = {f"accel_{a}": [] for a in "xyz"}
    for at, angles in ((130.0, (2e-4, 1.5e-4, 0)), (270.0, (-1.6e-4, 2e-4, 0))):
        angles = np.array(angles) * (5.0 if takes else 1.0)  # a slow one has to be larger
        change = -np.cross(angles, force) + along * np.array([0, 0, 1.0])
        for a, c, w in zip("xyz", change, angles):
            if abs(c) > 1e-4:
                raw[f"accel_{a}"] += np.clip((t - at) / max(takes, 1e-9), 0.0, 1.0) * c
                for k in range(2 if takes else 1):
                    share, when = (0.5, at + (0.25 + 0.5 * k) * takes) if takes else (1.0, at + 0.3)
                    steps[f"accel_{a}"].append(step("step", amplitude=share * c, time=when))
            turning = (t > at) & (t < at + takes) if takes else np.abs(t - at) < 0.5
            raw[f"gyro_{a}"] += turn * turning * w / max(takes, 1.0)
    results = {c: ChannelResult(c, Sum(()), Sum(()), s, [], None) for c, s in steps.items()}
    return results, SimpleNamespace(raw=raw, fs=FS, ready=SimpleNamespace(start=10.0))


@pytest.mark.parametrize("gyro_noise, sure", [(2e-2, 0.8), (2e-5, 0.95)])
def test_two_small_tilts_are_two_tilts_and_no_steps(gyro_noise, sure):
    results, tilts = as_tilts(*jumped(gyro_noise))
    assert [s.effect for r in results.values() for s in r.steps] == []
    assert [s.parameters["time"] for s in tilts] == pytest.approx([140.3, 280.3])
    assert tilts[0].parameters["angles"] == pytest.approx([2e-4, 1.5e-4, 0.0], abs=1e-5)
    assert all(s.confidence == pytest.approx(sure) for s in tilts)
    assert "moved at 140, 280 s" in data_faults.sentence([("record", s) for s in tilts], 0.9)


@pytest.mark.parametrize("gyro_noise, sure", [(2e-2, 0.8), (2e-5, 0.95)])
def test_a_tilt_of_some_seconds_is_one_tilt_however_many_steps_it_was_told_as(gyro_noise, sure):
    results, tilts = as_tilts(*jumped(gyro_noise, takes=12.0))
    assert [s.effect for r in results.values() for s in r.steps] == []
    assert [s.parameters["time"] for s in tilts] == pytest.approx([146.0, 286.0], abs=1.5)
    assert [s.confidence for s in tilts] == pytest.approx([sure] * 2)
    assert "change together from 1" in tilts[0].where


def test_a_slow_change_of_one_axis_is_as_likely_a_tilt():
    results, about = jumped(2e-2, takes=12.0)
    one = replace(results["accel_x"], steps=results["accel_x"].steps)
    alone = {c: one if c == "accel_x" else replace(r, steps=[]) for c, r in results.items()}
    out, tilts = as_tilts(alone, about)
    steps = out["accel_x"].steps
    assert tilts == [] and steps and all(s.confidence == 0.5 for s in steps)
    assert all("tilt" in s.indistinguishable for s in steps)


def test_what_gyros_or_gravity_deny_stays_a_step():
    for made in (jumped(2e-5, turn=False), jumped(2e-2, along=5e-3)):
        results, tilts = as_tilts(*made)
        assert tilts == [] and sum(len(r.steps) for r in results.values()) >= 4


def test_jumps_are_told_and_not_denied():
    steps = [
        ("accel_x", replace(step("step", amplitude=0.01, time=70.0), indistinguishable=["tilt"])),
        ("gyro_y", step("telegraph", amplitude=1e-3, rate=0.05)),
    ]
    text = data_faults.sentence(steps, 0.9)
    assert "jumped on accel_x at 70 s (or it was tilted by 1 mrad)" in text
    assert "between two values on gyro_y, 3 times a minute" in text and "nobody" not in text


def test_the_gap_after_a_slow_tilt_is_measured_with_its_course():
    """Gravity goes over from one axis to two others within 40 s, as half a cosine."""
    fs, n = 25.0, 6000
    rng, t = np.random.default_rng(5), np.arange(n) / fs
    done = 0.5 - 0.5 * np.cos(np.pi * np.clip((t - 110.0) / 40.0, 0.0, 1.0))
    change = {"accel_x": 8e-3, "accel_y": -5e-3, "accel_z": 0.0}
    raw = {c: a * done + 5e-3 * rng.standard_normal(n) for c, a in change.items()}
    raw["accel_z"] += G
    found = close(Record(raw, fs), simulations=12, jobs=1)
    assert [s.effect for s in found.record_steps] == ["tilt"]
    for c in ("accel_x", "accel_y"):
        assert found.channels[c].before.value > 2.0 and found.channels[c].after.value < 1.35
        assert found.channels[c].result.unexplained is None
        assert on_channel(found, c) == "on the record: tilt"
    assert on_channel(found, "accel_z") == "nothing: simulation and measurement agree"
