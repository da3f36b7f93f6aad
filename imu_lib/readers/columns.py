"""The one place that decides what the columns of a table are.

Every reader of tables hands over its headings (with the kind of values under each) and gets a
`Raw` back in which each column is used or listed with the reason why not. Names come first
(`names.meaning`), then neighbours (axes counted from 0 or 1, `alpha` beside `omega`, seconds with
their nanoseconds), then values (`T` that does not rise is a temperature).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from imu_lib.readers import (
    by_rows,
    families,
    formats,
    instances,
    names,
    preferred,
    question,
    summed,
    twins,
    unused,
)
from imu_lib.readers.asking import STAMPS, Asked, Heading, by_position
from imu_lib.readers.habits import alpha, habits, letter_g, numbered
from imu_lib.readers.names import SIGNALS, Meaning
from imu_lib.readers.raw import Raw
from imu_lib.readers.time_columns import add_up, intervals, letter_t, one_time


def decide(
    raw: Raw,
    headings: Sequence[Heading],
    load: Callable[[list[int]], dict[int, np.ndarray]],
    *,
    columns: str | Sequence[str] | None = None,
    signal: str | None = None,
    named: bool = True,
) -> Raw:
    """Fill `raw` from a table.

    Parameters
    ----------
    raw : Raw
        Empty; its source is named in messages.
    headings : sequence of Heading
        One for each column.
    load : callable
        Column numbers to their values.
    columns : str or sequence of str, optional
        Names by position that the caller gave; they win.
    signal : {"gyro", "accel", "temperature"}, optional
        What a bare x, y, z is.
    named : bool
        Whether the file has a header: otherwise `headings` are numbered and say nothing.

    Raises
    ------
    InputError
        Where the columns cannot be told; the sentence holds the names to give.
    """
    try:
        return _decided(raw, headings, load, columns, signal, named)
    except Asked as error:
        error.clock = "" if columns else question.clock_of(raw, headings, named, load)
        raise


def _decided(raw: Raw, headings, load, columns, signal, named: bool) -> Raw:
    if named and not columns:
        question.refuse_deviations(raw, headings, load)
    told = _told(raw, headings, columns, signal, named)
    told, interval = intervals(raw, told, headings)
    long = by_rows.by_call(told) if columns else by_rows.sensors(raw, told, headings, load)
    if not columns:
        if long is None or signal:
            told = _bare(raw, told, headings, signal, named, load)
        told = preferred.one_each(raw, twins.with_gravity(told, headings, load), headings, load)
    elif long is None:
        by_rows.refuse_mixture(raw, told, headings, load)
    if long is not None and not signal:
        return by_rows.pivoted(raw, long, told, headings, load)
    raw.instances = instances.find(told, headings, load) if named else None
    wanted = [i for i, m in enumerate(told) if m.quantity]
    values = load(wanted)
    if named and not columns:
        twins.add_gravity(raw, told, headings, values, load)
        letter_g(raw, told, headings, values)
        unused.spoiled(raw, told, headings, load)
        raw.unnamed_time = unused.unnamed_time(raw, told, headings, load)
    if interval is not None:
        add_up(raw, told, headings, values, interval)
    if not columns:
        told = letter_t(raw, told, headings, values)
    told = one_time(raw, told, headings, values)
    if named and not columns:
        told = summed.divided(raw, told, headings, values, load)
    unused.say(raw, told, headings)
    _fill(raw, told, headings, values, " (--columns)" if columns else "")
    formats.fix(raw, [h.name for h in headings] if named else [])
    return raw


def _told(raw: Raw, headings, columns, signal, named) -> list[Meaning]:
    """What each column is by the call or by its name, and by those beside it."""
    said = (
        by_position(columns, len(headings), raw.source, signal)
        if columns
        else [
            _by_name(h, signal) if named else Meaning(why="the file has no header")
            for h in headings
        ]
    )
    if columns and named:
        said = [_unit_of_heading(m, h) for m, h in zip(said, headings)]
    told = [_by_kind(m, h, bool(columns)) for m, h in zip(said, headings)]
    told = numbered(raw, told, headings)
    if named and not columns:
        told = families.behind(raw, families.values(told, headings), headings)
    if named and not columns:
        told = families.families(told, headings)
        families.turned(raw, told, headings)
    return families.body_rates(habits(alpha(told), headings), headings)


def _fill(raw: Raw, told, headings, values, by_call: str) -> None:
    """Every column taken in, or listed with the reason why not."""
    for i, (m, heading) in enumerate(zip(told, headings)):
        if m.quantity is None or m.canonical is None:
            raw.skip(heading.name, m.why)
        elif m.quantity in SIGNALS and m.axis not in ("x", "y", "z"):
            raw.skip(heading.name, "its name holds no axis")
        else:
            raw.add(m.canonical, values[i], m.unit, heading.name, m.why + by_call)


def _unit_of_heading(told: Meaning, heading: Heading) -> Meaning:
    """A column that --columns names without a unit keeps the one that its heading states."""
    if told.quantity not in names.UNITS or told.unit:
        return told
    unit = names.unit_of(heading.unit or names.spelled_unit(heading.name) or "")
    unit = unit or names.meaning(heading.name).unit
    return replace(told, unit=unit) if unit in names.UNITS[told.quantity] else told


def _by_name(heading: Heading, signal: str | None) -> Meaning:
    name = heading.name
    found = names.meaning(name, signal=signal)
    if heading.unit and found.quantity:
        unit = names.unit_of(heading.unit)
        return replace(found, unit=unit or heading.unit, why=f"{found.why}; row of units")
    if found.quantity is None and found.why == names.UNKNOWN:
        return names.by_unit(name, heading.unit) or found
    return found


def _by_kind(told: Meaning, heading: Heading, by_call: bool) -> Meaning:
    """What the look of the values says: dates and clocks are stamps, text is none of ours."""
    if by_call and told.quantity is None:
        return told
    if heading.kind in STAMPS and told.quantity in (None, "time", "date", "clock", "part"):
        quantity = "clock" if heading.kind == "clock" else "date"
        return Meaning(
            quantity,
            rank=told.rank,
            why=f"its values are {'clock times' if quantity == 'clock' else 'dates'}",
        )
    if heading.kind in ("text", *STAMPS) and told.quantity:
        if by_call:
            return told
        return Meaning(why=f"it holds {'text' if heading.kind == 'text' else 'dates'}")
    if told.quantity in ("date", "clock") and heading.kind == "number" and not by_call:
        return Meaning(
            "time", unit=told.unit, why=f"named a {told.quantity}, its values are numbers"
        )
    if heading.kind == "text":
        return Meaning(why="it holds text")
    if heading.kind == "empty" and told.quantity is None:
        return Meaning(why="it is empty" if told.why.startswith("its name") else told.why)
    return told


def _bare(raw: Raw, told, headings, signal, named, load) -> list[Meaning]:
    """A file whose columns are not named for a sensor: three or four numbers of a file given as
    one sensor's, else it is asked.
    """
    if any(m.quantity in SIGNALS and m.axis for m in told):
        return told
    free = [
        i
        for i, h in enumerate(headings)
        if h.kind in ("number", "empty") and told[i].quantity is None
    ]
    out = list(told)
    if signal == "temperature":
        if not named and len(headings) == 2 and len(free) == 2:
            return [
                Meaning("time", unit="s", why="first of two columns"),
                Meaning("temperature", why="second of two columns"),
            ]
        return told
    if signal and not named and len(free) in (3, 4):
        if len(free) == 4:
            out[free[0]] = Meaning("time", why="first of four columns")
        for i, axis in zip(free[-3:], "xyz"):
            out[i] = Meaning(signal, axis, why=f"the file was given as --{signal}")
        return out
    if signal and named and (three := families.one_triple(told, headings)):
        for axis, i in three.items():
            out[i] = Meaning(signal, axis, why=f"the file was given as --{signal}")
        return out
    if signal and any(m.quantity in ("time", "date", "clock") for m in told):
        xyz = [i for i in free if headings[i].kind == "number"]
        if len(xyz) == 3 and not named:
            for i, axis in zip(xyz, "xyz"):
                out[i] = Meaning(signal, axis, why=f"the file was given as --{signal}")
            return out
    raise question.unnamed(raw, told, headings, signal, named, load)
