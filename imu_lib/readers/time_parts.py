"""Parts of one stamp in several columns: seconds with their fraction, a clock with its
milliseconds, hours with minutes and seconds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.readers import names
from imu_lib.readers.names import Meaning
from imu_lib.readers.raw import Raw

#: Units of a part of a second in one.
PER_SECOND = {"ns": 1_000_000_000, "us": 1_000_000, "ms": 1_000, "cs": 100}


def pairs(told, headings, values) -> list[Meaning]:
    """Whole seconds and a fraction that stays below one second put together in the former's
    column.
    """
    out = list(told)
    times = [i for i, m in enumerate(told) if m.quantity == "time"]
    for whole in times:
        for sub in times:
            if not is_pair(out[whole], out[sub], values.get(whole), values.get(sub), whole, sub):
                continue
            unit = out[sub].unit
            factor = PER_SECOND[unit]
            seconds = np.rint(np.asarray(values[whole], dtype=np.float64)).astype(np.int64)
            rest = np.rint(np.asarray(values[sub], dtype=np.float64)).astype(np.int64)
            values[whole] = seconds * factor + rest
            out[sub] = Meaning(why=f"its {unit} were added to `{headings[whole].name}`")
            out[whole] = replace(
                out[whole],
                unit=unit,
                rank=min(out[whole].rank, 1) - 1 if out[whole].rank else 0,
                why=f"seconds, with the {unit} of `{headings[sub].name}`",
            )
            break
    return out


def is_pair(whole: Meaning, sub: Meaning, seconds, fraction, a: int, b: int) -> bool:
    """Whether two columns are the seconds and the fraction of one stamp: whole seconds, and a
    fraction that stays below one second.
    """
    if a == b or sub.unit not in PER_SECOND or sub.part != "sub" or seconds is None:
        return False
    if whole.unit not in ("s", None) or whole.rank != sub.rank:
        return False
    seconds, fraction = np.asarray(seconds, dtype=float), np.asarray(fraction, dtype=float)
    if not (np.isfinite(seconds).all() and np.isfinite(fraction).all()) or len(seconds) < 2:
        return False
    limit = PER_SECOND[sub.unit]
    integers = (seconds == np.rint(seconds)).all() and seconds.max() < 1e11
    falls = (np.diff(fraction) < 0).any() or (seconds == seconds[0]).all()
    return bool(integers and fraction.min() >= 0 and fraction.max() < limit and falls)


def fractions(told, headings, values) -> list[Meaning]:
    """Fractions of a second, decimal ones or in units of 2^-32 s as network clocks count them, as
    nanoseconds.
    """
    out = list(told)
    for i, m in enumerate(told):
        if m.unit != "fraction":
            continue
        x = np.asarray(values[i])
        whole = x.dtype.kind in "iu" or (x.dtype.kind == "f" and (x == np.rint(x)).all())
        if x.dtype.kind in "iuf" and np.isfinite(x).all() and len(x) and x.min() >= 0:
            if not whole and x.max() < 1:
                values[i] = np.rint(x * 1e9).astype(np.int64)
                out[i] = replace(m, unit="ns", why=f"{m.why}, a fraction of a second")
                continue
            if whole and 2**31 < x.max() < 2**32:
                values[i] = np.rint(x * (1e9 / 2**32)).astype(np.int64)
                out[i] = replace(m, unit="ns", why=f"{m.why}, in units of 2^-32 s")
                continue
        out[i] = Meaning(why="a fraction, of what is not known here")
    return out


def subseconds(raw: Raw, told, headings, values) -> list[Meaning]:
    """A clock of whole seconds with its milliseconds (or less) in a column of their own."""
    clocks = [i for i, m in enumerate(told) if m.quantity in ("date", "clock") and i in values]
    moving = [i for i in clocks if ":" in str(values[i][0]) and "." not in str(values[i][0])]
    if not moving:
        return told
    out = list(told)
    for i, m in enumerate(told):
        if m.quantity != "time" or m.unit not in ("ms", "us", "ns") or m.part != "sub":
            continue
        x = np.asarray(values[i], dtype=float)
        limit = PER_SECOND[m.unit]
        if np.isfinite(x).all() and x.min() >= 0 and x.max() < limit and (np.diff(x) < 0).any():
            raw.subseconds = x / limit
            out[i] = Meaning(why=f"its {m.unit} were added to `{headings[moving[0]].name}`")
            break
    return out


def put_together(out, headings, values) -> list[Meaning] | None:
    """A clock in columns of hours, minutes and seconds, put together in the one of the seconds;
    None where there is none.
    """
    have = {out[i].part: i for i, m in enumerate(out) if m.quantity == "part"}
    times = [i for i, m in enumerate(out) if m.quantity == "time"]
    second = [
        i
        for i in times
        if out[i].unit == "s"
        and np.isfinite(values[i]).any()
        and np.nanmin(values[i]) >= 0
        and np.nanmax(values[i]) <= 60.0
    ]
    if not {"hour", "minute"} <= set(have) or not second:
        return None
    sub = [i for i in times if out[i].unit in ("ms", "us", "ns") and out[i].part == "sub"]
    place = second[0]
    total = 3600.0 * np.asarray(values[have["hour"]], float) + 60.0 * np.asarray(
        values[have["minute"]], float
    )
    total = total + np.asarray(values[place], float)
    for i in sub[:1]:
        total = total + np.asarray(values[i], float) * names.TIME_UNITS[out[i].unit]
    # past midnight the clock begins anew
    values[place] = total + 86_400.0 * np.cumsum(np.r_[0, np.diff(total) < -43_200.0])
    used = [have["hour"], have["minute"], place, *sub[:1]]
    out = list(out)
    for i, m in enumerate(out):
        if m.quantity in ("part", "time", "date", "clock", "counter") and i != place:
            out[i] = Meaning(
                why=f"put together with `{headings[place].name}`"
                if i in used
                else "hours, minutes and seconds are the time"
            )
    out[place] = replace(out[place], why="hours, minutes and seconds of several columns")
    return out
