"""Dates and wall clocks as text into seconds: 24 and 12 hours, day or month first, `hh:mm:ss:ms`,
and what a spreadsheet leaves of a clock (`mm:ss.0`).
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw

DAY = 86_400_000_000_000  # ns
_CLOCK = re.compile(
    r"(\d{1,3}):(\d{2})(?::(\d{2}))?(?:([.,:])(\d+))?\s*([AaPp])?\.?(?:[Mm]\.?)?\s*(Z|UTC|GMT|[+-]\d{2}:?\d{2})?\s*$"
)
_ISO = re.compile(r"^\s*(\d{4})[-/.年](\d{1,2})[-/.月](\d{1,2})日?")
_OTHER = re.compile(r"^\s*(\d{1,2})([-/.])(\d{1,2})[-/.](\d{4})")
_NAMED = re.compile(r"^\s*(\d{1,2})[-/ ]([A-Za-z]{3})[a-z]*[-/ ](\d{4})")
_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec".split()


#: Moments in other orders, and how they are written in the usual one.
ODD = (
    (re.compile(r"^(\d{4})(\d{2})(\d{2})[T_ -](\d{2})(\d{2})(\d{2})(?:[.,](\d+))?(Z?)$"), r"\1-\2-\3T\4:\5:\6.\g<7>\8"),
    (re.compile(r"^[A-Z][a-z]{2},? ([A-Z][a-z]{2}) +(\d{1,2}) (\d{2}:\d{2}:\d{2}(?:\.\d+)?) (\d{4})$"), r"\2-\1-\4 \3"),
    (re.compile(r"^[A-Z][a-z]{2}, (\d{1,2}) ([A-Z][a-z]{2}) (\d{4}) (\d{2}:\d{2}:\d{2}(?:\.\d+)?)(?: (?:GMT|UTC|[+-]\d{4}))?$"), r"\1-\2-\3 \4"),
    (re.compile(r"^(\d{1,2})/([A-Z][a-z]{2})/(\d{4}):(\d{2}:\d{2}:\d{2}(?:\.\d+)?)$"), r"\1-\2-\3 \4"),
    (re.compile(r"^(\d{4}-\d{2}-\d{2})[T_ -](\d{2})[.-](\d{2})[.-](\d{2})(?:[._,-](\d+))?$"), r"\1T\2:\3:\4.\g<5>"),
    (re.compile(r"^(?:(\d+) days?,? )(\d{2}:\d{2}:\d{2}(?:\.\d+)?)$"), None),
    (re.compile(r"^(\d{4})[-:](\d{3})[T: -](\d{2}:\d{2}:\d{2}(?:\.\d+)?)Z?$"), None),
)  # fmt: skip


def usual(text: str) -> str | None:
    """A moment in an unusual order in the usual one, None where it is none: `20240517T105955.12`,
    `Fri May 17 10:59:55 2024`, `2024-138T10:59:55`, `0 days 00:00:01.5`.
    """
    for shape, order in ODD:
        if found := shape.match(text):
            if order:
                return found.expand(order).rstrip(".").replace(".Z", "Z")
            if found.re is ODD[-1][0]:
                day = np.datetime64(f"{found[1]}-01-01") + (int(found[2]) - 1)
                return f"{day}T{found[3]}"
            return f"{np.datetime64('2000-01-01') + int(found[1])}T{found[2]}"
    return None


def seconds(raw: Raw) -> tuple[np.ndarray, float | None, bool]:
    """Seconds from the first sample out of the columns of dates and clocks, the first moment as an
    epoch (None without a date), and whether the stamps are minutes and seconds only.

    InputError names the row that cannot be read, or the two readings of a date.
    """
    date, clock = raw.columns.get("date"), raw.columns.get("clock")
    heading = " and ".join(f"`{raw.headings[c]}`" for c in ("date", "clock") if c in raw.columns)
    days, known = np.zeros(raw.rows(), dtype=np.int64), False
    if date is not None:
        days, known, order = _days(raw, date, heading)
        if order:
            raw.told("date", None, order)
    text = clock if clock is not None else date
    ns, minutes_only = _clocks(raw, text, heading, required=clock is not None)
    ns = ns + days * DAY
    if raw.subseconds is not None:
        ns = ns + np.rint(raw.subseconds * 1e9).astype(np.int64)
    if date is None:
        # past midnight (or noon, or the full hour) the clock begins anew
        step = np.diff(ns)
        turn = 3600 * 10**9 if minutes_only else _turn(ns, step)
        ns = ns + np.cumsum(np.r_[0, step < -turn // 2]) * turn
    return (ns - ns[0]) * 1e-9, (float(ns[0]) * 1e-9 if known else None), minutes_only


def _turn(ns: np.ndarray, step: np.ndarray) -> int:
    falls = step[step < 0]
    half = DAY // 2
    if (
        falls.size
        and ns.max() < half + 3600 * 10**9
        and (np.abs(falls + half) < 3600 * 10**9).all()
    ):
        return half
    return DAY


def _clocks(raw, text, heading, *, required) -> tuple[np.ndarray, bool]:
    """Nanoseconds of the day of each text, and whether there are no hours in them."""
    out = np.zeros(len(text), dtype=np.int64)
    hours = False
    cache: dict[str, int] = {}
    for row, moment in enumerate(text):
        if moment in cache:
            out[row] = cache[moment]
            continue
        found = _CLOCK.search(str(moment))
        if not found:
            if not required and (_ISO.match(str(moment)) or _OTHER.match(str(moment))):
                continue
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {str(moment)[:30]!r} is not readable as a clock; write it as 15:10:13.25, "
                "or leave the stamps out with --time-unit none --rate HZ."
            )
        a, b, c, _, fraction, half, zone = found.groups()
        if c is None and fraction is not None:  # mm:ss.f
            hour, minute, second = 0, int(a), int(b)
        else:
            hour, minute, second = int(a), int(b), int(c or 0)
            hours = True
        if minute > 59 or second > 60:
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {str(moment)[:30]!r} is no time of a clock; correct it, "
                "or leave the stamps out with --time-unit none --rate HZ."
            )
        if half:
            hour = hour % 12 + (12 if half in "Pp" else 0)
        value = ((hour * 60 + minute) * 60 + second) * 10**9
        if fraction:
            # `12:00:01:45` counts milliseconds behind the last colon, `12:00:01.45` is a fraction
            value += int(fraction) * 10**6 if found[4] == ":" else int(f"{fraction:0<9.9}")
        if zone and zone[0] in "+-":
            value -= int(zone[0] + "1") * (int(zone[1:3]) * 3600 + int(zone[-2:]) * 60) * 10**9
        cache[moment] = value
        out[row] = value
        if len(cache) > 500_000:
            cache.clear()
    return out, not hours


def _days(raw, date, heading) -> tuple[np.ndarray, bool, str | None]:
    """Days since 1970 of each date; whether the date is certain; what decided the order."""
    which: dict[str, int] = {}
    index = np.zeros(len(date), dtype=np.int64)
    for row, text in enumerate(date):
        text = str(text)
        key = _ISO.match(text) or _OTHER.match(text) or _NAMED.match(text)
        if not key:
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {text[:30]!r} is not readable as a date; write it as 2018-04-25."
            )
        index[row] = which.setdefault(key[0].strip(), len(which))
    parts = []
    for text in which:
        if m := _ISO.match(text):
            parts.append((int(m[1]), int(m[2]), int(m[3]), None))
        elif m := _NAMED.match(text):
            name = m[2].lower()
            if name not in _MONTHS:
                raise InputError(
                    f"{raw.source}, {heading}: the month {m[2]!r} is not known; write dates as 2018-04-25."
                )
            parts.append((int(m[3]), _MONTHS.index(name) + 1, int(m[1]), None))
        else:
            m = _OTHER.match(text)
            parts.append((int(m[4]), int(m[1]), int(m[3]), m[2]))
    open_ = [p for p in parts if p[3] is not None]
    if not open_:
        return _numbers(raw, heading, [(y, m, d) for y, m, d, _ in parts])[index], True, None
    dmy = [(y, b, a) if s else (y, a, b) for y, a, b, s in parts]
    mdy = [(y, a, b) for y, a, b, _ in parts]
    good = {}
    for name, dates in (("day first", dmy), ("month first", mdy)):
        if all(1 <= m <= 12 and 1 <= d <= 31 for _, m, d in dates):
            good[name] = _numbers(raw, heading, dates)
    if not good:
        raise InputError(
            f"{raw.source}, {heading}: the dates are no calendar days; write them as 2018-04-25."
        )
    if len(good) == 1:
        name = next(iter(good))
        return good[name][index], True, f"dates with the {name}: no month is above 12"
    if all(p[3] == "." for p in open_):
        return good["day first"][index], True, "dates with the day first, as points between say"
    # both orders are possible: days follow each other, and a record within one day needs no order
    rising = {n: d for n, d in good.items() if len(d) > 1 and set(np.diff(d[_order(index)])) <= {1}}
    if len(which) == 1:
        return (
            good["day first"][index],
            False,
            "day or month first: it makes no difference within one day",
        )
    if len(rising) == 1:
        name = next(iter(rising))
        return good[name][index], True, f"dates with the {name}: so the days follow each other"
    raise InputError(
        f"{raw.source}, {heading}: {', '.join(list(which)[:2])} may have the day or the month first; write the dates as 2018-04-25, "
        "or leave the stamps out with --time-unit none --rate HZ."
    )


def _order(index) -> np.ndarray:
    """Numbers of the dates in the order in which they appear."""
    _, first = np.unique(index, return_index=True)
    return index[np.sort(first)]


def _numbers(raw, heading, dates) -> np.ndarray:
    try:
        return np.array([np.datetime64(f"{y:04d}-{m:02d}-{d:02d}") for y, m, d in dates]).astype(
            np.int64
        )
    except ValueError:
        raise InputError(
            f"{raw.source}, {heading}: a date is no calendar day; write it as 2018-04-25."
        ) from None
