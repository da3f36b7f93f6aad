"""Every method on every channel of a record at rest: one result, one error model.

Allan variance, spectrum, autocorrelation and autoregressive models read coefficients off their own
curves; the likelihood fits whole sums of processes, chooses between them and gives the error model
that is saved. What the record cannot support is said in the notes of the result instead of being
left out in silence.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib import scheduler, units
from imu_lib.characterise import causes, still
from imu_lib.characterise.channel import (
    Channel,
    channel,
    fitted,
    limits,
    of_long,
    plainly,
    stretches,
)
from imu_lib.errors import InputError
from imu_lib.faults import jump, standing
from imu_lib.long_record import LongRecord
from imu_lib.long_record.record import FILL
from imu_lib.model import Model
from imu_lib.readers.side_by_side import own_rates
from imu_lib.record import Record

#: Records above this many samples are worth a process per axis.
PARALLEL = 150_000


@dataclass(frozen=True)
class Characterisation:
    """The result on a record: `channels` by name, its rate in Hz, its duration in s, notes."""

    channels: dict
    rate: float
    duration: float
    name: str
    source: str
    notes: tuple = ()

    def __getitem__(self, channel):
        return self.channels[channel]

    @property
    def model(self) -> Model:
        """The error model of all channels; its source says where a walk in it is a jump."""
        said = ["likelihood fit of " + (self.source or self.name or "a record")]
        said += [note.rstrip(".") for note in self.notes if note.startswith(jump.BEGINS)]
        return Model(
            {name: c.model for name, c in self.channels.items()},
            rate=self.rate,
            name=self.name,
            source=". ".join(said),
        )

    def to_json(self):
        return {
            "channels": {name: c.to_json() for name, c in self.channels.items()},
            "rate": self.rate,
            "duration": self.duration,
            "name": self.name,
            "source": self.source,
            "notes": list(self.notes),
        }


def characterise(
    record: Record, *, channels=None, candidates=None, workers=None, progress=None
) -> Characterisation:
    """All methods on all channels.

    Parameters
    ----------
    record : Record or LongRecord
    channels : sequence of str, optional
        Default all.
    candidates : dict of str to Sum, optional
        Sums the likelihood chooses from, default `likelihood.CANDIDATES`.
    workers : int, optional
        Processes; default one per core for long records.
    progress : callable, optional
        Called with the name of each channel when it is done.

    Raises InputError where the record has fewer than 100 samples without a gap, or no channel that
    ever changes.
    A channel that never changes is left out, and a note says so.
    """
    if isinstance(record, LongRecord):
        return _of_long(record, channels, candidates, workers, progress)
    apart = own_rates(record)
    if apart:
        return _apart(record, apart, channels, candidates, workers, progress)
    given = record
    record, frozen = standing.masked(given)
    gone = set(given.channel_names) - set(record.channel_names)
    asked = [name for name in channels or given.channel_names if name not in gone]
    gap_free = record.continuous().enough()
    flat = [name for name in asked if np.ptp(gap_free[name]) == 0]
    names = tuple(name for name in asked if name not in flat)
    if not names:
        raise InputError(
            f"{record.source or 'The record'}: no channel ever changes, so there is no noise to "
            "describe; check the logger."
        )
    notes = tuple(note for note in gap_free.notes if note not in record.notes)
    filled = record.uniform() if notes else gap_free
    tasks = [
        (name, *_arrays(gap_free[name], filled[name]), record.rate, candidates) for name in names
    ]
    cores = workers or (min(len(tasks), scheduler.cores()) if record.n > PARALLEL else 1)
    results = scheduler.shared(channel, tasks, cores)
    notes += frozen + _of_record(record, flat) + causes.notes(gap_free, names)
    return _gathered(record, results, progress, notes)


def _arrays(x, filled):
    """(x, stretches) of a channel; where there is one, both are the same array, sent once."""
    parts = stretches(filled)
    return x, [x] if [part.size for part in parts] == [x.size] else parts


def _of_long(record, channels, candidates, workers, progress):
    """A record on disk: each process reads one channel at a time."""
    names = tuple(n for n in channels or record.channel_names if n not in record.flat)
    cores = workers or min(max(len(names), 1), scheduler.cores())
    stands = dict(scheduler.shared(still.spans, [(record, name) for name in names], cores))
    tasks, told = [], {}
    for name in names:
        part, rows = record, stands[name]
        if len(rows):
            part, share = still.without(record, rows)
            ends = (record.second(int(row)) for row in (rows[0, 0], rows[-1, 1] - 1))
            text = standing.sentence(share, *ends, part is not None)
            told.setdefault(text, []).append(name)
        if part is not None:
            tasks.append((part, name, candidates))
    if not tasks:
        raise InputError(
            f"{record.source}: no channel ever changes, so there is no noise to describe; check "
            "the logger."
        )
    notes = standing.noted(told) + _of_record(record, record.flat)
    notes = (*notes, *causes.of_parts(record, names))
    return _gathered(record, scheduler.shared(of_long, tasks, cores), progress, notes)


def _gathered(record, results, progress, notes):
    """The channels' results as they come, and what is said of the record."""
    found = {}
    for result in results:
        found[result.name] = result
        if progress is not None:
            progress(result.name)
    return Characterisation(
        {name: found[name] for name in record.channel_names if name in found},
        record.rate,
        record.duration,
        record.name,
        record.source,
        record.notes + notes,
    )


def _apart(record, apart, channels, candidates, workers, progress) -> Characterisation:
    """Gyro and accelerometer that come at rates of their own, each at its own."""
    found, notes = {}, list(record.notes)
    for part in apart.values():
        names = [c for c in part.channel_names if channels is None or c in channels]
        if not names:
            continue
        one = characterise(
            part, channels=names, candidates=candidates, workers=workers, progress=progress
        )
        found |= one.channels
        notes += [n for n in one.notes if n not in notes]
    rates = " and ".join(f"{kind} at {part.rate:.6g} Hz" for kind, part in apart.items())
    notes.append(f"Each sensor was characterised at its own rate: {rates}.")
    return Characterisation(
        found, record.rate, record.duration, record.name, record.source, tuple(notes)
    )


def _of_record(record, flat):
    notes = [f"{name} never changes and is left out." for name in flat]
    gaps = record.gaps()
    if gaps:
        start, longest, _ = max(gaps, key=lambda gap: gap[1])
        others = "all of it, the gaps bridged by straight lines"
        if max(missing for _, _, missing in gaps) > FILL:
            others = f"the longest part without a gap of more than {FILL} samples"
        notes.append(
            f"{len(gaps)} gap{'s' * (len(gaps) > 1)} in time, the longest {longest:.3g} s at "
            f"{start:.6g} s: the likelihood takes every stretch, the other methods {others}."
        )
    if record.duration < 600:
        notes.append(
            f"The record is {units.duration(record.duration)} long: bias instability, walks and "
            "correlation times take hours; their limits say little."
        )
    return tuple(notes)


__all__ = [
    "Channel",
    "Characterisation",
    "channel",
    "characterise",
    "fitted",
    "limits",
    "plainly",
    "stretches",
]
