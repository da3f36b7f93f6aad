"""Columns that are named by the caller, and the sentence that asks for their names."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import lexicon, looks, names
from imu_lib.readers.names import SIGNALS, Meaning

STAMPS = ("date", "clock", "moment")
LABEL = "sensor"  # what --columns calls a column that says whose reading a row is


class Asked(InputError):
    """What a column is, is open.

    clock: the question for the unit of the time of such a file, where that is open too.
    """

    clock: str = ""


class Unnamed(Asked):
    """The columns of a file name no sensor: x, y, z, or nothing at all."""


@dataclass(frozen=True)
class Heading:
    """name: as in the file. kind: number, date, clock, moment, text or empty. unit: of a row of
    units below the header, where there is one.
    """

    name: str
    kind: str = "number"
    unit: str | None = None


def example(told, headings, values: dict[int, np.ndarray] | None = None) -> str:
    """Names by position for columns that say nothing: clocks and text as they are, then the numbers
    as they most often stand; the accelerometer first where the first three have the steadier
    length.
    """
    out = []
    numbers = [
        i
        for i, h in enumerate(headings)
        if h.kind in ("number", "empty")
        and (told[i].quantity is None or told[i].quantity in SIGNALS and not told[i].axis)
        and told[i].why not in lexicon.NOT.values()
    ]
    rising = None
    if values:
        numbers = [i for i in numbers if i in values and looks.moves(values[i])] or numbers
        rising = next((i for i in numbers if i in values and looks.rises(values[i])), None)
        if rising is not None and len(numbers) != 6:
            numbers = [rising, *(i for i in numbers if i != rising)]
    order = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
    stamped = any(h.kind in STAMPS for h in headings) or any(m.quantity == "time" for m in told)
    if not stamped and (
        rising is not None and len(numbers) != 6 or values is None and len(numbers) not in (1, 3, 6)
    ):
        order = ["time", *order]
    triples = [n for n in numbers if order[0] != "time" or n != numbers[0]][:6]
    force = [told[i].quantity for i in triples[:3]] == ["accel"] * 3
    if values and len(triples) in (3, 6) and not force:
        data = [values[i] for i in triples]
        force = looks.steadier(data[:3], data[3:]) if data[3:] else looks.is_gravity(data)
    if force:
        order = [
            *[o for o in order if o == "time"],
            "accel_x",
            "accel_y",
            "accel_z",
            "gyro_x",
            "gyro_y",
            "gyro_z",
        ]
    fill = dict(zip(numbers, order + ["-"] * len(numbers)))
    fill = {i: _increment(n, headings[i].name, headings) for i, n in fill.items()}
    stamps: list[str] = []
    fill.update(_lettered(headings, numbers, order))
    for i, (m, h) in enumerate(zip(told, headings)):
        name = fill.get(i)
        if m.quantity in ("time", "date", "clock"):
            enough = m.quantity in stamps or "time" in stamps or m.quantity == "time" and stamps
            out.append("-" if enough else m.quantity)  # one time is enough
            stamps.append(m.quantity)
        elif name:
            out.append(name)
        elif h.kind in STAMPS:
            out.append("clock" if h.kind == "clock" else "date")
        else:
            out.append(
                m.canonical if m.canonical in ("time", "temperature", "date", "clock") else "-"
            )
    return ",".join(out)


def _increment(name: str, heading: str, headings) -> str:
    """The name of an increment where the columns are called theta and vel and a dt stands
    beside them.
    """
    if "dt" not in {h.name.strip().lower() for h in headings}:
        return name
    if re.match(r"theta\b|theta_", heading.lower()) and name.startswith("gyro"):
        return name.replace("gyro", "dtheta") + "[rad]"
    if re.match(r"vel\b|vel_", heading.lower()) and name.startswith("accel"):
        return name.replace("accel", "dv") + "[m/s]"
    return name


def _lettered(headings, numbers, order) -> dict[int, str]:
    """Names for columns that are called x, y, z in whatever order: three, or twice three."""
    letter = {i: headings[i].name.strip().lower()[:1] for i in numbers}
    bare = [
        i for i in numbers if re.fullmatch(r"[xyz](?:[._ ]?\d)?", headings[i].name.strip().lower())
    ]
    out = {i: "-" for i in numbers if i not in bare}
    if len(bare) not in (3, 6):
        return {}
    sensors = [o[:-2] for o in order if o.endswith("_x")]
    for k in range(0, len(bare), 3):
        if sorted(letter[i] for i in bare[k : k + 3]) != ["x", "y", "z"]:
            return {}
        out.update({i: f"{sensors[k // 3]}_{letter[i]}" for i in bare[k : k + 3]})
    return out


def suggestion(told, headings, skip: Sequence[int] = ()) -> str:
    """`--columns ...` as the file would be read when the columns of `skip` are left out."""
    taken: set[str] = set()
    out = []
    numbers = 0
    for i, (m, _) in enumerate(zip(told, headings)):
        axis = m.axis
        if m.axis and m.axis.isdigit():
            axis = "xyz"[min(int(m.axis), 2)]
        name = (
            f"{m.quantity}_{axis}"
            if m.quantity in SIGNALS and axis in ("x", "y", "z")
            else m.quantity
        )
        if (
            i in skip
            or name is None
            or name in taken
            or name in (*SIGNALS, "part", "counter", "alpha")
        ):
            out.append("-")
            continue
        taken.add(name)
        numbers += 1
        out.append(f"{name}[{m.unit}]" if m.unit and name != "clock" else name)
    return f"say which is meant with --columns, as in --columns '{','.join(out)}'"


def units_too(told, skip: Sequence[int] = ()) -> str:
    """A word on the units and the rate that the columns of `suggestion` leave open."""
    left = [m for i, m in enumerate(told) if i not in skip]
    kinds = [
        k for k in ("gyro", "accel") if any(m.quantity == k and m.axis and not m.unit for m in left)
    ]
    out = " with " + " and ".join(f"--{k}-unit" for k in kinds) if kinds else ""
    timed = any(m.quantity in ("time", "date", "clock", "part") for m in left)
    return out + ("" if timed else " and the rate with --rate HZ")


def by_position(
    columns: str | Sequence[str], found: int, source: str, signal: str | None
) -> list[Meaning]:
    """What each of `found` columns is, from the names the caller gave. InputError where they do not
    fit.
    """
    given = (
        [c.strip() for c in columns.split(",")]
        if isinstance(columns, str)
        else [str(c).strip() for c in columns]
    )
    if len(given) != found:
        raise InputError(
            f"{source} has {found} columns but --columns names {len(given)}; name every one by "
            "position, - skips."
        )
    out = []
    for name in given:
        if name in ("-", ""):
            out.append(Meaning(why="skipped by --columns"))
            continue
        if LABEL in given and name in (LABEL, "x", "y", "z"):
            group, axis = (LABEL, None) if name == LABEL else ("", name)
            out.append(Meaning(axis=axis, why=f"--columns names it {name}", group=group))
            continue
        told = names.meaning(name, signal=signal)
        if (
            told.canonical is None
            or told.quantity in SIGNALS
            and not told.axis
            or told.quantity == "part"
        ):
            raise InputError(
                f"--columns: {name!r} is no column name{_nearest(name)}; use time, date, clock, "
                "temperature, counter, gyro_x .. gyro_z, accel_x .. accel_z, "
                "dtheta_x .. dtheta_z, dv_x .. dv_z or -."
            )
        if _is_slip(name, told):
            raise InputError(
                f"--columns: {name!r} looks like a slip for {told.canonical}; write "
                f"{told.canonical}, or - to skip it."
            )
        out.append(replace(told, why=f"--columns names it {name}"))
    by_rows = {m.axis for m in out if m.quantity is None} >= {"x", "y", "z"}
    if not by_rows and not any(m.quantity in SIGNALS for m in out):
        raise InputError("--columns names no signal; at least one of gyro_x .. accel_z is needed.")
    return out


#: Words that --columns takes; what merely resembles one is a slip, not a name.
_WORDS = ("time", "date", "clock", "temperature", "counter", "gyro", "accel", "dtheta", "dv")
_SHORT = ("acc", "gyr")


def _word(name: str) -> str:
    return re.sub(r"[_ .-]?[xyz0-3]$", "", re.sub(r"[\[(].*$", "", name).strip().lower())


def _is_slip(name: str, told: Meaning) -> bool:
    """Whether a name that the call gives is a misspelled one, which a file's heading may be."""
    word = _word(name)
    if word in (*_WORDS, *_SHORT):
        return False
    return "misspelled" in told.why or bool(difflib.get_close_matches(word, _WORDS, 1, 0.75))


def _nearest(name: str) -> str:
    """The name that was likely meant, ready to be put into the sentence; empty where none is
    near.
    """
    word, axis = _word(name), re.search(r"[xyz]$", re.sub(r"[\[(].*$", "", name).strip().lower())
    near = difflib.get_close_matches(word, _WORDS, 1, 0.6)
    if not near:
        return ""
    signal = near[0] in (*SIGNALS, "dtheta", "dv")
    return f" ({near[0]}{f'_{axis[0]}' if axis and signal else ''} is near)"
