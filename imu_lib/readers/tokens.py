"""What the words of one heading say: a time, a counter, a reading of a sensor and its axis."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from imu_lib.readers import directions, lexicon
from imu_lib.readers.lexicon import words

UNKNOWN = "its name is not known here"
SIGNALS = ("gyro", "accel", "dtheta", "dv")


@dataclass(frozen=True)
class Meaning:
    """What a name says.

    quantity: gyro, accel, dtheta, dv, time, date, clock, counter, temperature or None. axis: x, y,
    z, a digit as a string, or None. unit: canonical, or as spelled where it is not known. rank: 0
    for what such a name usually heads, higher for a stand-in (arrival time, an uncalibrated
    reading). part: sec, nsec, year, hour ... of a stamp in several columns. why: the words that
    told, or why the column is not used.
    """

    quantity: str | None = None
    axis: str | None = None
    unit: str | None = None
    rank: int = 1
    part: str | None = None
    why: str = "its name says nothing that is known here"
    group: str = ""

    @property
    def canonical(self) -> str | None:
        if self.quantity in SIGNALS and self.axis:
            return f"{self.quantity}_{self.axis}"
        return self.quantity


def read(key: str, axis: str | None, signal: str | None, name: str) -> Meaning:
    """The meaning of a key, its unit only where a word of the name is one."""
    tokens = [t for t in key.split("_") if t]
    if not tokens:
        return Meaning()
    if signal in ("gyro", "accel") and len(tokens) == 1 and re.fullmatch(r"[xyz1-3]", tokens[0]):
        return Meaning(signal, tokens[0], why=f"the file was given as --{signal}")
    joined = "".join(tokens)
    if lexicon.interval(tokens):
        return Meaning(unit=lexicon.fine(tokens), part="interval", why="an interval between stamps")
    stamp = _stamp(tokens, joined, name)
    if stamp:
        return stamp
    # the axis, and a word that holds kind and axis in one: gx, accX, xgyro
    words = []
    pointed = axis
    for token in directions.without_number(tokens, axis):
        whole, front = lexicon.COMPACT.match(token), lexicon.COMPACT_FRONT.match(token)
        if re.fullmatch(r"[xyz]", token) or re.fullmatch(r"[xyz]axis|axis[xyz]", token):
            pointed = token.replace("axis", "")
        elif token == "axis":
            continue
        elif whole and token not in ("max",):
            words.append(whole[1])
            pointed = whole[2]
        elif front:
            words.append(front[2])
            pointed = front[1]
        else:
            words.append(token)
    if pointed is None and words and re.fullmatch(r"[0-3]", words[-1]) and len(words) > 1:
        pointed = words.pop()
    if (
        pointed is None
        and words
        and (numbered := re.fullmatch(r"([a-z]{1,13}?)([0-3])", words[-1]))
    ):
        if numbered[1] in lexicon.KIND_OF or numbered[1] in lexicon.GYRO | lexicon.ACCEL:
            words[-1], pointed = numbered[1], numbered[2]
    return _signal(words, pointed, name)


def _stamp(tokens: list[str], joined: str, name: str) -> Meaning | None:
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
    ):
        is_time = True
    lone = tokens if len(tokens) == 1 else []
    weak = words("t s ms us ns sec secs second seconds a tick ticks temps min minutes")
    alone = have <= weak | lexicon.TIME | lexicon.OWN | lexicon.ARRIVAL | words(
        "gps utc since boot start header stamp unix in of from the"
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
            if token in lexicon.FINE:
                unit = lexicon.FINE[token]
                break
            tail = re.search(
                r"(?:time|stamp|^t|ts|elapsed)(ms|us|ns|s|sec|secs|usec|msec|nsec)$", token
            )
            if tail:
                unit = lexicon.FINE[tail[1]]
                break
        if tokens[-1] in lexicon.FINE or joined in lexicon.FINE:
            part = "sub" if unit in ("ns", "us", "ms") else "whole"
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
        if tokens == ["ticks"] or tokens == ["tick"]:
            unit = "ticks"
        return Meaning("time", unit=unit, rank=rank, part=part, why=f"named a time ({name.strip()[:40]})", group=group)  # fmt: skip
    if have <= lexicon.COUNTER | {"imu", "msg", "message", "data", "header", "field", "of"} and (
        have & lexicon.COUNTER or joined in lexicon.COUNTER
    ):
        return Meaning("counter", why="named a counter")
    if joined in lexicon.COUNTER and lone:
        return Meaning("counter", why="named a counter")
    return None


def _signal(words: list[str], axis: str | None, name: str) -> Meaning:
    """An inertial reading, a temperature, or why it is none."""
    directed = directions.axis_of(words) if axis is None else None
    if directed:
        found = _signal(*directed, name)
        if found.quantity in SIGNALS:
            return replace(
                found, rank=max(found.rank, 2), why=f"{found.why}, {found.axis} {directions.ALONG}"
            )
    have = set(words)
    joined = "".join(words)
    for word in words:
        turning = have & {"rate", "rates", "velocity", "speed", "rot", "geschwindigkeit"}
        if word in lexicon.NOT and not (word in ("roll", "pitch", "yaw") and turning):
            if not (word == "speed" and have & {"angular", "ang", "rotation", "winkel"}):
                return Meaning(why=lexicon.NOT[word])
    if have & {"angular", "rotational"} and have & (lexicon.ACCEL - {"a", "f"}):
        return Meaning(why="an angular acceleration")
    if have & lexicon.TEMPERATURE or any(t in joined for t in ("temperature", "temperatur")):
        return Meaning("temperature", why="named a temperature")
    kind = None
    group = next(
        (w for w in words if re.fullmatch(r"(?:imu|sensor|gyro|acc|accel|mpu|s)_?\d+", w)), ""
    )
    delta = have & {
        "delta",
        "d",
        "del",
        "increment",
        "inc",
        "dang",
        "dvel",
        "dtheta",
        "dv",
        "velinc",
        "deltav",
        "deltatheta",
    }
    if delta:
        if have & {
            "theta",
            "angle",
            "ang",
            "angles",
            "dtheta",
            "dang",
            "rot",
            "deltatheta",
            "gyro",
            "gyr",
        }:
            kind = "dtheta"
        elif have & {"v", "vel", "velocity", "dv", "dvel", "velinc", "deltav", "acc", "accel"}:
            kind = "dv"
        elif have & {"t", "time"}:
            return Meaning(why="an interval between stamps")
    if kind is None and have & {"dt", "da"} and axis:
        kind = "dtheta"
    if (
        kind is None
        and have & {"roll", "pitch", "yaw"}
        and have & {"rate", "rates"}
        and len(have) <= 3
    ):
        return Meaning("gyro", {"roll": "x", "pitch": "y", "yaw": "z"}[(have & {"roll", "pitch", "yaw"}).pop()], why="named a body rate")  # fmt: skip
    if kind is None:
        angular = have & {
            "angular",
            "ang",
            "angulaire",
            "angolare",
            "rotation",
            "rotational",
            "turn",
            "rot",
            "katowa",
            "winkel",
        }
        speed = have & {
            "velocity",
            "vel",
            "rate",
            "rates",
            "vitesse",
            "velocidad",
            "velocita",
            "velocidade",
            "predkosc",
            "speed",
            "turn",
        }
        if (
            (angular and speed)
            or have & lexicon.GYRO
            or joined in lexicon.GYRO
            or have & {"angularvelocity", "angularrate"}
        ):
            kind = "gyro"
        elif have - {"imu", "sensor", "body", "raw"} == {"rate"} and axis:
            kind = "gyro"
    # single letters tell only where they stand nearly alone
    letters = {"g", "w", "a", "f"}
    have = {w for w in have if not re.fullmatch(r"(?:imu|sensor|mpu|icm|lsm|bmi|dev|device)\d*", w)}
    others = have - {
        "rs",
        "s",
        "b",
        "ib",
        "imu",
        "raw",
        "data",
        "cal",
        "field",
        "meas",
        "body",
        "sensor",
        "msg",
        "kf",
        "r",
        "i",
        "lsm",
        "mpu",
        "out",
    }
    is_force = (
        have & (lexicon.ACCEL - letters)
        or joined in lexicon.ACCEL - letters
        or have & {"specific", "force"} == {"specific", "force"}
    )
    is_force = is_force or ({"g", "force"} <= have)
    if kind == "gyro" and not have & (lexicon.GYRO - letters) and is_force:
        kind = None
    if kind is None:
        if is_force:
            kind = "accel"
        elif others == {"g"} and axis:
            kind = "gyro"
        elif others & {"a", "f"} and len(others) == 1 and axis:
            kind = "accel"
        elif others == {"w"} and axis:
            kind = "gyro"
        elif others == {"alpha"} and axis:
            return Meaning(
                "alpha", axis, why="alpha beside omega is Kalibr's name for the accelerometer"
            )
    if (
        kind == "gyro"
        and not have & (lexicon.GYRO - letters)
        and have & letters
        and len(others) > 1
        and not (angular and speed)
    ):
        kind = None
    if kind is None:
        if have & {"velocity", "vel", "speed"}:
            return Meaning(why="a velocity")
        return Meaning(why=UNKNOWN)
    rank = 1
    unit = None
    if kind == "accel" and have & lexicon.FREE:
        rank = 2
    if have & {"uncalibrated", "uncal", "raw", "unfiltered", "adc", "counts", "lsb"}:
        rank = max(rank, 2)
    if kind == "accel" and have & {"gf", "gforce"} or {"g", "force"} <= have:
        unit = "g"
    if axis is None:
        return Meaning(kind, None, unit, rank, why=f"named {kind}", group=group)
    return Meaning(kind, axis, unit, rank, why=f"named {'an accelerometer' if kind in ('accel', 'dv') else 'a gyro'}", group=group)  # fmt: skip
