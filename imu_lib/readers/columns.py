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
from imu_lib.readers import by_rows, families, formats, instances, names, twins, unused
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
from imu_lib.readers.time_columns import add_up, intervals, letter_t, one_time, still


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
    told = _told(raw, headings, columns, signal, named)
    told, interval = intervals(raw, told, headings)
    if not columns:
        if by_rows.sensors(told, headings) is None or signal:
            told = _bare(raw, told, headings, signal, named, load)
        told = _preferred(raw, twins.with_gravity(told, headings, load), headings, load)
        long = by_rows.sensors(told, headings)
        if long is not None and not signal:
            return by_rows.pivoted(raw, long, told, headings, load)
    else:
        by_rows.refuse_mixture(raw, told, headings, load)
    raw.instances = instances.find(told, headings, load) if named else None
    wanted = [i for i, m in enumerate(told) if m.quantity]
    values = load(wanted)
    if named and not columns:
        twins.add_gravity(raw, told, headings, values, load)
        letter_g(raw, told, headings, values)
        raw.unnamed_time = unused.unnamed_time(raw, told, headings, load)
    if interval is not None:
        add_up(raw, told, headings, values, interval)
    told = letter_t(told, headings, values)
    told = one_time(raw, told, headings, values)
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
    raise _question(raw, told, headings, signal, named, load)


def _question(raw: Raw, told, headings, signal, named, load) -> Unnamed:
    """The error that asks for the names of columns that name no sensor."""
    free = [i for i, h in enumerate(headings) if h.kind in ("number", "empty") and told[i].quantity is None]  # fmt: skip
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
    damage = ""
    try:
        values = load([i for i, h in enumerate(headings) if h.kind == "number"])
    except InputError as error:
        values, damage = None, f" ({str(error).removeprefix(str(raw.source)).strip(' ,:.')})"
    if not named and (turns := instances.numbered(headings, values)):
        return Unnamed(
            f"{raw.source}: {turns}, as the number of a sensor does: its rows are of several sensors; write those of each into a file of its own and give "
            "--gyro FILE --accel FILE."
        )
    named_so = example(told, headings, values)
    if not any(f"{s}_" in named_so for s in SIGNALS):
        return Unnamed(
            f"{raw.source} has {width} column{'s' * (width > 1)} and {header}, and none of them holds numbers that could be one; give the file with the readings."
        )
    stamps = {n.partition("[")[0] for n in named_so.split(",")} & {"time", "date", "clock"}
    timed = stamps or any(m.quantity in ("time", "date", "clock") for m in told)
    rate = "" if timed or raw.rate else ", and the rate with --rate HZ"
    return Unnamed(
        f"{raw.source} has {width} column{'s' * (width > 1)} and {header}{_commas(headings, values)}{damage}; name them by position with --columns, as in "
        f"{named_so}{one}{rate}."
    )


def _commas(headings, values) -> str:
    """A word on whole numbers of which every other column, or nearly, has no sign: a decimal comma may
    be cut.
    """
    whole = [np.asarray(x) for x in (values or {}).values() if np.asarray(x).dtype.kind in "iu"]
    positive = sum(bool((x >= 0).all() and np.ptp(x) > 9) for x in whole)
    if len(whole) < 7 or len(whole) < len(headings) or positive < len(whole) // 2:
        return ""
    return " (if its commas are decimal marks too, write the file with points, or with semicolons between the fields)"


def _preferred(raw: Raw, told, headings, load) -> list[Meaning]:
    """Of several columns for one axis the one that such a name usually heads; asked for where two
    are equal. Increments give way to rates.
    """
    out = list(told)
    second: dict[str, tuple[int, int]] = {}
    skip: list[int] = []
    equal: list[tuple[str, int, int]] = []
    for canonical in sorted({m.canonical for m in told if m.quantity in SIGNALS and m.axis}):
        there = [i for i, m in enumerate(told) if m.canonical == canonical]
        best = min(told[i].rank for i in there)
        first = [i for i in there if told[i].rank == best]
        # the sensor's own reading goes before one that a device has worked on
        first.sort(key=lambda i: names.worked_on(headings[i].name))
        if len(first) > 1:
            equal.append((canonical, *first[:2]))
            skip += first[1:]
        for i in there:
            if i not in first:
                out[i] = Meaning(why=f"`{headings[first[0]].name}` is {canonical}")
                second.setdefault(canonical.rpartition("_")[0], (first[0], i))
    if equal:  # one sensor's three axes in the example, not a mixture
        canonical, one, other = equal[0]
        skip += still(told, headings, load)
        raise InputError(
            f"{raw.source}: both `{headings[one].name}` and `{headings[other].name}` would be {canonical}; "
            f"{suggestion(told, headings, skip)}."
        )
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
