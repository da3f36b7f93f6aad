"""A stretch of a record on disk, from one second to another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.errors import InputError
from imu_lib.long_record.record import LongRecord


def cut(record: LongRecord, start: float | None, stop: float | None) -> LongRecord:
    """The rows from `start` to before `stop`, s from the first sample; nothing is read.

    Raises
    ------
    InputError
        Where fewer than two samples are left.
    """
    if start is None and stop is None:
        return record
    origin = int(record.slot(record.begin))

    def row(second, otherwise):
        if second is None:
            return otherwise
        slot = origin + int(np.ceil(second * record.rate - 1e-6))
        return min(max(record.row(slot), record.begin), record.rows)

    low, high = row(start, record.begin), row(stop, record.rows)
    runs = record.runs[(record.runs[:, 1] > low) & (record.runs[:, 0] < high)].copy()
    if high - low < 2 or not len(runs):
        end = "its end" if stop is None else f"{stop:g} s"
        raise InputError(
            f"{record.source}: from {start or 0:g} s to {end} there are fewer than two samples of "
            f"a record of {record.duration:.6g} s; choose a part inside it."
        )
    runs[0, 2] += max(low - runs[0, 0], 0)
    runs[0, 0] = max(runs[0, 0], low)
    runs[-1, 1] = min(runs[-1, 1], high)
    note = (
        f"The part from {start or 0:g} to "
        f"{'the end' if stop is None else format(stop, 'g') + ' s'} was used."
    )
    return replace(record, runs=runs, begin=low, rows=high, notes=(*record.notes, note))
