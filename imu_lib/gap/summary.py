"""The result in a few sentences: what the record is good for, what is wrong with it, what the
sensor is like, what was the environment's, what is left, what to do next.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib import units
from imu_lib.errors import UndefinedFormError
from imu_lib.faults import travelling
from imu_lib.gap import known_before, surroundings, told, words
from imu_lib.gap.evenness import TAIL
from imu_lib.gap.faulty import BURSTS
from imu_lib.gap.surroundings import SURE
from imu_lib.gap.wrong import LOST, sentence
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
    from imu_lib.gap.steps import Step
    from imu_lib.long_record.record import LongRecord
    from imu_lib.record import Record

#: Averaging times shorter than this share of the record have an Allan deviation worth the name.
REACHED = 0.1
#: Averaging time below which the least Allan deviation is no bias instability without flicker
#: noise, s.
SHORT = 5.0
#: Share of the record from which on the stretch that was looked at is all of it.
WHOLE = 0.99
#: Rows that are lost at the most without a cause that is worth looking for.
FEW = 2.5
#: Effects that the figures of noise are without, in words.
NO_NOISE = {
    "spikes": "spikes",
    "step": "steps",
    "vibration": "vibrations",
    "telegraph": "flips between two levels",
}


def sentences(found: Report) -> list[str]:
    """Three to six sentences about a `gap.Report`."""
    gone = known_before.absent(found)
    steps = [(w, s) for w, s in found.steps if not any(s is t for _, t in gone)]
    held = known_before.sentence(found, gone)
    out = [
        _good_for(found),
        sentence(
            steps,
            SURE,
            [*_moved(found), *_left_out(found)],
            named=bool(told.relevant(found.steps)),
        ),
        _sensor(found),
        " ".join(
            filter(
                None,
                (
                    told.sentence(steps, SURE, _of_sensor(found)),
                    held,
                    surroundings.environment(found, steps, " more" if held else ""),
                ),
            )
        ),
    ]
    out += [_left(found), _next(found)]
    return [s for s in out if s]


def _of_sensor(found: Report) -> set[tuple[str, str]]:
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
        )
    }


def _good_for(found: Report) -> str:
    record = found.record
    span = record.duration
    reach = REACHED * span
    channels = len(found.channels)
    what = "the noise density"
    if reach >= 20:
        what += f" and the bias instability up to averaging times of {words.seconds(reach)}"
    if span >= 3600:
        what += ", drifts of minutes included"
    held = [c.held_out["after"] for c in found.channels.values() if c.held_out]
    clean = [n for n, c in found.channels.items() if c.result.unexplained is None]
    good = (
        ("on all channels that are left" if _left_out(found) else "on all channels")
        if len(clean) == channels
        else f"on {words.names(clean)}"
        if clean
        else "with reserve, since no channel is explained in full"
    )
    if _moved(found):
        return (
            f"The record, {words.seconds(span)} at {record.rate:.5g} Hz, is not of a sensor at "
            "rest and not good for its noise."
        )
    start, stop = found.stretch or (0.0, span)
    whole = max(found.whole or span, span)
    text = (
        f"The record, {words.seconds(whole)} at {record.rate:.5g} Hz, is good from {start:.0f} "
        f"to {stop:.0f} s for {what}, {good}"
    )
    if stop - start < WHOLE * whole:
        text += f"; the other {words.seconds(whole - (stop - start))} are left out"
        text += " (a tilt, a restart, frozen output or a long hole lies between)"
    if held:
        text += f"; on time that was not fitted the gap index is {np.median(held):.2f}"
    return text + "."


def _moved(found: Report) -> list[str]:
    return [note for note in found.notes if note.startswith(travelling.BEGINS)]


def _left_out(found: Report) -> list[str]:
    return [note for note in found.notes if note.endswith("it is left out.")]


def _sensor(found: Report) -> str:
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
        if any(found.model[c].low_pass is not None for c in channels):
            cut = [f.cutoff for f in (found.model[c].low_pass for c in channels) if f and f.cutoff]
            text += f", a filter at {words.spread(cut)} Hz" if cut else ", a filter"
        out.append(text)
    if not out:
        return ""
    taken = {s.effect: None for _, s in told.relevant(found.steps) if s.effect in NO_NOISE}
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


def _left(found: Report) -> str:
    small = [n for n, c in found.channels.items() if c.result.small]
    if not small:
        return _without_name(found)
    return (
        f"{_without_name(found)[:-1]}; small departures from the normal distribution on "
        f"{words.names(small)} move no limit at three standard deviations by {100 * TAIL:.0f} %."
    )


def _without_name(found: Report) -> str:
    left = [n for n, c in found.channels.items() if c.result.unexplained]
    if not left:
        beyond = found.record_unexplained
        if beyond:
            return f"Left without a name: {beyond}."
        if told.relevant(found.steps):
            if all(c.before is None for c in found.channels.values()):
                return "Beside what is named nothing was found; no gap index was asked for."
            return "Beside what is named, simulation and measurement agree."
        return "Nothing is left without a name."
    first = found.channels[left[0]].result.unexplained
    more = "" if len(left) == 1 else f" ({len(left)} channels in all: {words.names(left)})"
    return f"Left without a name on {left[0]}: {first}{more}."


def _next(found: Report) -> str:
    names = {s.effect for _, s in found.steps}
    advice = []
    if any(_lost(s, found.record) for _, s in found.steps):
        advice.append("find out where samples are lost")
    if {"disturbance", "tilt"} & names:
        advice.append("record where nobody touches the sensor")
    shook = [s.parameters for _, s in found.steps if s.effect == "vibration"]
    if shook and all(surroundings.hums(p) for p in shook):
        advice.append("keep cables and supply away from the mains")
    elif shook and all(surroundings.coupled(p) for p in shook):
        advice.append("keep cables and supply away from what couples into the electronics")
    elif shook:
        advice.append("record again away from what shakes it, on a heavy base")
    absorbed = any("temperature" in c.result.absorbed for c in found.channels.values())
    slow = {"random_walk", "ramp", "warm_up", "flicker", "gauss_markov"} & names
    if found.record.temperature is None and (slow or found.record.duration > 1800) and not absorbed:
        advice.append("log the temperature")
    if found.record.duration < 3600:
        advice.append("record an hour or more for the bias instability")
    if not advice:
        return "Next: a second record of another day tells what of this is the sensor's."
    return f"Next: {words.listed(advice[:3])}."


def _lost(step: Step, record: Record | LongRecord) -> bool:
    """Whether a step is samples that are lost all the time, not a first row or bursts."""
    if step.effect not in LOST or step.evidence == BURSTS:
        return False
    return step.parameters["fraction"] * record.n > FEW


def _range(values: list[float], symbol: str, channel: str) -> str:
    """Smallest to largest value in the units of datasheets."""
    factor, unit = units.datasheet(symbol, channel)
    return f"{words.spread([v / factor for v in values])} {unit}"
