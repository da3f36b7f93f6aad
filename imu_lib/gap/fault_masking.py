"""What comes before all competition: the data's own faults and what happened to the sensor. They
are masked or cut, and stand in the record's list of steps; one place for the library and the
command.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from imu_lib import faults
from imu_lib.arrays import Array
from imu_lib.errors import InputError
from imu_lib.faults import Finding, travelling
from imu_lib.faults.disturbance import KNOCK
from imu_lib.faults.finding import seconds
from imu_lib.faults.soundness import Sound
from imu_lib.faults.standing import stands
from imu_lib.gap import fault_steps, record_level
from imu_lib.gap.steps import Step
from imu_lib.gap.uninformative import MOST_LOST, says_nothing
from imu_lib.model import Model
from imu_lib.processes import Process, from_json
from imu_lib.record import Record

#: Share of the record that is missing in holes beyond which it is cut to its longest stretch: a
#: filled hole would be taken for what the sensor does.
LONGEST_HOLES = 0.2
#: Samples that the workflow needs; means of bursts that it needs (24 of 830 normal samples raised
#: no alarm, with a model and without).
LEAST, LEAST_BURSTS = 2000, 800
#: Evidence of samples that are missing because the sensor sends them in bursts.
BURSTS = "bursts of the sensor's own"


@dataclass(frozen=True, eq=False)
class Ready:
    """A record made ready for the competition.

    record : Record, masked and cut. start, stop : the stretch of the given record that it is, s.
    steps : of the record, with times of the given record. processes : the same for a model's
    `record`. left_out : channel -> why. notes : sentences. doubt : a sentence where the time stamps
    do what has no name. others : the other sound stretches, s, the longest first.
    """

    record: Record
    start: float
    stop: float
    steps: tuple[Step, ...]
    processes: tuple[Process, ...]
    left_out: dict[str, str]
    notes: tuple[str, ...]
    doubt: str | None
    findings: tuple[Finding, ...] = ()
    others: tuple[tuple[float, float], ...] = ()

    @property
    def lost(self) -> tuple[str, ...]:
        """Where the channels that are looked at have no number, in sentences."""
        return tuple(
            f.sentence
            for f in _of(self.findings, dict(self.record.channels))
            if f.kind == "dropout" and fault_steps.of_file(f)
        )


def ready(record: Record, model: Model | None = None) -> Ready:
    """The record without its faults, and the steps that name them.

    Parameters
    ----------
    record : Record
    model : Model, optional
        What its `record` holds is masked, too, but no step.

    Raises
    ------
    InputError
        If no channel says anything of its noise, or too few samples are left.
    """
    if record.n < LEAST_BURSTS:
        raise InputError(
            f"{_name(record)}: {record.n:,} samples are too few; the gap workflow needs {LEAST} "
            "or more."
        )
    findings = faults.find(record)
    left_out = says_nothing(record, findings)
    kept = _kept(record, left_out, record)
    whole = replace(record, channels=kept)
    sound = faults.sound(whole, _of(findings, kept), holes=_hollow(whole))
    masked = sound.record
    for c, x in masked.channels.items():  # what is held or dropped most of the time
        lost = float(np.isnan(x).mean())
        if lost > MOST_LOST:
            left_out[c] = f"is no measurement in {lost:.0%} of the samples" + _still(findings, c)
    kept = _kept(masked, left_out, record)
    _enough(masked.n, record, findings)
    masked = replace(masked, channels=kept)
    held = {p.name for p in model.record} if model is not None else set()
    clock, doubt = _clock(whole, sound, model, findings)
    told = without_turns(_of(findings, kept))
    steps = [*clock, *(s for f in told for s in fault_steps.steps(f, record))]
    steps = [s for s in steps if s.effect not in held]
    processes = tuple(
        from_json({"process": s.effect, **s.parameters}, on_record=True) for s in steps
    )
    return Ready(
        masked,
        sound.start,
        sound.stop,
        tuple(steps),
        processes,
        left_out,
        tuple(_notes(left_out, sound, travelling.sentence(masked))),
        doubt,
        findings,
        sound.others,
    )


def _kept(part: Record, left_out: dict[str, str], record: Record) -> dict[str, Array]:
    """The channels of a part of `record` that are not left out.

    Raises
    ------
    InputError
        If there are none.
    """
    kept = {c: x for c, x in part.channels.items() if c not in left_out}
    if kept:
        return kept
    why = "; ".join(f"{c} {reason}" for c, reason in left_out.items())
    raise InputError(
        f"{_name(record)}: no channel says anything of its noise (stuck, missing or rounded away: "
        f"{why}); check the logger."
    )


def _enough(n: int, record: Record, findings: tuple[Finding, ...]) -> None:
    """Raises where `n` samples are too few."""
    bursts = any(f.kind == "burst" for f in findings)
    if n < (LEAST_BURSTS if bursts else LEAST):
        of = "" if n == record.n else f" of {record.n:,} are left without faults and"
        raise InputError(
            f"{_name(record)}: {n:,} samples{of} are too few; the gap workflow needs {LEAST} or "
            "more."
        )


def _notes(left_out: dict[str, str], sound: Sound, moved: str | None) -> list[str]:
    """What was left out or cut, in sentences; whether it moved first."""
    notes = [moved] if moved else []
    notes += [f"{c} {why}; it is left out." for c, why in left_out.items()] + list(sound.notes)
    if sound.start > 0:
        notes.append(
            f"Times of what follows count from {seconds(sound.start)} s (as with --start "
            f"{seconds(sound.start)} --stop {seconds(sound.stop)}), those of drop-outs, "
            "disturbances and tilts from the first sample."
        )
    return notes


def _name(record: Record) -> str:
    return record.source or record.name or "the record"


def _of(findings: tuple[Finding, ...], channels: dict[str, Array]) -> tuple[Finding, ...]:
    """Findings that concern the channels kept."""
    return tuple(f for f in findings if not f.channels or set(f.channels) & set(channels))


def without_turns(findings: Iterable[Finding]) -> list[Finding]:
    """Findings without the knocks that are the gyros' pulse of a tilt: one event is told once."""
    tilts = [f for f in findings if f.kind == "tilt"]

    def turned(knock: Finding) -> bool:
        if knock.kind != "disturbance" or knock.stop - knock.start >= KNOCK:
            return False
        return any(t.start < knock.stop and knock.start < t.stop for t in tilts)

    return [f for f in findings if not turned(f)]


def _still(findings: tuple[Finding, ...], channel: str) -> str:
    """From when to when a channel stands still, in words."""
    spans = [(f.start, f.stop) for f in findings if stands(f) and channel in f.channels]
    return "".join(f", frozen from {seconds(a)} to {seconds(b)} s" for a, b in spans)


def _hollow(record: Record) -> bool:
    """Whether so much is missing in holes that the record is cut at them."""
    whole = int(record.slots()[-1]) + 1
    lost = 1 - (record.n - record.missing().sum()) / whole
    if lost <= LONGEST_HOLES:
        return False
    start, stop = faults.longest_stretch(record, [f for f in faults.of_clock(record)])
    # samples lost all over the record: the workflow knows how to miss them
    return (stop - start) * record.n / record.duration >= LEAST or whole > 10 * record.n


def _clock(
    record: Record, sound: Sound, model: Model | None, findings: tuple[Finding, ...]
) -> tuple[list[Step], str | None]:
    """Steps of the time stamps, of the stretch as it was recorded."""
    part = record.slice(sound.start, sound.stop) if sound.start > 0 or sound.cut else record
    steps, doubt = record_level.timing(part, model)
    bursts = next((f for f in findings if f.kind == "burst"), None)
    if bursts is not None:
        # the sensor's own bursts: the stamps do what they should
        gaps = [s for s in steps if s.effect == "time_gaps"]
        return [replace(s, where=bursts.sentence, evidence=BURSTS) for s in gaps], None
    return steps, doubt
