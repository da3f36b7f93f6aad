"""Headings that name a time, a part of one, a date or a counter."""

from __future__ import annotations

import re

from imu_lib.readers import lexicon
from imu_lib.readers.lexicon import words
from imu_lib.readers.meaning import Meaning


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
        return Meaning("part", part=lexicon.PARTS[tokens[-1]], why="part of a date or clock")
    if joined in ("minute", "min", "mm"):
        return Meaning("part", part="minute", why="part of a clock")
    if have & set(lexicon.NOT) - {"offset"} and not have & {
        "time",
        "timestamp",
        "stamp",
        "tow",
        "sow",
    }:
        return None
    is_time = (
        have & lexicon.TIME or joined in lexicon.TIME or joined.endswith(("timestamp", "datetime"))
    )
    if not is_time and re.fullmatch(
        r"(t|time|timestamp|ts|temps)_?(ms|us|ns|s|sec|usec|msec|nsec)", joined
    ):
        is_time = True
    if joined.endswith("time") and joined not in ("deltatime", "dtime", "exposuretime", "lifetime"):
        is_time = True
    if joined in (
        "ts",
        "gpst",
        "utc",
        "gpstime",
        "unixtime",
        "systime",
        "hosttime",
        "ticktime",
        "itow",
        "xvalue",
    ):
        is_time = True
    if tokens[-1] in ("cycle", "cycles", "systick", "rtc") and len(tokens) < 3:
        is_time = True
    lone = tokens if len(tokens) == 1 else []
    weak = words(
        "cpu cycle cycles systick rtc t s ms us ns sec secs second seconds a tick ticks temps min minutes"
    )
    alone = have <= weak | lexicon.TIME | lexicon.OWN | lexicon.ARRIVAL | words(
        "gps utc since boot start header stamp unix in of from the tv ts"
    )
    if is_time and (
        have & (lexicon.TIME - weak)
        or joined in lexicon.TIME
        or joined.endswith("timestamp")
        or alone
        or not have & lexicon.TIME
    ):
        part = unit = None
        for token in (tokens[-1], joined, *reversed(tokens)):
            if token == "ts":  # a time stamp, no seconds
                continue
            if token in lexicon.FINE:
                unit = lexicon.FINE[token]
                break
            tail = re.search(
                r"(?:time|stamp|ts)(ms|us|ns|secs?|usec|msec|nsec)$|(?:^t|elapsed)(ms|us|ns|s|secs?|usec|msec|nsec)$",
                token,
            )
            if tail:
                unit = lexicon.FINE[tail[1] or tail[2]]
                break
        if tokens[-1] in lexicon.FINE or joined in lexicon.FINE:
            part = "sub" if unit in ("ns", "us", "ms", "cs") else "whole"
        rank = 0 if have & lexicon.OWN else 2 if have & lexicon.ARRIVAL else 1
        if joined == "itow":
            unit = "ms"  # u-blox counts the time of week in ms under this name
        if "sampletimefine" in joined:
            return Meaning("time", rank=0, part="ticks", why="the sensor's own sample time")
        if have & lexicon.COUNTER - {"i", "n", "id", "no"} and not have & (
            lexicon.TIME - {"t", "s"}
        ):
            return Meaning("counter", why="named a counter")
        group = (
            "gyro"
            if have & (lexicon.GYRO - {"w"})
            else "accel"
            if have & (lexicon.ACCEL - {"a", "f"})
            else ""
        )
        if tokens[-1] in ("tick", "ticks", "cycle", "cycles", "systick", "rtc") and len(tokens) < 3:
            unit = "ticks"
        return Meaning("time", unit=unit, rank=rank, part=part, why=f"named a time ({name.strip()[:40]})", group=group)  # fmt: skip
    if have <= lexicon.COUNTER | {"imu", "msg", "message", "data", "header", "field", "of"} and (
        have & lexicon.COUNTER or joined in lexicon.COUNTER
    ):
        return Meaning("counter", why="named a counter")
    if joined in lexicon.COUNTER and lone:
        return Meaning("counter", why="named a counter")
    return None
