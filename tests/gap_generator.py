"""Hides effects in synthetic static records, for the blind tests and benchmarks of `imu_lib.gap`.

Plain numpy: nothing here comes from imu_lib, so that an error in its simulators cannot hide
itself. Every case carries the expected log-likelihood gain (`gain`) of each hidden effect at its
true parameters, from closed forms of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from gap_hidden import KNOWN, RECORD, STAGES, hide, hide_record
from gap_noises import noise
from gap_unknowns import UNKNOWN, unknown

__all__ = ["CHANNELS", "KNOWN", "RECORD", "UNKNOWN", "Case", "make", "noise", "unknown"]

CHANNELS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


@dataclass
class Case:
    """A record, its base model and what is hidden in it."""

    seed: int
    fs: float
    channels: dict
    base: dict
    truths: list = field(default_factory=list)
    time: np.ndarray | None = None
    temperature: np.ndarray | None = None

    def save(self, path):
        """The record as the contract's npz."""
        keys = dict(self.channels)
        keys["time"] = (
            np.arange(len(next(iter(keys.values())))) / self.fs if self.time is None else self.time
        )
        if self.temperature is not None:
            keys["temperature"] = self.temperature
        np.savez(path, **keys)


# -- base models ----------------------------------------------------------------------------------


def _base(channel, rng, kind):
    N = 10 ** rng.uniform(-4.3, -3.2) * (1 if channel.startswith("gyro") else 5)
    out = [{"process": "white_noise", "N": N}]
    if "gm" in kind:
        tc = 10 ** rng.uniform(1.5, 2.8)
        out.append(
            {
                "process": "gauss_markov",
                "sigma": N / np.sqrt(tc) * rng.uniform(0.7, 3),
                "correlation_time": tc,
            }
        )
    if "walk" in kind:
        out.append({"process": "random_walk", "K": N / 10 ** rng.uniform(2, 2.8)})
    if "flicker" in kind:
        out.append({"process": "flicker", "B": N * 10 ** rng.uniform(-1.3, -0.6)})
    return out


def make(
    seed,
    effects=(),
    *,
    duration=3600.0,
    fs=100.0,
    channels=CHANNELS,
    base=None,
    gain=None,
    with_temperature=None,
):
    """A case: `effects` hidden one after the other in random channels (two in one case share a
    channel half the time).
    """
    rng = np.random.default_rng(seed)
    n = int(duration * fs)
    t = np.arange(n) / fs
    temperature = None
    if with_temperature or "temperature" in effects or rng.random() < 0.3:
        temperature = 25 + rng.uniform(2, 10) * (1 - np.exp(-t / rng.uniform(300, 1500)))
        temperature += rng.uniform(0.2, 2) * np.sin(
            2 * np.pi * t / rng.uniform(900, 3000)
        ) + 0.02 * rng.standard_normal(n)
    x, model = {}, {}
    for c in channels:
        kind = base or rng.choice(["gm", "gm", "walk", "gm+walk", "flicker", "white"])
        model[c] = _base(c, rng, kind)
        x[c] = sum(noise(e, n, fs, rng) for e in model[c]) + (
            -9.8 if c == "accel_z" else rng.normal() * 0.01
        )
    case = Case(seed, fs, x, model, temperature=temperature)
    # stages of the output come after what happens before them, as in an instrument: noise changes
    # its level in the sensor
    chain = (
        "noise_level_change",
        *STAGES,
        "time_gaps",
        "jitter",
    )  # the clock last, noise in common before the electronics
    rounded = (
        "quantization" in effects and rng.random() < 0.5
    )  # an angle is rounded after all that happens to the rate but spikes
    place = {e: i + 1 for i, e in enumerate(chain)} | (
        {"quantization": chain.index("spikes") + 0.5} if rounded else {}
    )
    order = sorted(effects, key=lambda e: place.get(e, 0))
    channel = rng.choice(list(x))
    for e in order:
        if rng.random() < 0.5:
            channel = rng.choice(list(x))
        white = model[channel][0]["N"] * np.sqrt(fs)
        if e in UNKNOWN:
            x[channel] = unknown(e, x[channel], fs, rng, white)
            case.truths.append(
                {"effect": "unknown", "kind": e, "channel": str(channel), "gain": 1e3}
            )
        elif e in RECORD:
            hide_record(e, case, rng)
        else:
            x[channel], truth = hide(
                e, x[channel], model[channel], fs, rng, temperature, gain, rounded
            )
            case.truths.append({**truth, "channel": str(channel)})
    _see(case)
    return case


def _see(case):
    """Every gain is that of the effect in the record as it is: the other noises hidden in its
    channel are there too.
    """
    noises = [
        (
            {t["channel"]}
            if t["channel"] != "record"
            else set(t["parameters"].get("channels", [])),
            t,
            t.pop("noise", None),
        )
        for t in case.truths
    ]
    for truth in case.truths:
        seen = truth.pop("seen", None)
        others = [
            noise
            for channels, t, noise in noises
            if t is not truth and noise and truth["channel"] in channels
        ]
        if seen and others:
            truth["gain"] = float(seen(case.base[truth["channel"]] + others))
