"""A word on columns that are not used though they may be meant: a time or a sensor of an
unknown name.
"""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import fields, looks, names
from imu_lib.readers.asking import suggestion
from imu_lib.readers.meaning import WORD, Meaning
from imu_lib.readers.raw import Raw


def unnamed_time(raw: Raw, told: list[Meaning], headings, load) -> str | None:
    """The names to give where a column of an unknown name rises as a time does, and no other
    is one.
    """
    if raw.rate or any(m.quantity in ("time", "date", "clock", "counter") for m in told):
        return None
    free = [
        i
        for i, (m, h) in enumerate(zip(told, headings))
        if m.why == names.UNKNOWN and h.kind == "number"
    ]
    try:
        values = load(free) if free else {}
    except InputError:
        return None  # a damaged line in a column that nobody needs
    for i in free:
        if np.asarray(values[i]).dtype.kind in "fi" and looks.rises(values[i]):
            said = list(told)
            said[i] = Meaning("time")
            return (
                f"`{headings[i].name}` rises as a time does: "
                f"{suggestion(said, headings)}{_dropped(said, headings)}"
            )
    return None


def _dropped(told: list[Meaning], headings) -> str:
    """A word on three or more columns of numbers that a suggestion leaves out as unknown."""
    left = [h.name for m, h in zip(told, headings) if m.why == names.UNKNOWN and h.kind == "number"]
    if len(left) < 3:
        return ""
    return (
        f" (which leaves out {', '.join(f'`{n}`' for n in left[:6])}, whose names are not known "
        "here: put gyro_x, gyro_y, gyro_z or accel_x, accel_y, accel_z "
        "there if they are readings)"
    )


def say(raw: Raw, told: list[Meaning], headings) -> None:
    """A word on columns that state a unit of rate or specific force and are not used, where the
    record has no such reading.
    """
    for kind in ("gyro", "accel"):
        word = WORD[kind]
        there = {m.axis for m in told if m.quantity == kind and m.axis}
        if there:
            unknown = [
                h.name
                for m, h in zip(told, headings)
                if m.why == names.UNKNOWN and h.kind == "number"
            ]
            if len(there) < 3 and unknown:
                raw.notes += (
                    f"Of the {word} {' and '.join(sorted(there))} alone was found; "
                    f"{', '.join(f'`{n}`' for n in unknown[:6])} are not used, their names are "
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
                said[i] = Meaning(
                    kind,
                    axis,
                    names.unit_of(headings[i].unit or names.spelled_unit(headings[i].name) or ""),
                )
            raw.notes += (
                f"{', '.join(f'`{n}`' for n in lost[:4])} state a unit of the {word} and were not "
                f"read; {suggestion(said, headings)} if they are.",
            )
            continue
        unknown = [
            h.name
            for m, h in zip(told, headings)
            if m.quantity is None and m.why == names.UNKNOWN and h.kind == "number"
        ]
        if len(unknown) >= 3:
            raw.notes += (
                f"No column was read as the {word}; {', '.join(f'`{n}`' for n in unknown[:6])} "
                "are not used, their names are not known here "
                "(--columns names columns by position).",
            )


def spoiled(raw: Raw, told: list[Meaning], headings, load) -> None:
    """A word on columns that are named for readings and hold text, where no other column is that
    reading; InputError where a spreadsheet made dates of their numbers.
    """
    for i, h in enumerate(headings):
        named = names.meaning(h.name)
        if h.kind != "text" or named.quantity not in names.SIGNALS or not named.axis:
            continue
        if any(m.canonical == named.canonical for m in told):
            continue
        some = [str(x) for x in load([i])[i][:400]]
        dates = [x for x in some if fields.MONTH.match(x)]
        if dates:
            raise InputError(
                f"{raw.source}: `{h.name}` holds dates that a spreadsheet made of numbers "
                f"({dates[0]!r}: Sep 81 of 9.81); take the file that it was made from."
            )
        raw.notes += (f"`{h.name}` holds text ({some[0][:20]!r}) and was left out.",)


def lost(found) -> str | None:
    """A sentence on three or more columns of unknown names where a `Reading` has but one of gyro
    and accelerometer; None where it has both, or there are no such columns.
    """
    there = {name.partition("_")[0] for name in found.record.channel_names}
    missing = {"gyro", "accel"} - there
    left = [c.name for c in found.columns if c.read_as is None and c.evidence == names.UNKNOWN]
    if not missing or len(left) < 3:
        return None
    return (
        f"{found.record.source}: no column was read as the {WORD[max(missing)]}; "
        f"{', '.join(f'`{n}`' for n in left[:6])} were left out, their names are not known "
        "(columns= names columns by position)."
    )
