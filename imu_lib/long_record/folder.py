"""A folder of logs, an hour each or however the logger cut them, as one record.

Each file is read as any record is and its channels go, in SI, to the end of one scratch file per
channel; what was between files is a gap. Where the stamps of a file go on from those of the one
before, the gap has the length that they tell; where they begin anew, the logger was restarted, and
nothing is said about the time between.
"""

from __future__ import annotations

import atexit
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.long_record import grid
from imu_lib.long_record.record import FILL, Column, LongRecord
from imu_lib.readers import bags
from imu_lib.readers.assemble import assemble
from imu_lib.readers.opening import pair, read_raw
from imu_lib.stream import bounds

SUFFIXES = (".npz", ".npy", ".parquet", ".csv", ".txt", ".tsv", ".log", ".mat")


@dataclass(frozen=True)
class Appended:
    """Channels in a folder of plain files of float64, one a channel."""

    path: str

    def pieces(self, name, start, stop):
        """The values start ... stop - 1 of a channel, ndarrays in order."""
        with open(Path(self.path) / name, "rb") as file:
            for low, high in bounds(stop - start):
                file.seek((start + low) * 8)
                yield np.fromfile(file, float, high - low)


def open_folder(path, *, rate=None, progress=None, **options):
    """The logs of a folder as one LongRecord, in the order of their names; None where the folder is
    no row of logs: two files or more whose names differ in their numbers alone. Options as for
    `read_record`.

    `progress` is called with each file's name when it is read. InputError where two files have
    other channels, or rates that differ by more than a per cent.
    """
    path = Path(path)
    if not path.is_dir() or bags.is_bag(path) or pair(path):
        return None
    files = sorted(p for p in path.iterdir() if p.suffix.lower() in SUFFIXES and p.is_file())
    kinds = {re.sub(r"\d+", "#", p.name) for p in files}
    if len(files) < 2 or len(kinds) > 1:
        return None
    scratch = Path(tempfile.mkdtemp(prefix="imu-lib-"))
    atexit.register(shutil.rmtree, scratch, ignore_errors=True)
    log = _Log(path, scratch)
    reading = {"columns": options.get("columns"), "topic": options.get("topic")}
    units = {k: options.get(k) for k in ("gyro_unit", "accel_unit", "time_unit")}
    for file in files:
        raw = read_raw(file, **reading)
        record = assemble(raw, rate=rate, trust=options.get("trust_units", False), **units)
        log.append(file, record, raw.start)
        if progress is not None:
            progress(file.name)
    return log.record()


class _Log:
    """What has been read so far."""

    def __init__(self, path, scratch):
        self.path, self.scratch = path, scratch
        self.rows, self.end, self.rate = 0, 0, None
        self.names, self.first, self.clock, self.restarts = None, None, None, []
        self.steps, self.bad, self.notes = [], [], {}
        self.span = {}

    def append(self, file, record, start):
        names = record.channel_names
        if self.names is None:
            self.names, self.rate, self.first = names, record.rate, file
        if names != self.names:
            raise InputError(
                f"{file} has the channels {', '.join(names)}, {self.first} {', '.join(self.names)}; "
                "logs of one record have the same."
            )
        if abs(record.rate / self.rate - 1) > 0.01:
            raise InputError(
                f"{file} has {record.rate:.6g} Hz, {self.first} {self.rate:.6g} Hz; logs of one "
                "record have one rate: give --rate, or move the file away."
            )
        slots = record.slots()
        lost = self._between(file, start)
        if lost:
            self.steps.append((self.rows, lost))
        for i in np.flatnonzero(np.diff(slots) > 1):
            self.steps.append((self.rows + int(i) + 1, int(slots[i + 1] - slots[i] - 1)))
        for name, x in record.channels.items():
            with open(self.scratch / name, "ab") as out:
                out.write(np.ascontiguousarray(x).tobytes())
            low, high = self.span.get(name, (np.inf, -np.inf))
            self.span[name] = min(low, np.nanmin(x)), max(high, np.nanmax(x))
        self.bad.append(self.rows + np.flatnonzero(record.missing()))
        for note in record.notes:
            self.notes.setdefault(note, []).append(file.name)
        self.rows += record.n
        self.clock = None if start is None else start + float(slots[-1] + 1) / record.rate

    def _between(self, file, start):
        """Samples missing between the file before and this one."""
        if self.rows == 0:
            return 0
        if start is None or self.clock is None or start < self.clock - 0.5 / self.rate:
            self.restarts.append(file.name)
            return FILL + 1
        return max(round((start - self.clock) * self.rate), 0)

    def record(self):
        bad = np.unique(np.concatenate(self.bad)).astype(np.int64)
        steps = np.array(self.steps, np.int64).reshape(-1, 2)
        source = Appended(str(self.scratch))
        notes = [f"{', '.join(files[:3])}{' ...' * (len(files) > 3)}: {note}" for note, files in self.notes.items()]  # fmt: skip
        if self.restarts:
            notes.append(
                f"{len(self.restarts)} of the files begin anew ({', '.join(self.restarts[:3])}"
                f"{' ...' * (len(self.restarts) > 3)}): how long the logger paused before them is not "
                "known, and nothing is carried over."
            )
        return LongRecord(
            {name: Column(source, name, 1.0, 0.0) for name in self.names},
            self.rate,
            grid.runs(self.rows, steps, bad),
            tuple(name for name in self.names if not self.span[name][1] > self.span[name][0]),
            self.path.name,
            str(self.path),
            tuple(notes),
            self.rows,
            steps,
        )
