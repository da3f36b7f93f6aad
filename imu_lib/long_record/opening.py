"""A file as a record on disk: what its columns are and where its samples lie is told by its first
rows and its stamps.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from imu_lib import readers
from imu_lib.errors import InputError
from imu_lib.long_record import columns, grid
from imu_lib.long_record.record import Column, LongRecord, counted, without_counts
from imu_lib.readers import names, zarr_store
from imu_lib.readers.streams import slow_kind
from imu_lib.record import CHANNELS
from imu_lib.stream import CHUNK, LONG

#: Rows that tell units, rate and columns.
HEAD = 1 << 17


def open_long(path, *, start=None, stop=None, trust_units=False, least=None, **options):
    """The record of a file as a LongRecord where it is long and can be read by pieces, else None.

    What columns are, their units and the rate are told by the file's first rows, read as any record
    is. `least` is the number of samples above which a record counts as long (`stream.LONG`).
    InputError as `read_record` raises it.
    """
    path = Path(path)
    if not (path.is_file() or zarr_store.is_store(path)) or start is not None or stop is not None:
        return None
    source = columns.source(path)
    if source is None:
        return None
    sizes = source.columns()
    rows = max(sizes.values())
    if rows <= (LONG if least is None else least):
        return None
    head, described = _head(source, path, trust_units=trust_units, **options)
    if head.n != HEAD or slow_kind(head):
        return None  # rows that are copies, or streams in rows of their own: read whole
    found = _matched(source, {k for k, n in sizes.items() if n == rows}, head)
    if found is None:
        return None
    stamps = _stamps(source, sizes, rows, head, options.get("columns"))
    if stamps is None:
        return None
    laid = grid.lay(source, list(found.values()), rows, stamps, head.rate)
    if laid is None:
        return None
    names_ = list(found)
    notes = without_counts(head.notes) + counted(laid.missing, laid.steps, laid.rate)
    return LongRecord(
        found,
        laid.rate,
        laid.runs,
        tuple(names_[i] for i in laid.flat),
        path.stem,
        str(path),
        notes,
        rows,
        laid.steps,
        described,
        _temperature(source, {k for k, n in sizes.items() if n == rows}, head),
    )


def _head(source, path, **options):
    with tempfile.TemporaryDirectory() as folder:
        part = Path(folder) / f"{path.stem}{columns.suffix(path)}"
        source.head(HEAD, part)
        try:
            found = readers.read(part, **options)
            return found.record, tuple(found.columns)
        except InputError as error:
            raise InputError(str(error).replace(str(part), str(path))) from None


def _matched(source, known, head):
    """Channel -> Column, by the straight line that its values in SI make over a column; None where
    there is none: the readers did more than scale.
    """
    raw, out = {}, {}
    for name in known:
        canonical = names.parse(name)[0]
        if canonical and canonical.partition("_")[0] in ("gyro", "accel", "dtheta", "dv"):
            raw[name] = np.concatenate([x for x in source.pieces(name, 0, HEAD)]).astype(float)
    for channel in CHANNELS:
        if channel not in head:
            continue
        for name, y in raw.items():
            line = _line(y, head[channel])
            same = names.parse(name)[0] or ""
            if line and same[-1:] == channel[-1] and name not in {c.name for c in out.values()}:
                if channel.startswith("gyro") == (same.partition("_")[0] in ("gyro", "dtheta")):
                    out[channel] = Column(source, name, *line)
                    break
        else:
            return None
    return out


def _temperature(source, known, head):
    """The column of the temperature, or None."""
    if head.temperature is None:
        return None
    for name in known:
        if (names.parse(name)[0] or "") == "temperature":
            y = np.concatenate([x for x in source.pieces(name, 0, HEAD)]).astype(float)
            line = _line(y, head.temperature)
            if line:
                return Column(source, name, *line)
    return None


def _line(y, x):
    """(factor, zero) with x = factor y + zero to the last digits, or None."""
    if y.size != x.size or not np.array_equal(np.isnan(y), np.isnan(x)):
        return None
    good = ~np.isnan(y)
    y, x = y[good], x[good]
    if not y.size:
        return None
    if np.array_equal(x, y):
        return 1.0, 0.0
    a, b = int(np.argmin(y)), int(np.argmax(y))
    if y[a] == y[b]:
        return None
    factor = (x[b] - x[a]) / (y[b] - y[a])
    zero = x[a] - factor * y[a]
    if abs(zero) < 1e-12 * np.abs(x).max():
        zero = 0.0
        factor = float(np.median(x[y != 0] / y[y != 0]))
    error = np.abs(factor * y + zero - x).max()
    return (float(factor), float(zero)) if error <= 1e-12 * np.abs(x).max() else None


def _stamps(source, sizes, rows, head, given):
    """(column of the time or None, seconds per unit); None where the stamps need the readers."""
    found = [k for k, n in sizes.items() if n == rows and names.parse(k)[0] == "time"]
    if given or not found:
        return None if given else (None, 1.0)
    if len(found) > 1:
        return None
    t = np.concatenate([x for x in source.pieces(found[0], 0, HEAD)]).astype(float)
    if t.size != head.n:
        return None
    seconds = (t.size - 1) / head.rate / (t[-1] - t[0])
    for unit in (1.0, 1e-3, 1e-6, 1e-9):
        if abs(seconds / unit - 1) < 0.01:
            return found[0], unit
    return None


assert HEAD < CHUNK
