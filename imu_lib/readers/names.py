"""What a column or array is called: the quantity, the axis and the unit that its name says.

`gyro_x [deg/s]`, `w_RS_S_x [rad s^-1]`, `X Accel [x8004]`, `field.linear_acceleration.y`,
`#timestamp [ns]`, `Gyroskop x (rad/s)` and their likes become a `Meaning`. A name alone decides
nothing: `columns.decide` weighs it against its neighbours and the values below it.
"""

from __future__ import annotations

import re
from dataclasses import replace

from imu_lib.readers import directions, headings, lexicon
from imu_lib.readers.slips import misspelled
from imu_lib.readers.spelling import (
    ACCEL_UNITS,
    GYRO_UNITS,
    TIME_UNITS,
    UNITS,
    stated,
    unit_of,
)
from imu_lib.readers.tokens import SIGNALS, UNKNOWN, Meaning, read

__all__ = [
    "ACCEL_UNITS",
    "GYRO_UNITS",
    "SIGNALS",
    "TIME_UNITS",
    "UNITS",
    "UNKNOWN",
    "Meaning",
    "meaning",
    "parse",
    "stated",
    "unit_of",
]


def meaning(name: str, *, signal: str | None = None) -> Meaning:
    """What a column called `name` is.

    Parameters
    ----------
    name : str
        The heading, with or without a unit.
    signal : {"gyro", "accel", "temperature"}, optional
        What a bare x, y, z or 1, 2, 3 stands for: the file was given as that sensor's.
    """
    text, spelled, axis = headings.split(name)
    unit = None if spelled is None else unit_of(spelled) or spelled
    descriptor = re.search(r"x(80\d\d)", spelled or "") or re.search(r"\bx(80\d\d)\b", text)
    if descriptor:
        unit = None
        text = re.sub(r"\bx80\d\d\b", "", text).strip()
    key = headings.key(text)
    found = read(key, axis, signal, str(name))
    if found.quantity is None and found.why == UNKNOWN and (right := misspelled(key)):
        found = read(right, axis, signal, str(name))
        if found.quantity:
            found = replace(found, why=f"{found.why}, as it is misspelled")
    if descriptor and descriptor[1] in lexicon.DESCRIPTORS:
        kind, unit = lexicon.DESCRIPTORS[descriptor[1]]
        if kind is None:
            return replace(found, quantity=None, why="not an inertial reading")
        found = replace(found, quantity=kind, why=f"field descriptor 0x{descriptor[1]}")
    tail = None
    if unit is None and found.unit is None and not descriptor:
        found, unit, tail = _with_tail(found, key, axis, signal, str(name))
    if found.part == "interval":
        return replace(found, unit=unit or found.unit)
    if found.quantity is None:
        head, said = tail or (key, unit)
        return _by_unit_alone(head, said, found) or found
    return _in_unit(found, unit or found.unit, key)


#: A lone letter or word of a gyro before an axis and [rad] or [deg]: a rate whose second was left
#: out, or an increment, which is asked.
_RAD = re.compile(r"^((?:gyro|gyr|omega|w|g)_?[xyz])_(rad|deg)$")


def _with_tail(found: Meaning, key: str, axis, signal, name: str):
    """A meaning and its unit where that stands behind the name without brackets, or before the
    axis: gx_dps, accelerometer_m_s2_0, wx_rad; and the head and unit of such a name that says no
    more.
    """
    if axis is None and (bare := _RAD.match(key)):
        return read(bare[1], axis, signal, name), bare[2], None
    summed = lexicon.SUMMED.fullmatch(key)
    if summed:  # dtheta_x_rad, dvel_m_s_x
        shorter = read(summed[1] + summed[3], axis, signal, name)
        spelled = lexicon.SUMMED_UNIT[summed[2]]
        if spelled in UNITS.get(shorter.quantity, ()) and shorter.quantity in ("dtheta", "dv"):
            return shorter, spelled, None
    tail = lexicon.SUFFIX.search(key)
    if tail:
        head = key[: tail.start()]
        shorter = read(head, axis, signal, name)
        spelled = lexicon.SUFFIX_UNIT.get(tail[1]) or unit_of(tail[1].replace("_per_", "/"))
        fits = shorter.quantity and (
            shorter.quantity not in UNITS
            or spelled in UNITS[shorter.quantity]
            or spelled in ("counts", "rps")
        )
        if fits and (found.quantity is None or found.quantity == shorter.quantity):
            return shorter, spelled, None
        return found, None, (head, spelled)
    # the unit may stand before the axis: accelerometer_m_s2_0, gyro_rad_0, acc_g_x
    middle = re.match(r"^(.*?)_([xyz0-3])$", key) if axis is None else re.match(r"^(.*)$", key)
    inner = middle and lexicon.SUFFIX.search(middle[1])
    if inner or (middle and re.search(r"(gyro|gyr|omega)_(rad|deg)$", middle[1])):
        head = middle[1][: inner.start()] if inner else middle[1].rpartition("_")[0]
        word = inner[1] if inner else middle[1].rpartition("_")[2] + "_s"
        spelled = lexicon.SUFFIX_UNIT.get(word) or unit_of(word)
        shorter = read(head, axis or middle[2], signal, name)
        if shorter.quantity in SIGNALS and spelled in (*UNITS[shorter.quantity], "counts"):
            return shorter, spelled, None
    return found, None, None


def _by_unit_alone(head: str, unit: str | None, found: Meaning) -> Meaning | None:
    """What a unit says of a name that says nothing: Yaw [deg/s], nx_g, lateral_g, imu_degC."""
    if unit in GYRO_UNITS and head in directions.TURN:
        return Meaning("gyro", directions.TURN[head], unit, 2, why=f"a turn in {unit}")
    if found.why != UNKNOWN:
        return None
    if unit in ("degC", "degF") and set(head.split("_")) <= lexicon.OWN | {"die", "chip"}:
        return Meaning("temperature", unit=unit, rank=2, why=f"in {unit}")
    if unit in ("g", "mg") and (load := re.fullmatch(r"n_?([xyz])(?:_load_?factor)?", head)):
        return Meaning("accel", load[1], unit, why="named a load factor")
    if unit in ("g", "mg") and head in directions.FORCE:
        return Meaning("accel", directions.FORCE[head], unit, 2, why=f"a direction in {unit}")
    return None


def _in_unit(found: Meaning, unit: str | None, key: str) -> Meaning:
    """A meaning held against the unit that its heading states."""
    if unit and unit != "counts" and directions.ALONG in found.why:
        if unit not in UNITS.get(found.quantity, (unit,)):
            return Meaning(why=f"in {unit}: no {'rate' if found.quantity == 'gyro' else 'force'}")
    other = {"gyro": "accel", "accel": "gyro"}.get(found.quantity)
    if other and unit in UNITS[other] and re.fullmatch(r"[gaw]_?[xyz]", key):
        # a lone letter: what the unit says is what it is (Gx in g, ax in deg/s)
        found = replace(found, quantity=other, why=f"in {unit}, whatever its letter")
    if unit == "counts":
        found = replace(found, rank=max(found.rank, 2))  # a reading in a unit goes before it
    if found.quantity == "temperature" and unit == "deg":
        unit = None
    return replace(found, unit=unit)


def parse(name: str, *, signal: str | None = None) -> tuple[str | None, str | None]:
    """Canonical name and unit of a column called `name`; (None, None) where the name says nothing.

    Canonical: time, date, clock, temperature, index, gyro_x.., accel_x.., dtheta_x.., dv_x.., and
    gyro / accel for an array of three axes; axes that are numbers count from 1 here.
    """
    found = meaning(name, signal=signal)
    quantity = {"counter": "index", "part": None, "alpha": "accel"}.get(
        found.quantity, found.quantity
    )
    if quantity is None:
        return None, None
    axis = {"1": "x", "2": "y", "3": "z", "0": None}.get(found.axis, found.axis)
    if quantity in SIGNALS and found.axis:
        return (f"{quantity}_{axis}", found.unit) if axis else (None, None)
    return quantity, found.unit


def worked_on(name: str) -> bool:
    """Whether a heading says that a device has taken the bias or gravity out of a reading."""
    return bool(set(headings.key(headings.split(name)[0]).split("_")) & lexicon.WORKED_ON)


def free(name: str) -> bool:
    """Whether a heading says that gravity was taken out of an acceleration."""
    return bool(set(headings.key(headings.split(name)[0]).split("_")) & lexicon.FREE)


def stem(name: str) -> tuple[str, str | None]:
    """A heading without its unit, and the axis behind it."""
    text, _, axis = headings.split(name)
    found = re.match(r"^(.*?)[ _.-]?([xyzXYZ])$", text)
    if axis in ("x", "y", "z") or not found:
        return text, axis
    return found[1], found[2].lower()


def spelled_unit(name: str) -> str | None:
    """The unit that a heading spells, as it stands there."""
    return headings.split(name)[1]


def by_unit(name: str, unit: str | None) -> Meaning | None:
    """A heading that names an axis and states a unit, and no more: `X [rad/s]`, `Rotation X
    (deg/s)`, and the letters p, q, r of aeronautics. None where it is no such heading.
    """
    text, spelled, pointed = headings.split(name)
    found = unit_of(unit or spelled or "")
    kind = next((k for k in ("gyro", "accel") if found in UNITS[k]), None)
    if found in TIME_UNITS and re.fullmatch(r"x(?:[ _]?(?:value|axis))?", headings.key(text)):
        return Meaning("time", unit=found, why=f"an abscissa in {found}")
    if kind is None:
        return None
    tokens = [t for t in headings.key(text).split("_") if t]
    letter = lexicon.COMPACT.match(tokens[0]) if len(tokens) > 1 else None
    if letter and lexicon.KIND_OF.get(letter[1]) == kind:  # ax_Sensor_6D [m/s^2]
        return Meaning(kind, letter[2], found, 2, why=f"{letter[1]}{letter[2]} in {found}")
    axes = {"p": "x", "q": "y", "r": "z"} if kind == "gyro" else {}
    axis = pointed if pointed in ("x", "y", "z") else None
    rest = []
    for token in tokens:
        if axis is None and (token in ("x", "y", "z") or token in axes):
            axis = axes.get(token, token)
        else:
            rest.append(token)
    if axis is None and kind == "accel" and len(rest) == 1 and rest[0] in directions.FORCE:
        axis, rest = directions.FORCE[rest[0]], []  # surge [m/s^2]
    plain_words = {
        "rotation",
        "rot",
        "axis",
        "rate",
        "imu",
        "sensor",
        "body",
        "force",
        "value",
        "val",
        "data",
        "meas",
        "b",
    }
    if axis is None or set(rest) - plain_words:
        return None
    return Meaning(kind, axis, found, why=f"an axis in {found}")
