"""What is hidden in one student's record: a sensor of their own, and effects strong enough to be
found.

Strengths are drawn in units of what the record can show (its noise, its length), so that every
record is as hard as the next one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.model import Model
from imu_lib.record import CHANNELS, Record
from imu_lib.units import DEG_PER_HOUR, DEG_PER_SQRT_HOUR, MILLI_G, MPS_PER_SQRT_HOUR

LEAST, MOST = 2, 3  # effects in a record


@dataclass(frozen=True)
class Case:
    """One student's record.

    base : the model that the student is given; truth : with the hidden effects;
    hidden : (channel, effect, parameters) of each, SI; record : drawn from the truth.
    """

    base: Model
    truth: Model
    hidden: tuple[tuple[str, str, dict], ...]
    record: Record


def draw(rng: np.random.Generator, *, minutes: float = 30.0, rate: float = 50.0) -> Case:
    """A sensor with two or three hidden effects, each on a channel of its own.

    Parameters
    ----------
    rng : numpy.random.Generator
    minutes : float
        Length of the record.
    rate : float, Hz
    """
    base = {c: _base(c, rng) for c in CHANNELS}
    count = int(rng.integers(LEAST, MOST + 1))
    places = [CHANNELS[i] for i in rng.choice(len(CHANNELS), count, replace=False)]
    kinds = [list(EFFECTS)[i] for i in rng.choice(len(EFFECTS), count, replace=False)]
    hidden = []
    for channel, kind in zip(places, kinds):
        white, markov = base[channel]
        scale = Scale(white["N"] * np.sqrt(rate), markov["sigma"], 60.0 * minutes, rate)
        parameters = {k: rounded(v) for k, v in EFFECTS[kind](scale, rng).items()}
        hidden.append((channel, kind, parameters))
    grown = {c: [*base[c]] for c in CHANNELS}
    for channel, kind, parameters in hidden:
        grown[channel].append({"process": kind, **parameters})
    truth = Model.from_json({**grown, "rate": rate})
    record = truth.simulate_record(round(60.0 * minutes * rate), rate, rng)
    return Case(Model.from_json({**base, "rate": rate}), truth, tuple(hidden), record)


def _base(channel: str, rng) -> list[dict]:
    """White noise and a Gauss-Markov process, as low-cost sensors have them."""
    gyro = channel.startswith("gyro")
    white = rng.uniform(0.15, 0.8) * DEG_PER_SQRT_HOUR if gyro else rng.uniform(0.03, 0.12)
    sigma = rng.uniform(5.0, 15.0) * DEG_PER_HOUR if gyro else rng.uniform(0.02, 0.08) * MILLI_G
    return [
        {"process": "white_noise", "N": rounded(white if gyro else white * MPS_PER_SQRT_HOUR)},
        {
            "process": "gauss_markov",
            "sigma": rounded(sigma),
            "correlation_time": rounded(rng.uniform(60.0, 200.0)),
        },
    ]


@dataclass(frozen=True)
class Scale:
    """What a record can show: standard deviation of a sample and of the slow noise (signal unit),
    length (s) and rate (Hz).
    """

    sample: float
    slow: float
    length: float
    rate: float

    @property
    def block(self) -> float:
        """Standard deviation of the mean over a tenth of the record."""
        return float(np.hypot(self.slow, self.sample / np.sqrt(0.1 * self.length * self.rate)))


def _sign(rng) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _sinusoid(s: Scale, rng) -> dict:
    gain = rng.uniform(60.0, 300.0)  # of the log-likelihood, A² n / 4 sd²
    amplitude = s.sample * np.sqrt(4.0 * gain / (s.length * s.rate))
    return {"amplitude": amplitude, "frequency": rng.uniform(0.02, 0.45) * s.rate}


def _step(s: Scale, rng) -> dict:
    return {
        "amplitude": _sign(rng) * rng.uniform(5.0, 10.0) * s.block,
        "time": rng.uniform(0.25, 0.75) * s.length,
    }


def _ramp(s: Scale, rng) -> dict:
    return {"R": _sign(rng) * rng.uniform(10.0, 20.0) * s.block / s.length}


def _walk(s: Scale, rng) -> dict:
    return {"K": rng.uniform(8.0, 15.0) * s.block / np.sqrt(s.length)}


def _warm_up(s: Scale, rng) -> dict:
    return {
        "amplitude": _sign(rng) * rng.uniform(10.0, 20.0) * s.block,
        "time_constant": rng.uniform(0.05, 0.15) * s.length,
    }


def _resolution(s: Scale, rng) -> dict:
    return {"lsb": rng.uniform(0.6, 2.0) * s.sample}


def _level(s: Scale, rng) -> dict:
    ratio = rng.uniform(1.3, 2.0)
    return {
        "ratio": ratio if rng.random() < 0.5 else 1.0 / ratio,
        "time": rng.uniform(0.3, 0.7) * s.length,
    }


def _spikes(s: Scale, rng) -> dict:
    return {"rate": rng.uniform(0.05, 0.3), "scale": rng.uniform(10.0, 25.0) * s.sample}


def _telegraph(s: Scale, rng) -> dict:
    return {
        "amplitude": rng.uniform(0.6, 1.2) * s.sample + 4.0 * s.slow,
        "rate": rng.uniform(0.02, 0.1),
    }


def _saturation(s: Scale, rng) -> dict:
    return {"limit": rng.uniform(1.3, 2.2) * s.sample}


#: Effect -> its parameters, drawn for a record of this scale.
EFFECTS = {
    "sinusoid": _sinusoid,
    "step": _step,
    "ramp": _ramp,
    "random_walk": _walk,
    "warm_up": _warm_up,
    "resolution": _resolution,
    "noise_level_change": _level,
    "spikes": _spikes,
    "telegraph": _telegraph,
    "saturation": _saturation,
}


def rounded(value) -> float:
    """Four significant digits: a truth that can be written on a sheet."""
    return float(f"{value:.4g}")
