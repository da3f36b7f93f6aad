"""Records that are read one after the other and make one: logs of a folder, parts of a file."""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.long_record import grid
from imu_lib.long_record.record import FILL, Column, LongRecord, counted, without_counts
from imu_lib.readers.rising import NEAR


class Log:
    """What has been read so far.

    Parameters
    ----------
    path : path
        What the record is called.
    sink : object
        `write(columns)` takes name -> ndarray (k,), the next rows in SI.
    of_files : bool
        Whether its parts are files, of which each without stamps may have begun anew; else they
        are parts of one.
    """

    def __init__(self, path, sink, *, of_files=True):
        self.path, self.sink, self.of_files = path, sink, of_files
        self.rows, self.slots, self.rate = 0, 0, None
        self.names, self.first, self.clock, self.restarts = None, None, None, []
        self.steps, self.bad, self.notes = [], [], {}
        self.span, self.warm, self.began, self.begin, self.tick = {}, None, None, None, 0.0
        self.waiting, self.last, self.swapped = None, -1, 0
        self.seams: list[int] = []
        self.start, self.twice = None, []

    def append(self, file, record, start, tick=0.0):
        """The next record; `start` is its first stamp, s, or None; `tick`, s, is how well the
        clock tells it.
        """
        names = record.channel_names
        if self.names is None:
            self.names, self.rate, self.first = names, record.rate, file
            self.warm, self.began = record.temperature is not None, start
        if names != self.names:
            raise InputError(
                f"{file} has the channels {', '.join(names)}, {self.first} "
                f"{', '.join(self.names)}; logs of one record have the same."
            )
        if abs(record.rate / self.rate - 1) > 0.01:
            raise InputError(
                f"{file} has {record.rate:.6g} Hz, {self.first} {self.rate:.6g} Hz; logs of one "
                "record have one rate: move the file away."
            )
        begin = start, *(float(x[k]) for x in record.channels.values() for k in (0, -1))
        if begin == self.begin and not np.isnan(begin[1:]).any():
            raise InputError(
                f"{file} holds what the log before it holds, from its first stamp to its last "
                "value; remove one of the two."
            )
        self.begin = begin
        record, start = self._without_repeated(file, record, start)
        self.start = start
        self.tick = max(self.tick, tick)
        slots = record.slots()
        slots = slots + self.slots + self._between(file, start, tick, slots)
        columns = dict(record.channels)
        self.warm = self.warm and record.temperature is not None
        if record.temperature is not None:
            columns["temperature"] = record.temperature
        elif self.waiting is not None and "temperature" in self.waiting[0]:
            columns["temperature"] = np.full(record.n, np.nan)
        self._take(columns, slots)
        for name, x in record.channels.items():
            low, high = self.span.get(name, (np.inf, -np.inf))
            self.span[name] = min(low, np.nanmin(x)), max(high, np.nanmax(x))
        for note in record.notes if self.of_files else _of_reading(record):
            self.notes.setdefault(note, []).append(getattr(file, "name", str(file)))
        self.clock = None if start is None else start + record.slots()[-1] / record.rate
        if self.clock is not None:
            self.clock += 1.0 / record.rate
        self.slots = int(slots[-1]) + 1

    def _without_repeated(self, file, record, start):
        """(record, its first stamp) without rows at its head that are the last ones of the log
        before it, written twice.
        """
        if not self.of_files or None in (start, self.start, self.clock) or start <= self.start:
            return record, start
        k = round((self.clock - start) * self.rate)
        if not 0 < k < record.n or record.slots()[k] != k or k > self.rows:
            return record, start
        for name, x in record.channels.items():
            before = np.concatenate(list(self.sink.pieces(name, self.rows - k, self.rows)))
            if not np.array_equal(before, x[:k], equal_nan=True):
                return record, start
        self.twice.append((k, getattr(file, "name", str(file))))
        return record.take(slice(k, None)), start + k / record.rate

    def _take(self, columns, slots):
        """Write the next rows but for the last few, which wait for rows of the next part that
        changed places with them.
        """
        if self.waiting is not None:
            before, places = self.waiting
            columns = {n: np.concatenate([before[n], x]) for n, x in columns.items() if n in before}
            slots = np.concatenate([places, slots])
            order = np.argsort(slots, kind="stable")
            if (np.diff(order) < 0).any():
                columns, slots = {n: x[order] for n, x in columns.items()}, slots[order]
        cut = 0 if self.of_files else min(NEAR, len(slots))
        done = len(slots) - cut
        self._write({n: x[:done] for n, x in columns.items()}, slots[:done])
        self.waiting = ({n: x[done:] for n, x in columns.items()}, slots[done:]) if cut else None

    def _write(self, columns, slots):
        if not len(slots):
            return
        step = np.diff(slots, prepend=self.last)
        for i in np.flatnonzero(step > 1):
            self.steps.append((self.rows + int(i), int(step[i]) - 1))
        gone = [np.isnan(x) for n, x in columns.items() if n != "temperature"]
        self.bad.append(self.rows + np.flatnonzero(np.logical_or.reduce(gone)))
        self.sink.write(columns, slots / self.rate)
        self.rows += len(slots)
        self.last = int(slots[-1])

    def finish(self):
        """Write the rows that wait for a next part."""
        if self.waiting is not None:
            self._write(*self.waiting)
            self.waiting = None

    def _between(self, file, start, tick, slots):
        """Samples missing between what was read before and this: none where the clock's tick may
        hide them. Below zero where rows of the two parts changed places.
        """
        if self.slots == 0:
            return 0
        if start is None and self.clock is None and not self.of_files:
            return 0
        slack = 1.2 * tick if tick * self.rate > 0.4 else 0.0
        if start is not None and self.clock is not None and self.waiting is not None:
            back = round((self.clock - start) * self.rate)
            if 0 < back <= NEAR and self._fits(slots - back):
                self.swapped += 1
                return -back
        if start is None or self.clock is None or start < self.clock - 0.5 / self.rate - slack:
            self.restarts.append(getattr(file, "name", str(file)))
            self.seams.append(self.rows + (0 if self.waiting is None else len(self.waiting[1])))
            return FILL + 1
        apart = start - self.clock
        return max(round(apart * self.rate), 0) if apart > slack else 0

    def _fits(self, slots) -> bool:
        """Whether the first of these rows fill the places that the last ones before them left."""
        places = np.concatenate([self.waiting[1], self.slots + slots[:NEAR]])
        return bool((np.diff(np.sort(places)) == 1).all())

    def told(self) -> tuple[str, ...]:
        """What reading did, once for all parts that say it."""
        parts = "files" if self.of_files else "parts"
        notes = [] if self.of_files else list(counted(self.missing(), self.steps, self.rate))
        for note, files in self.notes.items():
            where = f"{', '.join(files[:3])}{' ...' * (len(files) > 3)}: " if self.of_files else ""
            notes.append(where + note)
        if self.twice:
            notes.append(
                f"The first {', '.join(f'{k:,}' for k, _ in self.twice[:3])} rows of "
                f"{', '.join(name for _, name in self.twice[:3])}"
                f"{' ...' * (len(self.twice) > 3)} are the last ones of the log before, written "
                "twice; they were used once."
            )
        if self.swapped:
            notes.append(
                f"Rows were out of order at {self.swapped} of the places where the file was read "
                "in parts, and put back by their stamps."
            )
        if self.restarts:
            one = len(self.restarts) == 1
            notes.append(
                f"{len(self.restarts)} of the {parts} begin{'s' * one} anew "
                f"({', '.join(self.restarts[:3])}{' ...' * (len(self.restarts) > 3)}): how long "
                f"the logger paused before {'it' if one else 'them'} is not known, and nothing is "
                "carried over."
            )
        return tuple(notes)

    def missing(self) -> int:
        """Rows without a number in some channel."""
        return sum(rows.size for rows in self.bad)

    def true_rate(self) -> float:
        """Samples per second, by the first and the last stamp where these belong together."""
        if self.of_files or self.restarts or self.clock is None:
            return self.rate
        span = self.clock - self.began
        rate = self.slots / span
        whole = round(rate)
        near = whole and abs(rate - whole) * span < max(0.5, 1.2 * self.tick * rate)
        return float(whole) if near else rate

    def state(self) -> dict:
        """What makes the LongRecord, but for its columns."""
        self.finish()
        bad = np.concatenate(self.bad) if self.bad else np.zeros(0)
        return {
            "rate": self.true_rate(),
            "rows": self.rows,
            "names": list(self.names),
            "flat": [n for n in self.names if not self.span[n][1] > self.span[n][0]],
            "warm": bool(self.warm),
            "notes": list(self.told()),
            "seams": self.seams,
            "steps": np.array(self.steps, np.int64).reshape(-1, 2),
            "bad": np.unique(bad).astype(np.int64),
        }


def _of_reading(record):
    """Notes of a part but for those that count, which are told of the whole, or once without a
    count.
    """
    told = without_counts(record.notes)
    return [re.sub(r"^[\d,]+ of [\d,]+ (time stamps)", r"Many \1", n) for n in told]


def record_of(state: dict, path, column) -> LongRecord:
    """The LongRecord of what was read. `column(name)` gives (source, name of the column)."""
    columns = {name: Column(*column(name), 1.0, 0.0) for name in state["names"]}
    return LongRecord(
        columns,
        state["rate"],
        grid.runs(state["rows"], state["steps"], state["bad"]),
        tuple(state["flat"]),
        path.stem if path.is_file() else path.name,
        str(path),
        tuple(state["notes"]),
        state["rows"],
        state["steps"],
        temperature=Column(*column("temperature"), 1.0, 0.0) if state["warm"] else None,
        seams=tuple(state["seams"]),
    )
