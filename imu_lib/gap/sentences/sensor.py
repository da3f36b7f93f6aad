"""What the sensor is like, in a sentence: the figures of a datasheet, of the grown model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib import units, words
from imu_lib.errors import UndefinedFormError
from imu_lib.gap.sentences import signals
from imu_lib.processes import (
    GaussMarkov,
    NoiseLevelChange,
    RandomWalk,
    Resolution,
    Sum,
    Telegraph,
    WhiteNoise,
)

if TYPE_CHECKING:
    from imu_lib.gap.found import Report
    from imu_lib.long_record.record import LongRecord
    from imu_lib.record import Record

#: Averaging times shorter than this share of the record have an Allan deviation worth the name.
REACHED = 0.1
#: Confidence from which on a filter that was found is told as the sensor's.
SURE = 0.9
#: Averaging time below which the least Allan deviation is no bias instability without flicker
#: noise, s.
SHORT = 5.0
#: Effects that the figures of noise are without, in words.
NO_NOISE = {
    "spikes": "spikes",
    "step": "steps",
    "vibration": "vibrations",
    "telegraph": "flips between two levels",
}


def of_sensor(found: Report) -> set[tuple[str, str]]:
    """(channel, effect) of what the sentence on the sensor tells."""
    return {
        (w, s.effect)
        for w, s in found.steps
        if w in found.channels
        and (
            s.effect == "resolution"
            and found.model[w].find("resolution") is not None
            or s.effect == "low_pass"
            and found.model[w].low_pass is not None
            and _filtered(found, w)
        )
    }


def _filtered(found: Report, channel: str) -> bool:
    """Whether a channel has a filter that is given, or found and sure."""
    if found.model[channel].low_pass is None:
        return False
    own = [s for s in found.channels[channel].result.steps if s.effect == "low_pass"]
    return all(s.confidence >= SURE for s in own)


def sensor(found: Report) -> str:
    """Noise, bias instability, wander, resolution and filter of each kind of sensor."""
    out = []
    for kind, name in (("gyro", "gyroscopes"), ("accel", "accelerometers")):
        channels = [c for c in found.channels if c.startswith(kind)]
        values = [_character(found.model[c], found.record) for c in channels]
        density = [v[0] for v in values if v[0]]
        if not density:
            continue
        text = f"the {name} have {_range(density, 'N', channels[0])} of noise"
        text += _changed(found, dict(zip(channels, (v[0] for v in values))))
        floor = [v[1] for v in values if v[1]]
        if floor:
            text += f", a bias instability of {_range(floor, 'B', channels[0])}"
            longest = max(v[2] for v in values if v[2])
            text += f" (at {words.seconds(longest)})"
        text += _wanders(found, channels) + _walks(found, channels)
        stages = [s for c in channels for s in found.model[c].stages]
        steps = [s.lsb for s in stages if isinstance(s, Resolution)]
        if steps:
            unit, factor = ("deg/s", np.pi / 180) if kind == "gyro" else ("mg", 9.80665e-3)
            text += f", a resolution of {words.spread([s / factor for s in steps])} {unit}"
        behind = [c for c in channels if _filtered(found, c)]
        if behind:
            cut = [f.cutoff for f in (found.model[c].low_pass for c in behind) if f and f.cutoff]
            text += f", a filter at {words.spread(cut)} Hz" if cut else ", a filter"
        out.append(text)
    if not out:
        return ""
    taken = {s.effect: None for _, s in signals.relevant(found.steps) if s.effect in NO_NOISE}
    without = [NO_NOISE[effect] for effect in taken]
    return words.sentence(out) + (f" ({words.listed(without)} taken out)" if without else "") + "."


def _markov(model: Sum) -> list[GaussMarkov]:
    return [t for t in model.terms if isinstance(t, GaussMarkov)]


def _walks(found: Report, channels: list[str]) -> str:
    """Random walks that rise above the white noise before any bias instability shows, in words."""
    parts = []
    for channel in channels:
        terms = found.model[channel].terms
        white = [t.N for t in terms if isinstance(t, WhiteNoise)]
        walk = [t.K for t in terms if isinstance(t, RandomWalk)]
        meet = np.sqrt(3) * white[0] / walk[0] if white and walk else np.inf
        if meet < SHORT:
            parts.append(
                f"{_range(walk, 'K', channel)} on {channel}, above its white noise from "
                f"{words.seconds(float(meet))} on"
            )
    return f", a random walk of {'; '.join(parts)}" if parts else ""


def _wanders(found: Report, channels: list[str]) -> str:
    """The Gauss-Markov processes of the channels, in words."""
    parts = []
    for channel in channels:
        unit, factor = ("deg/s", np.pi / 180) if channel[0] == "g" else ("mg", 9.80665e-3)
        parts += [
            f"{t.sigma / factor:.3g} {unit} over {words.seconds(t.correlation_time)} on {channel}"
            for t in _markov(found.model[channel])
        ]
    return f", and wander as a Gauss-Markov process ({'; '.join(parts)})" if parts else ""


def _changed(found: Report, density: dict[str, float | None]) -> str:
    """Densities of the channels whose level changes, at both ends of the record, in words."""
    parts = []
    for channel, first in density.items():
        change = found.model[channel].find("noise_level_change")
        if first and isinstance(change, NoiseLevelChange):
            scale = change.factor(found.record.n, found.record.rate)
            ends = [_range([first * float(scale[at])], "N", channel) for at in (0, -1)]
            parts.append(f"{channel} {ends[0]} at the start and {ends[1]} at the end")
    return f" ({'; '.join(parts)})" if parts else ""


def _character(
    model: Sum, record: Record | LongRecord
) -> tuple[float | None, float | None, float | None]:
    """(N, B, averaging time in s) of a channel: density near a twentieth of the rate, least Allan
    deviation over 0.664 where the record reaches it; None where there is none.
    """
    noise = Sum(tuple(t for t in model.terms if not (t.deterministic or isinstance(t, Telegraph))))
    fs = record.rate
    try:
        density = float(np.sqrt(noise.psd(np.array([min(1.0, 0.05 * fs)]), fs)[0] / 2))
    except UndefinedFormError:
        return None, None, None
    tau = np.geomspace(10 / fs, max(REACHED * record.duration, 20 / fs), 60)
    try:
        deviation = np.sqrt(noise.avar(tau, fs))
    except UndefinedFormError:
        return density, None, None
    i = int(np.argmin(deviation))
    if i >= len(tau) - 3:  # it still falls: the record is too short for a floor
        return density, None, None
    if tau[i] < SHORT and model.find("flicker") is None:
        return density, None, None  # where white noise meets a walk or a process is no floor
    return density, float(deviation[i] / 0.664), float(tau[i])


def _range(values: list[float], symbol: str, channel: str) -> str:
    """Smallest to largest value in the units of datasheets."""
    factor, unit = units.datasheet(symbol, channel)
    return f"{words.spread([v / factor for v in values])} {unit}"
