"""Dates and clocks that are written as one number: 105958.01 is 10:59:58.01, 20210304105958010 the
same on 4 March 2021.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np


class Written(NamedTuple):
    """stamp: whole or fractional numbers of `unit`. what: what the numbers were."""

    stamp: np.ndarray
    unit: str
    what: str


def seconds(stamp: np.ndarray, unit: str | None) -> Written | None:
    """The time that such numbers tell; None where they count something.

    A clock is told from a count by its unit (hhmmss), or where every jump at a full minute or hour
    closes when the digits are read as a clock.
    """
    if re.fullmatch(r"h+m+s+(\.s+)?", str(unit or "").lower()):
        return Written(_clock(stamp), "s", "clock times as one number (hhmmss)")
    if unit not in (None, "s", "ms", "ticks"):
        return None
    found = _date(stamp)
    if found is not None:
        return found
    if unit in (None, "s") and _closes(stamp):
        return Written(_clock(stamp), "s", "clock times as one number (hhmmss)")
    return None


def _clock(stamp: np.ndarray) -> np.ndarray:
    whole = np.asarray(stamp, dtype=float)
    return whole // 10_000 * 3600.0 + whole // 100 % 100 * 60.0 + np.round(whole % 100, 9)


def _closes(stamp: np.ndarray) -> bool:
    """Whether numbers jump where a minute is full, and run on evenly when they are read as
    clocks.
    """
    x = np.asarray(stamp, dtype=float)
    if len(x) < 20 or x.min() < 0 or x.max() >= 240_000 or x.max() < 60:
        return False
    if (x % 100 >= 60).any() or (x // 100 % 100 >= 60).any():
        return False
    step = np.diff(x)
    rest = step[step > 0]
    usual = float(np.median(rest)) if rest.size else 0.0
    wide = np.flatnonzero(step > 39.0)
    if not wide.size or usual <= 0 or usual > 2.0:
        return False
    read = np.diff(_clock(x))
    return bool((read[wide] < 3.0 * usual).all() and (read >= 0).all())


def _date(stamp: np.ndarray) -> Written | None:
    """Whole numbers of 14 digits (to the second) or 17 (to the millisecond) that are dates."""
    if stamp.dtype.kind != "i" or not len(stamp):
        return None
    digits = len(str(int(stamp[0])))
    if digits not in (14, 17):
        return None
    part = 10 ** (digits - 14)
    whole, rest = stamp // part, stamp % part
    clock, day = whole % 10**6, whole // 10**6
    year, month, date = day // 10**4, day // 100 % 100, day % 100
    hour, minute, second = clock // 10**4, clock // 100 % 100, clock % 100
    fits = (1980 <= year) & (year < 2100) & (1 <= month) & (month <= 12) & (1 <= date)
    fits &= (date <= 31) & (hour < 24) & (minute < 60) & (second < 60)
    if not fits.all():
        return None
    months = (year - 1970).astype("datetime64[Y]").astype("datetime64[M]") + (month - 1)
    days = months.astype("datetime64[D]").astype(np.int64) + date - 1
    total = ((days * 24 + hour) * 60 + minute) * 60 + second
    unit = "s" if part == 1 else "ms"
    return Written(total * part + rest, unit, "dates with their clock as one number")
