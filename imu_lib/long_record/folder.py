"""A folder of logs, an hour each or however the logger cut them, as one record.

Each file is read as any record is and its channels go, in SI, to the end of one scratch file per
channel; what was between files is a gap. Where the stamps of a file go on from those of the one
before, the gap has the length that they tell; where they begin anew, the logger was restarted, and
nothing is said about the time between.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import weakref
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.long_record.log import Log, record_of
from imu_lib.long_record.order import by_stamps
from imu_lib.readers import bags, zarr_store
from imu_lib.readers.assemble import assemble
from imu_lib.readers.opening import pair, read_raw
from imu_lib.stream import bounds

SUFFIXES = (".npz", ".npy", ".parquet", ".csv", ".txt", ".tsv", ".log", ".mat", ".h5", ".hdf5")
#: Files that may hold words as well as samples.
WORDS = (".csv", ".txt", ".tsv", ".log")
_PACKED = re.compile(r"\.(gz|bz2|xz)$")


@dataclass(frozen=True)
class Appended:
    """Channels in a folder of plain files of float64, one a channel."""

    path: str

    def write(self, columns, time):
        """The next rows of each channel."""
        for name, x in columns.items():
            with open(Path(self.path) / name, "ab") as out:
                out.write(np.ascontiguousarray(x).tobytes())

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
    if not path.is_dir() or bags.is_bag(path) or zarr_store.is_store(path) or pair(path):
        return None
    files, beside = _logs(path)
    if not files:
        return None
    found, spans = _read(path, files, rate, progress, options)
    ordered = by_stamps(files, spans, found.rate)
    if ordered is not None:
        found = None  # its samples go before they are written again
        found, _ = _read(path, ordered, rate, progress, options)
        note = (
            f"The logs were put in the order of their stamps, not of their names: "
            f"{', '.join(f.name for f in ordered[:4])}{' ...' * (len(ordered) > 4)}."
        )
        found = replace(found, notes=(*found.notes, note))
    if beside:
        note = (
            f"Beside the logs stand {', '.join(beside[:3])}{' ...' * (len(beside) > 3)}, which "
            "were left out."
        )
        found = replace(found, notes=(*found.notes, note))
    return found


def _read(path, files, rate, progress, options):
    """(the LongRecord of files in this order, first and last stamp of each or None)."""
    scratch = Path(tempfile.mkdtemp(prefix="imu-lib-"))
    sink = Appended(str(scratch))
    # a fleet opens many: a record's samples go with it, and not those of a process that forked
    weakref.finalize(sink, _removed, scratch, os.getpid())
    log = Log(path, sink)
    reading = {"columns": options.get("columns"), "topic": options.get("topic")}
    units = {k: options.get(k) for k in ("gyro_unit", "accel_unit", "time_unit")}
    spans = []
    for file in files:
        try:
            raw = read_raw(file, **reading)
            record = assemble(raw, rate=rate, trust=options.get("trust_units", False), **units)
        except InputError as error:
            if len(files) > 2 and log.rows:  # what is asked of the first is asked of all
                said = str(error).rstrip(".")
                raise InputError(
                    f"{said}; or move it away: the other logs of {path} are read without it."
                ) from None
            raise
        log.append(file, record, raw.start)
        spans.append(None if raw.start is None else (raw.start, log.clock))
        if progress is not None:
            progress(file.name)
    return record_of(log.state(), path, lambda name: (sink, name)), spans


def _removed(scratch, process):
    if os.getpid() == process:
        shutil.rmtree(scratch, ignore_errors=True)


def _logs(path):
    """(the logs of a folder in the order of their numbers, names of other files that might be
    read); no logs where none are a row: two files or more whose names differ in their numbers
    alone, and no other such row or other record beside them.
    """
    kinds: dict = {}
    for file in path.iterdir():
        name = _PACKED.sub("", file.name.lower())
        if name.startswith(".") or not name.endswith(SUFFIXES):
            continue
        if file.is_symlink() and not file.exists():
            raise InputError(
                f"{file} is a link to a file that is not there; bring that file back or remove "
                "the link."
            )
        if file.is_file():
            kinds.setdefault(re.sub(r"\d+", "#", name), []).append(file)
    rows = [files for files in kinds.values() if len(files) > 1]
    other = any(not k.endswith(WORDS) for k, files in kinds.items() if len(files) == 1)
    if len(rows) != 1 or other:
        return [], []
    beside = sorted(f.name for files in kinds.values() if len(files) == 1 for f in files)
    return sorted(rows[0], key=by_numbers), beside


def by_numbers(file):
    """Where a log stands in its row: by its numbers, not by their digits."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", file.name.lower())]
