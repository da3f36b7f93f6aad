"""A record on disk: its channels are read by pieces, its gaps are known, nothing is held."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from imu_lib import readers
from imu_lib.errors import InputError
from imu_lib.long_record import columns, grid
from imu_lib.readers import names, zarr_store
from imu_lib.readers.streams import slow_kind
from imu_lib.record import CHANNELS, Record
from imu_lib.stream import CHUNK, LONG

#: Rows that tell units, rate and columns.
HEAD = 1 << 17
#: Longest gap that is bridged by a straight line, samples, as `Record.continuous` has it.
FILL = 10
#: Part without a gap that a pass can go over, samples.
SHORTEST = 1 << 17


@dataclass(frozen=True)
class Column:
    """Where a channel lies: SI value = factor * (column's value) + zero."""

    source: object
    name: str
    factor: float
    zero: float


@dataclass(frozen=True)
class LongRecord:
    """A record at rest that stays on disk.

    Attributes
    ----------
    columns : dict of str to Column
    rate : float, Hz
    runs : ndarray of int, shape (k, 3)
        Rows start, stop without a missing sample, and the slot of the first on the even grid.
    flat : tuple of str
        Channels that never change.
    name, source : str
    notes : tuple of str
    rows : int
        Number of the row behind the last, those without a number counted.
    steps : ndarray of int, shape (g, 2)
        Row after each gap of the stamps, and samples missing before it.
    described : tuple
        What the readers say of the columns.
    temperature : Column or None
        Where the temperature lies, degC.
    begin : int
        The first row; others than 0 where the record was cut.
    """

    columns: dict = field(repr=False)
    rate: float
    runs: np.ndarray = field(repr=False)
    flat: tuple
    name: str
    source: str
    notes: tuple
    rows: int = 0
    steps: np.ndarray = field(repr=False, default_factory=lambda: np.zeros((0, 2), np.int64))
    described: tuple = ()
    temperature: Column | None = None
    begin: int = 0

    def __contains__(self, channel):
        return channel in self.columns

    def slot(self, row):
        """Number of a row on the even grid; an array for an array."""
        lost = np.concatenate([[0], np.cumsum(self.steps[:, 1])])
        return row + lost[np.searchsorted(self.steps[:, 0], row, side="right")]

    def row(self, slot):
        """The row at a number of the even grid, the next one where a gap is there."""
        lost = np.concatenate([[0], np.cumsum(self.steps[:, 1])])
        before = int(np.searchsorted(self.steps[:, 0] + lost[1:], slot, side="right"))
        at = int(slot - lost[before])
        if before < len(self.steps):
            at = min(at, int(self.steps[before, 0]))
        return min(at, self.rows)

    def second(self, row):
        """Moment of a row, s from the first."""
        return float(self.slot(row) - self.slot(self.begin)) / self.rate

    def time_gaps(self):
        """(start s, duration s, missing samples) of each gap in the stamps."""
        return tuple(
            (self.second(int(row) - 1), float(m + 1) / self.rate, int(m))
            for row, m in self.steps
            if self.begin < row < self.rows
        )

    def part(self, low, high) -> Record:
        """The rows low .. high - 1 as a record in memory, missing numbers as NaN."""
        channels = {name: _values(column, low, high) for name, column in self.columns.items()}
        temperature = self.temperature and _values(self.temperature, low, high)
        slots = self.slot(np.arange(low, high))
        even = slots[-1] - slots[0] == high - low - 1
        time = None if even else (slots - slots[0]) / self.rate
        return Record(channels, self.rate, time, temperature, self.name, self.source)

    def in_memory(self) -> Record:
        """All of it as a record in memory."""
        return replace(self.part(self.begin, self.rows), notes=self.notes)

    @property
    def channel_names(self):
        return tuple(self.columns)

    @property
    def n(self):
        """Samples that are there."""
        return int((self.runs[:, 1] - self.runs[:, 0]).sum())

    @property
    def duration(self):
        """Seconds covered, gaps included."""
        last = self.runs[-1]
        return float(last[2] + last[1] - last[0] - self.runs[0, 2]) / self.rate

    def gaps(self):
        """(start s, duration s, missing samples) of each gap."""
        ends = self.runs[:, 2] + self.runs[:, 1] - self.runs[:, 0]
        missing = self.runs[1:, 2] - ends[:-1]
        start = (ends[:-1] - 1 - self.runs[0, 2]) / self.rate
        return tuple(
            (float(s), float(m + 1) / self.rate, int(m))
            for s, m in zip(start, missing, strict=True)
        )

    def continuous(self):
        """Runs (k, 3) of the longest part without a gap of more than FILL samples."""
        ends = self.runs[:, 2] + self.runs[:, 1] - self.runs[:, 0]
        breaks = np.flatnonzero(self.runs[1:, 2] - ends[:-1] > FILL) + 1
        parts = np.split(np.arange(len(self.runs)), breaks)
        longest = max(parts, key=lambda p: ends[p[-1]] - self.runs[p[0], 2])
        return self.runs[longest]

    @property
    def longest(self):
        """Samples of the longest part without a gap of more than FILL samples."""
        runs = self.continuous()
        return int(runs[-1, 2] + runs[-1, 1] - runs[-1, 0] - runs[0, 2])

    def pieces(self, channel, runs):
        """The samples of these runs in order, SI, gaps between them bridged by straight lines;
        `channel` may be temperature.
        """
        column = self.temperature if channel == "temperature" else self.columns[channel]
        last = None
        for start, stop, slot in runs:
            for x in column.source.pieces(column.name, int(start), int(stop)):
                x = column.factor * x.astype(float) + column.zero
                if last is not None and slot > last[0]:
                    t = np.arange(last[0], slot)
                    yield np.interp(t, [last[0] - 1, slot], [last[1], x[0]])
                slot += x.size
                last = slot, float(x[-1])
                yield x


def _values(column, low, high):
    """The rows low .. high - 1 of a column, SI."""
    x = np.concatenate([y for y in column.source.pieces(column.name, low, high)])
    return column.factor * x.astype(float) + column.zero


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
    notes = head.notes + counted(laid.missing, laid.steps, laid.rate)
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


def counted(missing, steps, rate):
    """Sentences on what is missing: rows without a number, gaps (row, samples)."""
    out = ()
    if missing:
        out += (f"{missing:,} samples have no number in at least one channel.",)
    if len(steps):
        lost = [int(m) for _, m in steps]
        out += (
            f"{len(lost)} gap{'s' if len(lost) > 1 else ''} in the time stamps, "
            f"{sum(lost):,} samples missing; the longest lasts {(max(lost) + 1) / rate:.4g} s.",
        )
    return out


assert HEAD < CHUNK
