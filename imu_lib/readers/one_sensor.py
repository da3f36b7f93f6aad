"""The columns of one file, and those of one of its sensors."""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import at_once, instances, streams
from imu_lib.readers.asking import Asked, Unnamed
from imu_lib.readers.meaning import INCREMENT, WORD
from imu_lib.readers.opening import read_raw
from imu_lib.readers.raw import Raw

#: A column that names an axis and no more, or has no name.
_BARE = re.compile(r"\W*(?:[xyz1-3](?:[ _-]?axis)?|axis[ _-]?[xyz]|column \d+)\W*", re.IGNORECASE)


def read_bare(path, columns, topic, units, options) -> Raw:
    """The columns of a file; x, y, z that name no sensor are of the one that a unit was given for
    while no other column is.
    """
    given = [k for k, u in units.items() if u]
    try:
        raw = read_raw(path, columns=columns, topic=topic)
    except instances.Several as error:
        raise at_once.of_several(error, units, options) from None
    except Asked as error:
        bare = None
        if isinstance(error, Unnamed) and len(given) == 1 and not columns:
            bare = _as_named(path, topic, given[0])
        if not bare or not all(_BARE.fullmatch(bare.headings[c]) for c in bare.axes(given[0])):
            # x, y, z of what is for the call to say
            raise at_once.of_columns(error, options) from None
        return bare
    unused = {c.name.strip().lower() for c in raw.described if c.read_as is None}
    missing = [k for k in given if not {k, INCREMENT[k]} & raw.kinds()]
    if columns or len(missing) != 1 or not {"x", "y", "z"} <= unused:
        return raw
    again = _as_named(path, topic, missing[0])
    return again if missing[0] in again.kinds() and raw.kinds() <= again.kinds() else raw


def _as_named(path, topic, kind: str) -> Raw:
    raw = read_raw(path, signal=kind, topic=topic)
    raw.notes += (
        f"x, y, z were read as the {WORD[kind]}, the one sensor that a unit was given for "
        f"(--{kind}-unit).",
    )
    return raw


def only(raw: Raw, kind: str) -> Raw:
    """The columns of one kind: the file was given as --gyro or --accel."""
    for other in [c for c in raw.columns if streams.kind_of(c) not in (None, kind)]:
        raw.drop(other, f"not of the {kind}")
        raw.columns.pop(other, None)
    if kind == "accel" and "time_accel" in raw.columns:
        raw.columns["time"] = raw.columns.pop("time_accel")
        raw.units["time"], raw.headings["time"] = (
            raw.units["time_accel"],
            raw.headings["time_accel"],
        )
    raw.columns.pop("time_accel", None)
    if not raw.kinds():
        raise InputError(f"{raw.source} holds no {kind} columns; it was given as --{kind}.")
    # rows in which this sensor has nothing are rows of the other one
    empty = streams.empty(raw, [kind])
    if 0.3 < empty.mean() < 1.0:
        streams.without(raw, np.flatnonzero(~empty))
    return raw
