"""What the words of one heading say: a time, a counter, a reading of a sensor and its axis."""

from __future__ import annotations

import re
from dataclasses import replace

from imu_lib.readers import directions, lexicon
from imu_lib.readers.meaning import SIGNALS, UNKNOWN, Meaning
from imu_lib.readers.time_words import stamp_of


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
    stamp = stamp_of(tokens, joined, name)
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
        if word.startswith("grav") and have & {"including", "includes", "incl", "with"}:
            continue  # accelerationIncludingGravity is the specific force
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
    if words[-1:] == ["d"] and have & {"vel", "v", "velocity"}:
        return Meaning(why="a velocity")
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
    have = {"accel" if w == "ag" else w for w in have}
    have = {w for w in have if not lexicon.CHIP.fullmatch(w)}
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
    if have & {"uncalibrated", "uncal", "raw", "adc", "counts", "lsb"}:
        rank = max(rank, 2)
    if have & {"unfiltered", "unfilt"}:
        rank = 3
    if kind == "accel" and have & {"gf", "gforce"} or {"g", "force"} <= have:
        unit = "g"
    if axis is None:
        return Meaning(kind, None, unit, rank, why=f"named {kind}", group=group)
    return Meaning(kind, axis, unit, rank, why=f"named {'an accelerometer' if kind in ('accel', 'dv') else 'a gyro'}", group=group)  # fmt: skip
