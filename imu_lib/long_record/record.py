"""A record on disk: its channels are read by pieces, its gaps are known, nothing is held."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from imu_lib.arrays import Array
from imu_lib.record import Record

#: Longest gap that is bridged by a straight line, samples, as `Record.continuous` has it.
FILL = 10
#: Part without a gap that a pass can go over, samples.
SHORTEST = 1 << 17


class Source(Protocol):
    """A file whose columns are read by pieces."""

    def pieces(self, name: str, start: int, stop: int) -> Iterable[Array]:
        """The numbers start .. stop - 1 of a column, in order."""
        ...


@dataclass(frozen=True)
class Column:
    """Where a channel lies: SI value = factor * (column's value) + zero."""

    source: Source
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
    seams : tuple of int
        Rows before which the logger began anew, after a pause of unknown length.
    """

    columns: dict[str, Column] = field(repr=False)
    rate: float
    runs: np.ndarray = field(repr=False)
    flat: tuple[str, ...]
    name: str
    source: str
    notes: tuple[str, ...]
    rows: int = 0
    steps: np.ndarray = field(repr=False, default_factory=lambda: np.zeros((0, 2), np.int64))
    described: tuple[Any, ...] = ()
    temperature: Column | None = None
    begin: int = 0
    seams: tuple[int, ...] = ()

    def __contains__(self, channel: object) -> bool:
        return channel in self.columns

    def slot(self, row: Any) -> Any:
        """Number of a row on the even grid; an array for an array."""
        lost = np.concatenate([[0], np.cumsum(self.steps[:, 1])])
        return row + lost[np.searchsorted(self.steps[:, 0], row, side="right")]

    def row(self, slot: int) -> int:
        """The row at a number of the even grid, the next one where a gap is there."""
        lost = np.concatenate([[0], np.cumsum(self.steps[:, 1])])
        before = int(np.searchsorted(self.steps[:, 0] + lost[1:], slot, side="right"))
        at = int(slot - lost[before])
        if before < len(self.steps):
            at = min(at, int(self.steps[before, 0]))
        return min(at, self.rows)

    def second(self, row: int) -> float:
        """Moment of a row, s from the first."""
        return float(self.slot(row) - self.slot(self.begin)) / self.rate

    def time_gaps(self) -> tuple[tuple[float, float, int], ...]:
        """(start s, duration s, missing samples) of each gap in the stamps; a pause of unknown
        length is none.
        """
        return tuple(
            (self.second(int(row) - 1), float(m + 1) / self.rate, int(m))
            for row, m in self.steps
            if self.begin < row < self.rows and row not in self.seams
        )

    def part(self, low: int, high: int) -> Record:
        """The rows low .. high - 1 as a record in memory, missing numbers as NaN."""
        channels = {name: _values(column, low, high) for name, column in self.columns.items()}
        warmth = self.temperature
        temperature = None if warmth is None else _values(warmth, low, high)
        slots = self.slot(np.arange(low, high))
        even = slots[-1] - slots[0] == high - low - 1
        time = None if even else (slots - slots[0]) / self.rate
        seams = tuple(row - low for row in self.seams if low < row < high)
        return Record(channels, self.rate, time, temperature, self.name, self.source, (), seams)

    def in_memory(self) -> Record:
        """All of it as a record in memory."""
        return replace(self.part(self.begin, self.rows), notes=self.notes)

    @property
    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.columns)

    @property
    def n(self) -> int:
        """Samples that are there."""
        return int((self.runs[:, 1] - self.runs[:, 0]).sum())

    @property
    def duration(self) -> float:
        """Seconds covered, gaps included."""
        last = self.runs[-1]
        return float(last[2] + last[1] - last[0] - self.runs[0, 2]) / self.rate

    def gaps(self) -> tuple[tuple[float, float, int], ...]:
        """(start s, duration s, missing samples) of each gap."""
        ends = self.runs[:, 2] + self.runs[:, 1] - self.runs[:, 0]
        missing = self.runs[1:, 2] - ends[:-1]
        start = (ends[:-1] - 1 - self.runs[0, 2]) / self.rate
        return tuple(
            (float(s), float(m + 1) / self.rate, int(m))
            for s, m in zip(start, missing, strict=True)
        )

    def continuous(self) -> Array:
        """Runs (k, 3) of the longest part without a gap of more than FILL samples."""
        ends = self.runs[:, 2] + self.runs[:, 1] - self.runs[:, 0]
        breaks = np.flatnonzero(self.runs[1:, 2] - ends[:-1] > FILL) + 1
        parts = np.split(np.arange(len(self.runs)), breaks)
        longest = max(parts, key=lambda p: ends[p[-1]] - self.runs[p[0], 2])
        return self.runs[longest]

    @property
    def longest(self) -> int:
        """Samples of the longest part without a gap of more than FILL samples."""
        runs = self.continuous()
        return int(runs[-1, 2] + runs[-1, 1] - runs[-1, 0] - runs[0, 2])

    def pieces(self, channel: str, runs: Array) -> Iterator[Array]:
        """The samples of these runs in order, SI, gaps between them bridged by straight lines;
        `channel` may be temperature.
        """
        column = self.temperature if channel == "temperature" else self.columns[channel]
        assert column is not None, "the record has no temperature"
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


def _values(column: Column, low: int, high: int) -> Array:
    """The rows low .. high - 1 of a column, SI."""
    x = np.concatenate([y for y in column.source.pieces(column.name, low, high)])
    return column.factor * x.astype(float) + column.zero


def without_counts(notes: Iterable[str]) -> tuple[str, ...]:
    """The notes on a part of a record but for those that count, which `counted` tells of all."""
    return tuple(n for n in notes if "samples missing" not in n and "no number in" not in n)


def counted(missing: int, steps: Array, rate: float) -> tuple[str, ...]:
    """Sentences on what is missing: rows without a number, gaps (row, samples)."""
    out: tuple[str, ...] = ()
    if missing:
        out += (f"{missing:,} samples have no number in at least one channel.",)
    if len(steps):
        lost = [int(m) for _, m in steps]
        out += (
            f"{len(lost)} gap{'s' if len(lost) > 1 else ''} in the time stamps, "
            f"{sum(lost):,} samples missing; the longest lasts {(max(lost) + 1) / rate:.4g} s.",
        )
    return out
