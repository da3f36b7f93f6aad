"""What the table holds is in the verdict, whatever it is, and nothing denies it."""

from dataclasses import replace

import numpy as np
import pytest

from imu_lib.faults import Finding
from imu_lib.gap import effects, fault_masking, fault_steps
from imu_lib.gap.channel import ChannelResult
from imu_lib.gap.effects.wandering_level import behaviour, in_short
from imu_lib.gap.found import ChannelReport, Report
from imu_lib.gap.sentences.summary import sentences
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.processes import Spikes, Sum, WhiteNoise
from imu_lib.record import Record

N, FS = 60_000, 100.0
#: Effect -> (its parameters, words of it in the verdict).
TOLD = {
    "autoregressive": ({"a": [0.5], "sigma": 1e-3, "rate": 100.0}, "autoregressive noise"),
    "common_mode": ({"N": 1e-4, "channels": ["gyro_x", "gyro_y"]}, "noise in common"),
    "dropout": ({"fraction": 0.01, "value": 0.0, "channels": ["gyro_x"]}, "drop-outs"),
    "disturbance": ({"start": 99.0, "duration": 0.3, "channels": ["gyro_x"]}, "touched or shaken at 99 s"),
    "flicker": ({"B": 1e-5}, "flicker"),
    "gauss_markov": ({"sigma": 1e-3, "correlation_time": 30.0}, "Gauss-Markov"),
    "gauss_markov_2": ({"sigma": 1e-3, "correlation_time": 30.0}, "Gauss-Markov"),
    "heavy_tails": ({"dof": 5.0}, "heavy tails"),
    "jitter": ({"sd": 1e-3}, "time stamps scatter"),
    "low_pass": ({"cutoff": 20.0, "order": 2}, "low pass"),
    "noise_level_change": ({"time": 99.0, "ratio": 2.0}, "noise"),
    "parameter_change": (
        {"process": "white_noise", "name": "N", "from": 1e-4, "to": 2e-4},
        "parameter change",
    ),
    "quantization": ({"Q": 1e-5}, "quantization"),
    "ramp": ({"R": 1e-5}, "drifts"),
    "random_walk": ({"K": 1e-5}, "random walk"),
    "resolution": ({"lsb": 1e-3}, "resolution"),
    "saturation": ({"limit": 1.0, "low": -1.0}, "clipped"),
    "sinusoid": ({"amplitude": 1e-3, "frequency": 3.0}, "sinusoid"),
    "spikes": ({"rate": 0.1, "scale": 1.0}, "thrown off"),
    "step": ({"amplitude": 1e-2, "time": 99.0}, "jumped"),
    "stuck": ({"fraction": 0.01}, "frozen"),
    "telegraph": ({"amplitude": 1e-3, "rate": 0.05}, "between two values"),
    "temperature": ({"slope": 1e-4}, "temperature"),
    "tilt": ({"time": 99.0, "angles": [1e-3, 0.0, 0.0]}, "tilted by 3.44 arcmin"),
    "time_gaps": ({"fraction": 0.01}, "missing"),
    "vibration": (
        {"frequency": 9.0, "harmonics": 1, "bandwidth": 0.0, "amplitude": [1.0], "channels": ["gyro_x"]},
        "9 Hz",
    ),  # fmt: skip
    "wandering_level": ({"sd": 0.2, "correlation_time": 9.0}, "rises and falls"),
    "warm_up": ({"amplitude": 1e-2, "time_constant": 99.0}, "warm"),
    "white_noise": ({"N": 1e-4}, "white noise"),
}  # fmt: skip
DENIED = ("Nothing is", "shows nothing", "Nothing is left without")


def step(effect, sure):
    return Step(effect, TOLD[effect][0], {}, "", sure, {}, [], gain=20.0)


def said(steps=(), of_record=(), stages=(), **more):
    """The sentences on a report of two gyros, the first with `steps`."""
    record = Record({c: np.zeros(N) for c in ("gyro_x", "gyro_y")}, FS)
    models = {"gyro_x": Sum((WhiteNoise(1e-4),), stages), "gyro_y": Sum((WhiteNoise(1e-4),))}
    results = {c: ChannelResult(c, m, m, [], [], None) for c, m in models.items()}
    results["gyro_x"] = replace(results["gyro_x"], steps=list(steps))
    model = Model(channels=models, rate=FS)
    channels = {c: ChannelReport(r) for c, r in results.items()}
    found = Report(channels, list(of_record), None, model, model, record, 1.0, False, **more)
    return sentences(found)


def test_every_effect_has_its_words_here():
    assert set(TOLD) >= set(effects.CATALOGUE) | set(fault_steps.DETECTED)


@pytest.mark.parametrize("sure", [0.55, 0.99])
@pytest.mark.parametrize("effect", sorted(TOLD))
def test_what_was_found_is_told_and_not_denied(effect, sure):
    found = step(effect, sure)
    on_record = "channels" in TOLD[effect][0] or effect in ("tilt", "jitter", "time_gaps")
    text = " ".join(said(of_record=[found]) if on_record else said([found]))
    words = TOLD[effect][1]
    assert words in text or effect.replace("_", " ") in text
    assert not any(denied in text for denied in DENIED)


def test_a_ramp_is_told_with_its_size():
    text = " ".join(said([step("ramp", 1.0)]))
    assert "a ramp (the mean drifts) on gyro_x (R " in text and "deg/h" in text


def test_the_noise_is_told_without_the_spikes():
    spiked = said([step("spikes", 1.0)], stages=(Spikes(rate=1.0, scale=1.0),))
    (sensor,) = [s for s in spiked if "gyroscopes have" in s]
    assert "have 0.344 deg/sqrt(h) of noise (spikes taken out)" in sensor


def test_the_length_told_is_that_of_the_whole_record():
    first = said(stretch=(0.0, N / FS), whole=900.0)[0]
    assert first.startswith("The record, 15 min at 100 Hz, is good from 0 to 600 s")
    assert "the other 5 min are left out (a tilt" in first
    assert "left out" not in said(stretch=(0.0, N / FS), whole=N / FS)[0]


def test_a_knock_that_is_the_pulse_of_a_tilt_is_told_once():
    def event(kind, start, stop, parameters):
        return Finding(kind, ("gyro_x",), start, stop, parameters, {}, "")

    knock = event("disturbance", 10.0, 10.3, {})
    pulse = event("disturbance", 99.5, 100.05, {})
    handling = event("disturbance", 199.0, 203.0, {})
    tilts = [event("tilt", t, t + 0.5, {}) for t in (99.8, 200.0)]
    told = fault_masking.without_turns([knock, pulse, handling, *tilts])
    assert told == [knock, handling, *tilts]


def test_a_tilt_that_may_be_jumps_is_no_fact():
    tilt = step("tilt", 0.8)
    assert "it was moved at 99 s" in " ".join(said(of_record=[tilt])).lower()
    told = " ".join(said(of_record=[replace(tilt, indistinguishable=["step"])])).lower()
    assert "may have been moved at 99 s" in told and "was moved" not in told


def test_of_doubtful_names_the_likeliest_are_told_once():
    spikes, jump = step("spikes", 0.4), step("step", 0.3)
    told = " ".join(said([spikes, jump, jump, step("stuck", 0.02)]))
    assert "In doubt: spikes on gyro_x, step on gyro_x." in told and "stuck" not in told
    many = [step(e, 0.4) for e in ("spikes", "step", "stuck", "saturation", "telegraph")]
    assert "2 more in the table" in " ".join(said(many))


def test_what_a_noise_level_does_is_said_as_it_is():
    """Grows, falls, wanders, follows the temperature."""
    time, rng = np.arange(300.0), np.random.default_rng(3)
    wave = 0.3 * np.sin(time / 20)
    grows = behaviour(0.004 * time + 0.02 * rng.standard_normal(300))
    assert in_short(grows) == "the noise grows" and "from 0.5" in grows
    assert in_short(behaviour(-0.004 * time)) == "the noise falls"
    assert in_short(behaviour(wave)) == "the noise rises and falls"
    warm = 20 + np.repeat(wave, 100)
    assert in_short(behaviour(wave, warm)) == "the noise rises and falls as the temperature does"
    assert in_short(behaviour(-wave, warm)).endswith("against the temperature")


@pytest.mark.parametrize(("share", "told"), [(0.04, False), (0.12, True)])
def test_noise_in_common_is_told_where_it_moves_the_sum_of_its_channels(share, told):
    """A standard deviation of the sum of two axes that grows by 2 % is in the table alone."""
    found = step("common_mode", 1.0)
    found = replace(found, parameters={**found.parameters, "share": share})
    assert ("noise in common" in " ".join(said(of_record=[found]))) is told
