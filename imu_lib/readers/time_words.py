"""Headings that name a time, a part of one, a date or a counter."""

from __future__ import annotations

import re

from imu_lib.readers import lexicon
from imu_lib.readers.lexicon import words
from imu_lib.readers.meaning import Meaning

CYCLES = words("tick ticks cycle cycles systick rtc")
#: Names of a time that are one word.
WHOLE = words("ts gpst utc gpstime unixtime systime hosttime ticktime itow xvalue")
#: Words that name a time only where all the others do, too.
WEAK = words(
    "cpu cycle cycles systick rtc t s ms us ns sec secs second seconds a tick ticks temps min "
    "minutes frac fraction fractional subsec subsecs subsecond subseconds"
)
BESIDE = words(
    "gps utc since boot start begin header stamp unix ntp in of from the tv ts today midnight"
)
_WITH_UNIT = re.compile(r"(t|time|timestamp|ts|temps)_?(ms|us|ns|s|sec|usec|msec|nsec)")
_TAIL = re.compile(
    r"(?:time|stamp|ts)(ms|us|ns|secs?|usec|msec|nsec)$|(?:^t|^tv|^begin|^start|^unix|^epoch|"
    r"elapsed)(ms|us|ns|s|secs?|usec|msec|nsec)$"
)


def stamp_of(tokens: list[str], joined: str, name: str) -> Meaning | None:
    """A time, a part of one, a date or a counter; None where the name is none of them."""
    have = set(tokens)
    signal_words = have & ((lexicon.GYRO | lexicon.ACCEL) - {"a", "f", "w", "t"})
    if have & lexicon.TEMPERATURE and not have & (lexicon.TIME - {"t", "temps", "s"}):
        if "temps" in have and not signal_words:
            return Meaning("time", why="named a time")
        return None
    if joined in lexicon.DATE:
        return Meaning("date", why="named a date")
    if joined in ("clock", "uhrzeit", "timeofday", "localtime", "hora", "ora", "heure"):
        return Meaning("clock", why="named a clock")
    if joined in lexicon.PARTS or (
        tokens[-1] in lexicon.PARTS and len(tokens) == 2 and have & {"utc", "gps", "time"}
    ):
        return Meaning(
            "part",
            part=lexicon.PARTS.get(joined) or lexicon.PARTS[tokens[-1]],
            why="part of a date or clock",
        )
    if joined in ("minute", "min", "mm"):
        return Meaning("part", part="minute", why="part of a clock")
    named = have & {"time", "timestamp", "stamp", "tow", "sow"}
    if have & set(lexicon.NOT) - {"offset"} and not named:
        return None
    if _is_time(tokens, joined, have):
        return _time(tokens, joined, name)
    beside = {"imu", "msg", "message", "data", "header", "field", "of"}
    counts = have <= lexicon.COUNTER | beside and (
        have & lexicon.COUNTER or joined in lexicon.COUNTER
    )
    if counts or joined in lexicon.COUNTER and len(tokens) == 1:
        return Meaning("counter", why="named a counter")
    return None


def _is_time(tokens: list[str], joined: str, have: set[str]) -> bool:
    found = (
        have & lexicon.TIME
        or joined in lexicon.TIME | WHOLE
        or joined.endswith(("timestamp", "datetime"))
        or _WITH_UNIT.fullmatch(joined)
        or joined.endswith("time")
        and joined not in ("deltatime", "dtime", "exposuretime", "lifetime")
        or tokens[-1] == "ts"
        and have - {"ts"} <= lexicon.GYRO | lexicon.ACCEL | lexicon.OWN
        or _TAIL.fullmatch(joined)
        or tokens[-1] in CYCLES - {"tick", "ticks"}
        and len(tokens) < 3
    )
    alone = have <= WEAK | lexicon.TIME | lexicon.OWN | lexicon.ARRIVAL | BESIDE
    strong = have & (lexicon.TIME - WEAK) or joined in lexicon.TIME or joined.endswith("timestamp")
    return bool(found and (strong or alone or not have & lexicon.TIME))


def _time(tokens: list[str], joined: str, name: str) -> Meaning:
    """A time with the unit that its words imply, its rank, and what of a stamp it is."""
    have = set(tokens)
    unit = _unit(tokens, joined)
    part = None
    if tokens[-1] in lexicon.FINE or joined in lexicon.FINE:
        part = "sub" if unit in ("ns", "us", "ms", "cs", "fraction") else "whole"
    rank = 0 if have & lexicon.OWN else 2 if have & lexicon.ARRIVAL else 1
    if joined == "itow":
        unit = "ms"  # u-blox counts the time of week in ms under this name
    if "sampletimefine" in joined:
        return Meaning("time", rank=0, part="ticks", why="the sensor's own sample time")
    if have & lexicon.COUNTER - {"i", "n", "id", "no"} and not have & (lexicon.TIME - {"t", "s"}):
        return Meaning("counter", why="named a counter")
    of_gyro, of_accel = have & (lexicon.GYRO - {"w"}), have & (lexicon.ACCEL - {"a", "f"})
    group = "gyro" if of_gyro else "accel" if of_accel else ""
    if tokens[-1] in CYCLES and len(tokens) < 3:
        unit = "ticks"
    return Meaning(
        "time",
        unit=unit,
        rank=rank,
        part=part,
        why=f"named a time ({name.strip()[:40]})",
        group=group,
    )


def _unit(tokens: list[str], joined: str) -> str | None:
    """The unit of time that the last such word says."""
    for token in (tokens[-1], joined, *reversed(tokens)):
        if token == "ts":  # a time stamp, no seconds
            continue
        if token in lexicon.FINE:
            return lexicon.FINE[token]
        if tail := _TAIL.search(token):
            return lexicon.FINE[tail[1] or tail[2]]
    return None
