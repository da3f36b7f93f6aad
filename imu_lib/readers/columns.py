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

from imu_lib.errors import InputError
from imu_lib.readers import by_rows, families, instances, names, twins
from imu_lib.readers.asking import (
    STAMPS,
    Heading,
    Unnamed,
    by_position,
    example,
    suggestion,
)
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
    said = (
        by_position(columns, len(headings), raw.source, signal)
        if columns
        else [
            _by_name(h, signal) if named else Meaning(why="the file has no header")
            for h in headings
        ]
    )
    told = [_by_kind(m, h, bool(columns)) for m, h in zip(said, headings)]
    told = numbered(raw, told, headings)
    if named and not columns:
        told = families.families(told, headings)
        families.turned(raw, told, headings)
    told = families.body_rates(habits(alpha(told), headings), headings)
    told, interval = intervals(raw, told, headings)
    if not columns:
        if by_rows.sensors(told, headings) is None or signal:
            told = _bare(raw, told, headings, signal, named, load)
        told = _preferred(raw, twins.with_gravity(told, headings, load), headings)
        long = by_rows.sensors(told, headings)
        if long is not None and not signal:
            return by_rows.pivoted(raw, long, told, headings, load)
    else:
        by_rows.refuse_mixture(raw, told, headings, load)
    raw.instances = instances.find(told, headings, load) if named else None
    wanted = [i for i, m in enumerate(told) if m.quantity]
    values = load(wanted)
    if named and not columns:
        letter_g(raw, told, headings, values)
        raw.unnamed_time = _unnamed_time(raw, told, headings, load)
    if interval is not None:
        add_up(raw, told, headings, values, interval)
    told = letter_t(told, headings, values)
    told = one_time(raw, told, headings, values)
    by_call = " (--columns)" if columns else ""
    _say_unused(raw, told, headings)
    for i, (m, heading) in enumerate(zip(told, headings)):
        if m.quantity is None or m.canonical is None:
            raw.skip(heading.name, m.why)
        elif m.quantity in SIGNALS and m.axis not in ("x", "y", "z"):
            raw.skip(heading.name, "its name holds no axis")
        else:
            raw.add(m.canonical, values[i], m.unit, heading.name, m.why + by_call)
    return raw


def _unnamed_time(raw: Raw, told: list[Meaning], headings, load) -> str | None:
    """The names to give where a column of an unknown name rises as a time does, and no other is one."""
    if raw.rate or any(m.quantity in ("time", "date", "clock", "counter") for m in told):
        return None
    free = [i for i, (m, h) in enumerate(zip(told, headings)) if m.why == names.UNKNOWN and h.kind == "number"]  # fmt: skip
    try:
        values = load(free) if free else {}
    except InputError:
        return None  # a damaged line in a column that nobody needs
    for i in free:
        if np.asarray(values[i]).dtype.kind in "fi" and (np.diff(values[i]) > 0).mean() > 0.9:
            said = list(told)
            said[i] = Meaning("time")
            return f"`{headings[i].name}` rises as a time does: {suggestion(said, headings)}"
    return None


def _say_unused(raw: Raw, told: list[Meaning], headings) -> None:
    """A word on columns that state a unit of rate or specific force and are not used, where the record
    has no such reading.
    """
    for kind, word in (("gyro", "gyro"), ("accel", "accelerometer")):
        there = {m.axis for m in told if m.quantity == kind and m.axis}
        if there:
            unknown = [h.name for m, h in zip(told, headings) if m.why == names.UNKNOWN and h.kind == "number"]  # fmt: skip
            if len(there) < 3 and unknown:
                raw.notes += (
                    f"Of the {word} {' and '.join(sorted(there))} alone was found; {', '.join(f'`{n}`' for n in unknown[:6])} are not used, their names are "
                    "not known here (--columns names columns by position).",
                )
            continue
        lost = [
            h.name
            for m, h in zip(told, headings)
            if (m.quantity is None and m.why == names.UNKNOWN or m.quantity == kind and not m.axis)
            and names.unit_of(h.unit or names.spelled_unit(h.name) or "") in names.UNITS[kind]
        ]
        if lost:
            said = list(told)
            for axis, i in zip("xyz", [i for i, h in enumerate(headings) if h.name in lost]):
                said[i] = Meaning(kind, axis, names.unit_of(headings[i].unit or names.spelled_unit(headings[i].name) or ""))  # fmt: skip
            raw.notes += (
                f"{', '.join(f'`{n}`' for n in lost[:4])} state a unit of the {word} and were not read; {suggestion(said, headings)} if they are.",
            )
            continue
        unknown = [
            h.name
            for m, h in zip(told, headings)
            if m.quantity is None and m.why == names.UNKNOWN and h.kind == "number"
        ]
        if len(unknown) >= 3:
            raw.notes += (
                f"No column was read as the {word}; {', '.join(f'`{n}`' for n in unknown[:6])} are not used, their names are not known here "
                "(--columns names columns by position).",
            )


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
    if told.quantity == "date" and heading.kind == "number" and not by_call:
        return Meaning("time", unit=told.unit, why="named a date, its values are numbers")
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
    if signal and any(m.quantity in ("time", "date", "clock") for m in told):
        xyz = [i for i in free if headings[i].kind == "number"]
        if len(xyz) == 3 and not named:
            for i, axis in zip(xyz, "xyz"):
                out[i] = Meaning(signal, axis, why=f"the file was given as --{signal}")
            return out
    width = len(headings)
    header = (
        f"its header ({', '.join(h.name for h in headings)[:80]}) names no gyro or accelerometer"
        if named
        else f"no header of {width} name{'s' * (width > 1)} right above {'them' if width > 1 else 'it'}"
    )
    one = (
        " (--gyro FILE or --accel FILE where it holds x, y, z of one sensor)"
        if len(free) in (3, 4) and not signal
        else ""
    )
    try:
        values = load([i for i, h in enumerate(headings) if h.kind == "number"])
    except InputError:
        values = None  # a damaged line is told when the columns are known
    raise Unnamed(
        f"{raw.source} has {width} column{'s' * (width > 1)} and {header}; name them by position with --columns, as in "
        f"{example(told, headings, values)}{one}."
    )


def _preferred(raw: Raw, told, headings) -> list[Meaning]:
    """Of several columns for one axis the one that such a name usually heads; asked for where two
    are equal. Increments give way to rates.
    """
    out = list(told)
    second: dict[str, tuple[int, int]] = {}
    for canonical in sorted({m.canonical for m in told if m.quantity in SIGNALS and m.axis}):
        there = [i for i, m in enumerate(told) if m.canonical == canonical]
        best = min(told[i].rank for i in there)
        first = [i for i in there if told[i].rank == best]
        if len(first) > 1:
            raise InputError(
                f"{raw.source}: both `{headings[first[0]].name}` and `{headings[first[1]].name}` would be {canonical}; "
                f"{suggestion(told, headings, first[1:])}."
            )
        for i in there:
            if i not in first:
                out[i] = Meaning(why=f"`{headings[first[0]].name}` is {canonical}")
                second.setdefault(canonical.rpartition("_")[0], (first[0], i))
    twins.say(raw, second, headings)
    for increment, rate in (("dtheta", "gyro"), ("dv", "accel")):
        if any(m.quantity == rate and m.axis for m in out):
            out = [
                Meaning(
                    why=f"increments; the {'rates' if rate == 'gyro' else 'specific force'} stand beside them"
                )
                if m.quantity == increment
                else m
                for m in out
            ]
    temperature = [i for i, m in enumerate(out) if m.quantity == "temperature"]
    if len(temperature) > 1:
        own = [i for i in temperature if out[i].rank <= 1]
        keep = own[0] if own else temperature[0]
        for i in temperature:
            if i != keep:
                out[i] = Meaning(why=f"`{headings[keep].name}` is the temperature")
    return out
