"""A path as a record: on disk where it is long and can be read by pieces, in memory else."""

from __future__ import annotations

from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.long_record.converted import open_converted
from imu_lib.long_record.cut import cut
from imu_lib.long_record.folder import open_folder
from imu_lib.long_record.opening import open_long
from imu_lib.long_record.record import SHORTEST, LongRecord
from imu_lib.readers import zarr_store
from imu_lib.record import Record
from imu_lib.stream import LONG


def on_disk(path, *, start=None, stop=None, least=None, progress=None, **reading):
    """The part from `start` to `stop`, s, of a long file that is read by pieces, at once or after
    it was converted, or of a folder of logs; None where it is neither. `least` as for `open_long`;
    `progress` is called with the share of a file that is converted.
    """
    if start is not None and stop is not None and stop <= start:
        raise InputError(f"--stop {stop:g} is not after --start {start:g}.")
    if Path(path).is_dir() and not zarr_store.is_store(path):
        record = open_folder(path, **reading)
    else:
        record = open_long(path, least=least, **reading) or open_converted(
            path, progress=progress, **reading
        )
    return None if record is None else cut(record, start, stop)


def worth_it(record: LongRecord, least: int | None = None) -> Record | LongRecord:
    """The record itself where it is long, has a long part without gaps and so is worth reading by
    pieces; else all of it in memory.
    """
    short = record.rows - record.begin <= (LONG if least is None else least)
    return record.in_memory() if short or record.longest < SHORTEST else record
