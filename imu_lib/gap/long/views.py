"""The two views of a long record: a part at the full rate, and the whole as block means; what a
model is in each, and which effect belongs to which.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.long.averaged import Averaged
from imu_lib.gap.long.scan import Scan
from imu_lib.gap.steps import Step
from imu_lib.long_record.record import LongRecord
from imu_lib.model import Model
from imu_lib.processes import (
    Autoregressive,
    Disturbance,
    NoiseLevelChange,
    Process,
    Sinusoid,
    Sum,
    Telegraph,
    Tilt,
    Vibration,
    WanderingLevel,
    WarmUp,
    WhiteNoise,
    from_json,
)
from imu_lib.processes import Step as StepOfLevel
from imu_lib.record import Record

#: Share of the rate of the block means below which a line belongs to these, and periods of it that
#: a memory of these lasts at the least.
LINE, MEMORY = 0.4, 5.0
#: Times in a model, s from the first sample.
TIMES = ("time", "start", "stop")


def is_slow(process: Process, rate: float) -> bool:
    """Whether block means at `rate` Hz show a process best."""
    if isinstance(process, (Sinusoid, Vibration)):
        return process.frequency < LINE * rate
    if isinstance(process, Telegraph):
        return process.rate * MEMORY < rate
    if process.deterministic or isinstance(process, Tilt):
        return True
    return process.memory * rate > MEMORY


def belongs_to_means(step: Step, entry: Sum, rate: float) -> bool:
    """Whether an effect that was found in a part at the full rate is the whole record's affair.

    entry : the channel's model. rate : of the block means, Hz.
    """
    if step.effect == "parameter_change":
        held = entry.find(step.parameters["process"])
        return held is not None and is_slow(held, rate)
    if step.effect in ("step", "ramp", "warm_up", "temperature", "random_walk", "flicker"):
        return True
    try:
        return is_slow(from_json({"process": step.effect, **step.parameters}), rate)
    except (ValueError, KeyError):
        return False


def shifted(model: Model, seconds: float, duration: float) -> Model:
    """The model of a part that begins `seconds` after the first sample: its times count from
    there.
    """
    channels = {
        name: Sum.of(p for p in (_later(p, seconds) for p in entry) if p is not None)
        for name, entry in model.channels.items()
    }
    record = []
    for p in model.record:
        begin, end = getattr(p, "start", None), getattr(p, "stop", None)
        if isinstance(p, (Disturbance, Tilt)):
            at = p.start if isinstance(p, Disturbance) else p.time
            if not 0 <= at - seconds < duration:
                continue
        elif begin is not None and begin > seconds + duration or end is not None and end < seconds:
            continue
        moved = {t: max(getattr(p, t) - seconds, 0.0) for t in TIMES if getattr(p, t, None)}
        record.append(p.with_(**moved) if moved else p)
    return replace(model, channels=channels, record=tuple(record))


def _later(p: Process, seconds: float) -> Process | None:
    """A process or stage of a channel as a part that begins later sees it."""
    if isinstance(p, StepOfLevel):
        return p.with_(time=p.time - seconds) if p.time > seconds else None
    if isinstance(p, NoiseLevelChange):
        later = p.time - seconds
        return p.with_(time=later if p.duration else max(later, 1e-9))
    if isinstance(p, WarmUp):
        left = p.amplitude * float(np.exp(-seconds / p.time_constant))
        return p.with_(amplitude=left) if abs(left) > 1e-6 * abs(p.amplitude) else None
    if isinstance(p, Sinusoid) and p.phase is not None:
        return p.with_(phase=float(np.mod(p.phase + 2 * np.pi * p.frequency * seconds, 2 * np.pi)))
    return p


def rows(record: LongRecord, start: int, stop: int) -> tuple[int, int]:
    """Rows of the samples start ... stop - 1 of the longest part without a gap."""
    first = int(record.continuous()[0, 2])
    return record.row(first + start), record.row(first + stop)


def averages(record: LongRecord, scans: list[Scan], temperature: Array | None = None) -> Record:
    """The record of block means."""
    block = scans[0].block
    n = min(s.means.size for s in scans)
    return Record(
        {s.name: s.means[:n] for s in scans},
        record.rate / block,
        None,
        None if temperature is None else temperature[:n],
        record.name,
        record.source,
    )


def averaged(entry: Sum, block: int, fs: float) -> tuple[Sum, list[int]]:
    """The model of block means of a channel, and which of the channel's terms its own are."""
    rate = fs / block
    # what stands alone does not count to the means
    electronics = [s for s in entry.stages if s.name != "spikes"]
    added = sum(stage.added_variance(fs) for stage in electronics) / fs
    terms: list[Process] = []
    places: list[int] = []
    white: tuple[int, WhiteNoise] | None = None
    for i, t in enumerate(entry.terms):
        if t.name in ("sinusoid", "vibration") and not is_slow(t, rate):
            continue
        if isinstance(t, Autoregressive):  # its memory is short beside a block
            added += float(t.psd(np.array([1e-3 * rate]), t.rate)[0]) / 2
            continue
        if getattr(t, "rounded", None):
            t = t.with_(rounded=None)
        if isinstance(t, WhiteNoise) and t.name == WhiteNoise.name and white is None:
            white = len(terms), t
        terms.append(t)
        places.append(i)
    if added > 0 and white is not None:
        place, own = white
        terms[place] = own.with_(N=float(np.hypot(own.N, np.sqrt(added))))
    elif added > 0:
        terms.append(WhiteNoise(N=float(np.sqrt(added))))
        places.append(-1)
    kept = [s for s in entry.stages if isinstance(s, (NoiseLevelChange, WanderingLevel))]
    stages = (*kept, Averaged.of(block, fs, entry.low_pass))
    return Sum(tuple(terms), stages), places
