"""Dates and wall clocks as text into seconds: 24 and 12 hours, day or month first, `hh:mm:ss:ms`,
and what a spreadsheet leaves of a clock (`mm:ss.0`).
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import days
from imu_lib.readers.raw import Raw

DAY = 86_400_000_000_000  # ns
#: Names of zones, which a record keeps from its first stamp to its last.
ZONES = r"UTC|GMT|W?EST|W?EDT|CES?T|MSK|[CMPA][SD]T|BST|JST|KST|IST|AES?T|AEDT|NZS?T|NZDT"
_CLOCK = re.compile(
    r"(\d{1,3}):(\d{1,2})(?::(\d{1,2}))?(?:([.,:;])(\d+))?\s*([AaPp])?\.?(?:[Mm]\.?)?\s*(Z|"
    rf"{ZONES}|[+-]\d{{2}}:?\d{{2}})?\s*$"
)
_USUAL = re.compile(r"\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}:\d{2}(?:\.\d{1,9})?")
_FRAMES = re.compile(r"\d{1,2}:\d{2}:\d{2}[:;](\d{2})\s*$")
FRAME_RATES = (24, 25, 30, 48, 50, 60, 100)  # in a second: of film and video; hundredths


#: Moments in other orders, and how they are written in the usual one.
ODD = (
    (re.compile(r"^(\d{4})(\d{2})(\d{2})[T_ -]?(\d{2})(\d{2})(\d{2})(?:[.,]?(\d+))?(Z?)$"), r"\1-\2-\3T\4:\5:\6.\g<7>\8"),
    (re.compile(r"^[A-Z][a-z]{2},? ([A-Z][a-z]{2}) +(\d{1,2}) (\d{2}:\d{2}:\d{2}(?:\.\d+)?) "
                r"(\d{4})$"), r"\2-\1-\4 \3"),
    (re.compile(r"^[A-Z][a-z]{2}, (\d{1,2}) ([A-Z][a-z]{2}) (\d{4}) "
                r"(\d{2}:\d{2}:\d{2}(?:\.\d+)?)(?: (?:GMT|UTC|[+-]\d{4}))?$"), r"\1-\2-\3 \4"),
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
    plain = _plain(date) if clock is None and raw.subseconds is None else None
    if plain is not None:
        return (plain - plain[0]) * 1e-9, float(plain[0]) * 1e-9, False
    days_, known = np.zeros(raw.rows(), dtype=np.int64), False
    if date is not None:
        days_, known, order = days.days(raw, date, heading)
        if order:
            raw.told("date", None, order)
    text = clock if clock is not None else date
    ns, minutes_only = _clocks(raw, text, heading, required=clock is not None)
    ns = ns + days_ * DAY
    if raw.subseconds is not None:
        ns = ns + np.rint(raw.subseconds * 1e9).astype(np.int64)
    if date is None:
        # past midnight (or noon, or the full hour) the clock begins anew
        step = np.diff(ns)
        turn = 3600 * 10**9 if minutes_only else _turn(ns, step)
        ns = ns + np.cumsum(np.r_[0, step < -turn // 2]) * turn
    return (ns - ns[0]) * 1e-9, (float(ns[0]) * 1e-9 if known else None), minutes_only


def _plain(date: np.ndarray) -> np.ndarray | None:
    """Nanoseconds since 1970 of moments that are all written alike, year first and without a zone;
    None where they are not. What a table of millions of rows mostly has, at a tenth of the time.
    """
    if not _USUAL.fullmatch(str(date[0])) or len({len(str(x)) for x in date}) > 1:
        return None
    import pyarrow as pa

    try:
        return pa.array(date, pa.string()).cast(pa.timestamp("ns")).to_numpy().astype(np.int64)
    except (pa.ArrowInvalid, pa.ArrowTypeError, OverflowError):
        return None


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
    frames = _frames(raw, text, heading)
    unpadded = _unpadded(raw, text, heading)
    cache: dict[str, int] = {}
    for row, moment in enumerate(text):
        if moment in cache:
            out[row] = cache[moment]
            continue
        found = _CLOCK.search(str(moment))
        if not found:
            if not required and days.is_date(str(moment)):
                continue
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {str(moment)[:30]!r} is not readable "
                "as a clock; write it as 15:10:13.25, or leave the stamps out with --time-unit "
                "none --rate HZ."
            )
        a, b, c, _, fraction, half, zone = found.groups()
        if c is None and fraction is not None:  # mm:ss.f
            hour, minute, second = 0, int(a), int(b)
        else:
            hour, minute, second = int(a), int(b), int(c or 0)
            hours = True
        if minute > 59 or second > 60:
            raise InputError(
                f"{raw.source}, {heading}, {raw.line(row)}: {str(moment)[:30]!r} is no time of a "
                "clock; correct it, or leave the stamps out with --time-unit none --rate HZ."
            )
        if half:
            hour = hour % 12 + (12 if half in "Pp" else 0)
        value = ((hour * 60 + minute) * 60 + second) * 10**9
        if fraction:
            # `12:00:01:45` counts frames or milliseconds, `12:00:01.45` is a fraction
            counted = found[4] in ":;" or unpadded
            value += (
                int(fraction) * 10**9 // (frames or 1000) if counted else int(f"{fraction:0<9.9}")
            )
        if zone and zone[0] in "+-":
            value -= int(zone[0] + "1") * (int(zone[1:3]) * 3600 + int(zone[-2:]) * 60) * 10**9
        cache[moment] = value
        out[row] = value
        if len(cache) > 500_000:
            cache.clear()
    return out, not hours


def _unpadded(raw, text, heading) -> bool:
    """Whether milliseconds stand behind the seconds without their zeros: 9:8:7.5, 9:8:7.15,
    9:8:7.105 rise as thousandths and fall as decimals.
    """
    found = [m for t in text[:5000] if (m := _CLOCK.search(str(t))) and m[3] and m[4] in (".", ",")]
    length = {len(m[5]) for m in found}
    if len(found) < 20 or max(length, default=0) != 3 or len(length) < 2:
        return False
    if any(len(m[5]) > 1 and m[5][0] == "0" for m in found):
        return False
    whole = np.array([(int(m[1]) * 60 + int(m[2])) * 60 + int(m[3]) for m in found])
    counted = whole + np.array([int(m[5]) for m in found]) / 1e3
    decimal = whole + np.array([float(f"0.{m[5]}") for m in found])
    if (np.diff(counted) < -1.0).any() or not (np.diff(decimal) < 0).any():
        return False
    if (np.diff(counted) >= 0).mean() < 0.99:
        return False
    raw.notes += (f"{heading} has its milliseconds without leading zeros (7.5 is 7.005 s).",)
    return True


def _frames(raw, text, heading) -> int | None:
    """Frames in a second of time codes (hh:mm:ss:ff), None where the last part is none. InputError
    where the codes do not tell how many there are.
    """
    found = [_FRAMES.search(str(t)) for t in text[:20_000]]
    if not found or not all(found):
        return None
    most = max(int(m[1]) for m in found if m) + 1
    if most not in FRAME_RATES:
        raise InputError(
            f"{raw.source}, {heading}: the stamps end in frames, {most} of them at most, which is "
            "no usual number in a second; leave the stamps out with --time-unit none --rate HZ."
        )
    raw.notes += (
        f"The stamps are time codes of {most} frames in a second."
        if most < 100
        else "Hundredths of a second stand behind the last colon of the stamps.",
    )
    return most
