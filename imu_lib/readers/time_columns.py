"""Which of several columns is the time: seconds with their fraction, hours with minutes, the
sensor's own stamp before that of arrival.
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import looks, names, time_parts
from imu_lib.readers.asking import Asked, suggestion, units_too
from imu_lib.readers.names import Meaning
from imu_lib.readers.raw import Raw
from imu_lib.readers.spelling import UNITS

#: degC of a sensor at work, and by how much it warms within a record.
DEGREES, WARMS = (-60.0, 150.0), 30.0
_OF_SENSOR = re.compile(
    r"^\s*(?:t[ _.](?:imu|gyro|gyr|acc|accel|sensor|chip|mpu|die|board)|(?:imu|sensor)[ _.]t)\s*$",
    re.IGNORECASE,
)


def letter_t(raw: Raw, told, headings, values) -> list[Meaning]:
    """A column called T: the time where it rises from row to row, a temperature where it does not;
    T_imu and its likes are one where they do not rise at all. InputError where one that rises may
    be either, and no other column is the time.
    """
    out = list(told)
    for i, m in enumerate(told):
        if m.quantity != "time" or headings[i].kind != "number":
            continue
        x = np.asarray(values[i], dtype=float)
        if _OF_SENSOR.match(headings[i].name) and m.unit is None:
            if (np.diff(x) > 0).mean() < 0.7:
                out[i] = Meaning("temperature", why="a T that does not rise from row to row")
            continue
        if re.sub(r"[\[(].*", "", headings[i].name).strip() != "T":
            continue
        other = any(n.quantity in ("time", "date", "clock") for k, n in enumerate(told) if k != i)
        if not other and looks.rises(x):
            if m.unit is None and _maybe_degrees(x):
                raise _either(raw, told, headings, i, x)
            continue
        if np.nanmin(x) > -273 and np.nanmax(x) < 400:
            out[i] = Meaning(
                "temperature",
                unit=m.unit if m.unit in UNITS["temperature"] else None,
                why="called T, and it does not rise from row to row",
            )
    return out


def _maybe_degrees(x: np.ndarray) -> bool:
    """Whether numbers that rise may be those of a sensor that warms: none that begin at zero."""
    usual = float(np.median(np.diff(x)))
    return DEGREES[0] < x.min() and x.max() < DEGREES[1] and np.ptp(x) < WARMS and x[0] > 3 * usual


def _either(raw: Raw, told, headings, i: int, x: np.ndarray) -> Asked:
    """The question whether a column is the time or a temperature."""
    name = headings[i].name
    return Asked(
        f"{raw.source}: `{name}` may be the time or a temperature, it rises from {x[0]:.6g} to "
        f"{x[-1]:.6g}; {suggestion(told, headings)}{units_too(told)} (temperature in the place of "
        "time, and --rate HZ, if it is one)."
    )


def one_time(raw: Raw, told, headings, values) -> list[Meaning]:
    """One time out of several: seconds with their fraction put together, the sensor's own before
    that of arrival, one that states its unit before one that does not, numbers before the calendar.
    """
    told = time_parts.subseconds(
        raw, time_parts.fractions(told, headings, values), headings, values
    )
    told = _one_counter(told, headings, values)
    out = list(told)
    together = time_parts.put_together(told, headings, values)
    if together:
        return together
    out = time_parts.pairs(told, headings, values)
    times = [i for i, m in enumerate(out) if m.quantity == "time"]
    for i in [i for i in times if _empty(values[i])]:
        out[i] = Meaning(why="it holds no stamps")
    times = [i for i, m in enumerate(out) if m.quantity == "time"]
    dead = [i for i in times if _stands(values[i])]
    if len(dead) < len(times):
        for i in dead:
            out[i] = Meaning(why="its stamps do not move")
    times = [i for i, m in enumerate(out) if m.quantity == "time"]
    calendar = [i for i, m in enumerate(out) if m.quantity in ("date", "clock")]
    for i, m in enumerate(out):
        if m.quantity == "part":
            out[i] = Meaning(why="part of a date or clock")
    hours = [i for i, m in enumerate(told) if m.part == "hour" and headings[i].kind == "number"]
    if not times and not calendar and len(hours) == 1 and _fine(values.get(hours[0])):
        out[hours[0]] = Meaning("time", unit="h", why="hours with their fraction")
        times = hours
    if not times:
        return _one_calendar(out, headings, values)
    grouped = {out[i].group for i in times if out[i].group}
    if len(grouped) == 2 and len(times) == 2:
        for i in times:
            if out[i].group == "accel":
                raw.columns["time_accel"] = np.asarray(values[i])
                raw.units["time_accel"] = out[i].unit
                raw.headings["time_accel"] = headings[i].name
                out[i] = Meaning(why="the accelerometer's own stamps")
                raw.notes += (
                    f"The accelerometer has stamps of its own (`{headings[i].name}`); each gyro "
                    "sample goes with the nearest one.",
                )
        return out
    order = sorted(
        times, key=lambda i: (out[i].rank, out[i].unit is None, not _leads(out, headings, i), i)
    )
    order = _steadier(raw, order, out, headings, values)
    for i in order[1:]:
        out[i] = Meaning(why=f"`{headings[order[0]].name}` is the time")
    for i in calendar:
        out[i] = Meaning(why=f"`{headings[order[0]].name}` is the time")
    for i, m in enumerate(out):
        if m.quantity == "counter":
            out[i] = Meaning(why=f"a counter; `{headings[order[0]].name}` is the time")
    return out


def _one_counter(told, headings, values) -> list[Meaning]:
    """Of several counters the first that counts by one, or the first."""
    there = [i for i, m in enumerate(told) if m.quantity == "counter" and i in values]
    if len(there) < 2:
        return told
    by_one = [i for i in there if (np.diff(np.asarray(values[i], dtype=float)) == 1).mean() > 0.9]
    first = (by_one or there)[0]
    name = headings[first].name
    return [
        Meaning(why=f"`{name}` is the counter") if i in there and i != first else m
        for i, m in enumerate(told)
    ]


def _leads(told, headings, i: int) -> bool:
    """Whether a time stands right before a reading, where each channel has one of its own."""
    alike = sum(h.name == headings[i].name for h in headings) > 1
    return alike and i + 1 < len(told) and told[i + 1].quantity in names.SIGNALS


def _steadier(raw: Raw, order, told, headings, values) -> list[int]:
    """Of times of one standing the one that moves in even steps, where the first does not: that
    one is of the host. Which was taken is said.
    """
    first = order[0]
    equal = [
        i
        for i in order
        if (told[i].rank, told[i].unit) == (told[first].rank, told[first].unit)
        and _leads(told, headings, i) == _leads(told, headings, first)
    ]
    if len(equal) < 2:
        return order
    spread = {i: looks.unevenness(values[i]) for i in equal}
    best = min(equal, key=lambda i: spread[i])
    if spread[best] < 0.05 and spread[first] > 0.2:
        raw.notes += (
            f"`{headings[best].name}` was taken as the time, its steps are even; those of "
            f"`{headings[first].name}` are not.",
        )
        return [best, *(i for i in order if i != best)]
    return order


def _fine(x) -> bool:
    """Whether numbers rise in steps below one."""
    step = np.diff(np.asarray(x, dtype=float)) if x is not None else np.empty(0)
    return bool(step.size and (step >= 0).all() and 0 < step.mean() < 0.1)


def all_but_best(told, headings, load) -> list[int]:
    """Columns named a time other than the one that `one_time` would take."""
    times = [i for i, m in enumerate(told) if m.quantity == "time" and headings[i].kind == "number"]
    try:
        values = load(times) if len(times) > 1 else {}
    except InputError:
        return []  # a damaged line is told when the columns are known
    if not values:
        return []
    usable = [i for i in values if not _empty(values[i]) and not _stands(values[i])] or times
    rank = {
        i: (looks.unevenness(values[i]) == float("inf"), told[i].rank, told[i].unit is None, i)
        for i in usable
    }
    best = min(usable, key=lambda i: rank[i])
    return [i for i in times if i != best]


def _empty(x) -> bool:
    x = np.asarray(x)
    return x.dtype.kind == "f" and not np.isfinite(x).any()


def _stands(x) -> bool:
    """Whether numbers are all the same, as text never counts."""
    x = np.asarray(x)
    return x.dtype.kind in "fiu" and len(x) > 1 and not (x != x[0]).any()


def _one_calendar(out, headings, values) -> list[Meaning]:
    """One date and one clock; a moment (date and clock in one) needs no clock beside it."""
    for quantity in ("date", "clock"):
        there = sorted(
            (i for i, m in enumerate(out) if m.quantity == quantity),
            key=lambda i: (len(set(values.get(i, ())[:1000])) < 2, out[i].rank),
        )
        for i in there[1:]:
            out[i] = Meaning(why=f"`{headings[there[0]].name}` is the {quantity}")
    moment = [i for i, m in enumerate(out) if m.quantity == "date" and headings[i].kind == "moment"]
    if moment:
        for i, m in enumerate(out):
            if m.quantity == "clock":
                out[i] = Meaning(why=f"`{headings[moment[0]].name}` holds the clock too")
    for i, m in enumerate(out):
        if m.quantity == "counter" and any(n.quantity in ("date", "clock") for n in out):
            out[i] = Meaning(why="a counter; the clock is the time")
    return out


def intervals(raw: Raw, told, headings) -> tuple[list[Meaning], int | None]:
    """A column of intervals (dt_ms) as the time of a file that has no other and states no rate, and
    which column it is.
    """
    there = [i for i, m in enumerate(told) if m.part == "interval" and headings[i].kind == "number"]
    if len(there) != 1 or raw.rate or any(m.quantity in ("time", "date", "clock") for m in told):
        return told, None
    out = list(told)
    unit = names.unit_of(headings[there[0]].unit or "") or told[there[0]].unit
    out[there[0]] = Meaning("time", unit=unit, why="intervals, added up")
    return out, there[0]


def add_up(raw: Raw, told, headings, values, i: int) -> None:
    """Intervals, each since the sample before, become stamps from 0 on."""
    step = np.array(values[i])
    if step.dtype.kind not in "fiu" or not (
        np.isfinite(step[1:]).all() and (step[1:] >= 0).all() and step[1:].any()
    ):
        told[i] = Meaning(why="an interval between stamps, not one for every row")
        return
    step[0] = 0  # since the start of the device, or of nothing
    values[i] = np.cumsum(step, dtype=np.float64 if step.dtype.kind == "f" else np.int64)
    raw.notes += (
        f"`{headings[i].name}` holds the interval since the sample before; the intervals were "
        "added up to the time.",
    )
