"""What a file holds before it is a record: its columns, what each is read as, and on what
evidence.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import names, spelling
from imu_lib.readers.meaning import INCREMENT, WORD

#: What a unit of increments would be of a rate.
_RATES = {"rad": "rad/s", "deg": "deg/s", "m/s": "m/s^2", "g*s": "g"}
KINDS = ("gyro", "accel", "dtheta", "dv")


@dataclass
class Column:
    """One column or array of a file.

    name: as the file has it. read_as: canonical name (gyro_x, time, ...; several for an array of
    axes), None where it is not used. unit: in which it was taken, None where it has none. evidence:
    what told, or why it is not used.
    """

    name: str
    read_as: str | None = None
    unit: str | None = None
    evidence: str = ""

    def to_json(self) -> dict:
        return {
            "column": self.name,
            "read_as": self.read_as,
            "unit": self.unit,
            "evidence": self.evidence,
        }


@dataclass
class Raw:
    """Columns by canonical name (see `names.parse`) with the unit each one's name states (None
    where it states none).

    described: every column of the file, used or not. contract: the file says by its keys that it
    is in SI. simulated: it says that imu_lib drew it. start: first stamp, s, in whatever time the
    file has; epoch: the same where it is absolute time. repeats: how many stamps repeated the one
    before. line: row number -> what to call it in a message. headings: canonical name -> the file's
    own.
    """

    source: str
    columns: dict[str, np.ndarray] = field(default_factory=dict)
    units: dict[str, str | None] = field(default_factory=dict)
    rate: float | None = None
    notes: tuple[str, ...] = ()
    contract: bool = False
    simulated: bool = False
    start: float | None = None
    epoch: float | None = None
    repeats: int = 0
    line: Callable[[int], str] = lambda row: f"sample {row + 1}"
    headings: dict[str, str] = field(default_factory=dict)
    described: list[Column] = field(default_factory=list)
    tick: float = 0.0  # s, within which the clock of the stamps tells when a row was taken
    received: bool = False  # the rows are in order of receipt, as in a bag
    held_rows: float = 1.0  # rows for which each reading stood, where they were taken once
    unnamed_time: str | None = None  # what to say of a column that may be the time
    subseconds: np.ndarray | None = None  # fraction of the clock's whole seconds, s
    instances: Any = None  # the column that tells several sensors apart, as `instances.find` has it
    has_topics: bool = False  # a topic chooses what is read
    legend: dict[str, str] = field(default_factory=dict)  # number -> sensor, as lines above say
    set_back: tuple[tuple[int, float], ...] = ()  # rows at which the clock fell, and by how much

    def add(
        self, canonical: str, values, unit: str | None, heading: str, evidence: str = ""
    ) -> None:
        """Take a column in; an array (n, 3) called gyro, accel, dtheta or dv is three of them."""
        values = np.asarray(values)
        if canonical in KINDS:
            if values.ndim != 2 or 3 not in values.shape:
                raise InputError(
                    f"{self.source}: `{heading}` has the shape {values.shape}; three axes, (n, "
                    "3), are expected."
                )
            values = values if values.shape[1] == 3 else values.T
            for i, axis in enumerate("xyz"):
                self._take(f"{canonical}_{axis}", values[:, i], unit, heading)
            read_as = ", ".join(f"{canonical}_{axis}" for axis in "xyz")
            self.described.append(Column(heading, read_as, unit, evidence))
            return
        if values.ndim == 2 and 1 in values.shape:
            values = values.ravel()
        if values.ndim != 1:
            raise InputError(
                f"{self.source}: `{heading}` has the shape {values.shape}; one value per sample "
                "is expected."
            )
        self._take(canonical, values, unit, heading)
        self.described.append(Column(heading, canonical, unit, evidence))

    def _take(self, canonical, values, unit, heading):
        if canonical in self.columns:
            raise InputError(
                f"{self.source}: both `{self.headings[canonical]}` and `{heading}` would be "
                f"{canonical}; say which is meant with --columns (names by position, - skips)."
            )
        self.columns[canonical] = values
        self.units[canonical] = unit
        self.headings[canonical] = heading

    def skip(self, heading: str, why: str) -> None:
        """List a column that is not used, with the reason."""
        self.described.append(Column(heading, None, None, why))

    def told(self, canonical: str, unit: str | None, evidence: str | None = None) -> None:
        """Write down the unit in which a column was taken, and on what evidence."""
        for column in self.described:
            if column.read_as and canonical in column.read_as.split(", "):
                column.unit = unit
                if evidence:
                    column.evidence = evidence

    def state(self, kind: str, unit: str, why: str, over: Collection[str | None] = (None,)) -> bool:
        """Take a unit for the axes of a kind that state none, or one of `over`, with the evidence.
        Whether it was taken.
        """
        there = self.axes(kind)
        if not there or any(self.units[c] not in over for c in there):
            return False
        for canonical in there:
            self.units[canonical] = unit
            for column in self.described:
                if column.read_as and canonical in column.read_as.split(", "):
                    column.evidence = f"{column.evidence.split('; ')[0]}; {unit} {why}"
        return True

    def drop(self, canonical: str, why: str) -> None:
        """Leave a column out after all."""
        self.columns.pop(canonical, None)
        for column in self.described:
            if column.read_as == canonical:
                column.read_as, column.unit, column.evidence = None, None, why

    def kinds(self) -> set[str]:
        return {c.rpartition("_")[0] for c in self.columns if c.rpartition("_")[0] in KINDS}

    def axes(self, kind: str) -> list[str]:
        return [f"{kind}_{a}" for a in "xyz" if f"{kind}_{a}" in self.columns]

    def rows(self) -> int:
        return len(next(iter(self.columns.values())))

    def unit(self, kind: str) -> str | None:
        """The one unit that the columns of a kind state, None where none does. InputError where
        they contradict or are unknown.
        """
        said = {
            u
            for c, u in self.units.items()
            if (c == kind or c.startswith(kind + "_")) and u is not None and c in self.columns
        }
        flag = f"--{kind}-unit" if kind in ("gyro", "accel", "time") else "--columns"
        if len(said) > 1:
            raise InputError(
                f"{self.source}: the {kind} columns state different units "
                f"({', '.join(sorted(said))}); give one with {flag}."
            )
        unit = said.pop() if said else None
        if unit in (None, "counts", "ticks", *names.UNITS[kind]):
            return unit
        inertial = kind in ("gyro", "accel")
        if inertial and spelling.scaled(unit, kind) and spelling.size_of_a_count(unit):
            return unit
        heading = self.headings.get(kind) or next(
            h for c, h in self.headings.items() if c.startswith(kind)
        )
        raise InputError(f"{self.source}: {_unknown(heading, unit, kind, flag)}")


def _unknown(heading: str, unit: str, kind: str, flag: str) -> str:
    """What is said of a unit that a kind of column cannot have, or that is not known."""
    inertial = kind in ("gyro", "accel")
    other = {"gyro": "accel", "accel": "gyro"}.get(kind, kind)
    if inertial and unit in names.UNITS[other]:
        return (
            f"`{heading}` is named a {WORD[kind]} and states {unit}, a unit of the other; say what "
            "each column is with --columns (names by position, - skips)."
        )
    if unit == "rps" and kind == "gyro":
        return (
            f"`{heading}` is in [rps], which is radians or revolutions per second; give {flag} "
            f"rad/s or {flag} rev/s."
        )
    scaled = spelling.scaled(unit, kind)
    if scaled and kind != "time" and (whole := spelling.of_range(unit)):
        return (
            f"`{heading}` is in [{unit}]; give {flag} {whole} if that is the range of the sensor, "
            f"{flag} {scaled} if it is the size of a count."
        )
    if scaled:
        return f"`{heading}` is in [{unit}]; give it as {flag} {scaled}."
    rate = _RATES.get(unit) if inertial else None
    if rate in names.UNITS[kind]:
        family = INCREMENT[kind]
        return (
            f"`{heading}` is in [{unit}], an increment; name it {family}_x, {family}_y or "
            f"{family}_z with --columns, or give {flag} {rate} if it is a rate of that size."
        )
    known = (
        " or ".join(spelling.USUAL[kind])
        if kind in spelling.USUAL
        else f"as one of {', '.join(names.UNITS[kind])}"
    )
    return f"the unit [{unit}] of `{heading}` is not known; give it with {flag} {known}."


def numbers(raw: Raw, canonical: str) -> np.ndarray:
    """A column as float64; infinite values are refused, a wholly empty column too."""
    x = raw.columns[canonical]
    if x.dtype.kind not in "fiub":
        raise InputError(
            f"{raw.source}, `{raw.headings[canonical]}`: holds {x.dtype} instead of numbers."
        )
    x = np.ascontiguousarray(x, dtype=np.float64)
    if x.size and not np.isfinite(x.sum()):
        infinite = np.flatnonzero(np.isinf(x))
        if infinite.size:
            raise InputError(
                f"{raw.source}, `{raw.headings[canonical]}`, {raw.line(int(infinite[0]))}: the "
                f"value is infinite ({infinite.size:,} of them); leave the field empty (NaN) where "
                "a sample is missing."
            )
        if np.isnan(x).all():
            raise InputError(
                f"{raw.source}, `{raw.headings[canonical]}`: holds no number at all; name the "
                "columns with --columns and skip it with -."
            )
    return x
