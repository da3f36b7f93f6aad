"""The result in a few sentences: what the record is good for, what is wrong with it, what the
sensor is like, what was the environment's, what is left, what to do next.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib import words
from imu_lib.faults import travelling
from imu_lib.gap.fault_masking import BURSTS
from imu_lib.gap.normality import TAIL
from imu_lib.gap.sentences import environment, given_model, signals
from imu_lib.gap.sentences.data_faults import LOST, sentence
from imu_lib.gap.sentences.environment import SURE
from imu_lib.gap.sentences.sensor import REACHED, of_sensor, sensor

if TYPE_CHECKING:
    from imu_lib.gap.found import Report
    from imu_lib.gap.steps import Step
    from imu_lib.long_record.record import LongRecord
    from imu_lib.record import Record

#: Share of the record from which on the stretch that was looked at is all of it.
WHOLE = 0.99
#: Rows that are lost at the most without a cause that is worth looking for.
FEW = 2.5


def sentences(found: Report) -> list[str]:
    """Three to six sentences about a `gap.Report`."""
    gone = given_model.absent(found)
    steps = [(w, s) for w, s in found.steps if not any(s is t for _, t in gone)]
    held = given_model.sentence(found, gone)
    out = [
        _good_for(found),
        sentence(
            steps,
            SURE,
            [*_moved(found), *_left_out(found), *found.lost],
            named=bool(signals.relevant(found.steps)),
        ),
        sensor(found),
        " ".join(
            filter(
                None,
                (
                    signals.sentence(steps, SURE, of_sensor(found)),
                    held,
                    environment.environment(found, steps, " more" if held else ""),
                ),
            )
        ),
    ]
    out += [_left(found), _next(found)]
    return [s for s in out if s]


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
        if signals.relevant(found.steps):
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
    if shook and all(environment.hums(p) for p in shook):
        advice.append("keep cables and supply away from the mains")
    elif shook and all(environment.coupled(p) for p in shook):
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
