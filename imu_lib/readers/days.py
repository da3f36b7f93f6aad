"""Dates as text into days since 1970: year, day or month first, by name, with years of two
digits.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw

_ISO = re.compile(r"^\s*(\d{4})[-/.年](\d{1,2})[-/.月](\d{1,2})日?")
_OTHER = re.compile(r"^\s*(\d{1,2})([-/.])(\d{1,2})[-/.](\d{4})")
_SHORT = re.compile(r"^\s*(\d{2})([-/.])(\d{2})[-/.](\d{2})(?!\d)")
_NAMED = re.compile(r"^\s*(\d{1,2})[-/ ]([A-Za-z]{3})[a-z]*[-/ ](\d{4})")
#: The first three letters of each month, in English and as other languages have them.
_MONTHS = (
    *(
        "jan ene gen",
        "feb fev f\u00e9v",
        "mar mrz mrt m\u00e4r",
        "apr abr avr",
        "may mai mei maj mag",
    ),
    *(
        "jun giu",
        "jul lug",
        "aug ago ao\u00fb aou",
        "sep set",
        "oct okt out ott",
        "nov",
        "dec dez dic d\u00e9c",
    ),
)
CENTURY = 70  # two digits from which a year is of the last century


class Date(NamedTuple):
    """A date in every order in which it may stand: order -> (year, month, day). sign: between its
    parts, None where the order is certain.
    """

    orders: dict[str, tuple[int, int, int]]
    sign: str | None


def is_date(text: str) -> bool:
    """Whether a text begins with a date in digits."""
    return any(shape.match(text) for shape in (_ISO, _OTHER, _SHORT))


def days(raw: Raw, date: np.ndarray, heading: str) -> tuple[np.ndarray, bool, str | None]:
    """Days since 1970 of each date; whether the date is certain; what decided the order.

    InputError where a text is no date, or where two orders remain that make a difference.
    """
    which: dict[str, int] = {}
    index = np.zeros(len(date), dtype=np.int64)
    for row, text in enumerate(date):
        text = str(text)
        key = next((m for s in (_ISO, _OTHER, _NAMED, _SHORT) if (m := s.match(text))), None)
        if not key:
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {text[:30]!r} is not readable as a "
                "date; write it as 2018-04-25."
            )
        index[row] = which.setdefault(key[0].strip(), len(which))
    parts = [_date(raw, heading, text) for text in which]
    if not any(p.sign for p in parts):
        fixed = [next(iter(p.orders.values())) for p in parts]
        return _numbers(raw, heading, fixed)[index], True, None
    return _decided(raw, heading, parts, which, index)


def _date(raw: Raw, heading: str, text: str) -> Date:
    if m := _ISO.match(text):
        return Date({"": (int(m[1]), int(m[2]), int(m[3]))}, None)
    if m := _OTHER.match(text):
        a, b, year = int(m[1]), int(m[3]), int(m[4])
        return Date({"day first": (year, b, a), "month first": (year, a, b)}, m[2])
    if m := _SHORT.match(text):
        a, b, c = int(m[1]), int(m[3]), int(m[4])
        orders = {"day first": (_year(c), b, a), "month first": (_year(c), a, b)}
        return Date(orders | {"year first": (_year(a), b, c)}, m[2])
    m = _NAMED.match(text)
    month = _month(m[2].lower()) if m else None
    if m is None or month is None:
        raise InputError(
            f"{raw.source}, {heading}: the month {m[2] if m else text!r} is not known; write "
            "dates as 2018-04-25."
        )
    return Date({"": (int(m[3]), month, int(m[1]))}, None)


def _month(word: str) -> int | None:
    return next((i for i, words in enumerate(_MONTHS, 1) if word in words.split()), None)


def _year(two: int) -> int:
    return two + (1900 if two >= CENTURY else 2000)


def _decided(
    raw: Raw, heading: str, parts: list[Date], which: dict[str, int], index: np.ndarray
) -> tuple[np.ndarray, bool, str | None]:
    """The one order that the dates of a file have."""
    good = {}
    for order in ("day first", "month first", "year first"):
        found = [p.orders.get(order, p.orders.get("")) for p in parts]
        dates = [d for d in found if d is not None and 1 <= d[1] <= 12 and 1 <= d[2] <= 31]
        if len(dates) == len(parts):
            good[order] = _numbers(raw, heading, dates)
    if not good:
        raise InputError(
            f"{raw.source}, {heading}: the dates are no calendar days; write them as 2018-04-25."
        )
    if len(good) == 1:
        name = next(iter(good))
        return good[name][index], True, f"dates with the {name}: no month is above 12"
    if all(p.sign in (".", None) for p in parts) and "day first" in good:
        return good["day first"][index], True, "dates with the day first, as points between say"
    # several orders are possible: days follow each other, and a record within one day needs no
    # order
    if len(which) == 1:
        return (
            next(iter(good.values()))[index],
            False,
            "which of its parts is the day makes no difference within one day",
        )
    rising = {n: d for n, d in good.items() if set(np.diff(d[_order(index)])) <= {1}}
    if len(rising) == 1:
        name = next(iter(rising))
        return good[name][index], True, f"dates with the {name}: so the days follow each other"
    raise InputError(
        f"{raw.source}, {heading}: {', '.join(list(which)[:2])} may have the day or the month "
        "first; write the dates as 2018-04-25, or leave the stamps out with --time-unit none "
        "--rate HZ."
    )


def _order(index: np.ndarray) -> np.ndarray:
    """Numbers of the dates in the order in which they appear."""
    _, first = np.unique(index, return_index=True)
    return index[np.sort(first)]


def _numbers(raw: Raw, heading: str, dates: list[tuple[int, int, int]]) -> np.ndarray:
    try:
        return np.array([np.datetime64(f"{y:04d}-{m:02d}-{d:02d}") for y, m, d in dates]).astype(
            np.int64
        )
    except ValueError:
        raise InputError(
            f"{raw.source}, {heading}: a date is no calendar day; write it as 2018-04-25."
        ) from None
