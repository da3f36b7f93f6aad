"""What the words of one heading say: a time, a counter, a reading of a sensor and its axis."""

from __future__ import annotations

import re
from dataclasses import replace

from imu_lib.readers import directions, lexicon
from imu_lib.readers.meaning import SIGNALS, UNKNOWN, Meaning
from imu_lib.readers.time_words import stamp_of

ROTATION = "named a rotation"
#: Frames into which a device turns its readings by its attitude.
FRAMES = lexicon.words("world earth global ned enu nav navigation wrf")


def read(key: str, axis: str | None, signal: str | None, name: str) -> Meaning:
    """The meaning of a key, its unit only where a word of the name is one."""
    tokens = [t for t in key.split("_") if t]
    if not tokens:
        return Meaning()
    if signal in ("gyro", "accel") and len(tokens) == 1 and re.fullmatch(r"[xyz1-3]", tokens[0]):
        return Meaning(signal, tokens[0], why=f"the file was given as --{signal}")
    joined = "".join(tokens)
    if pose := lexicon.POSE.fullmatch(joined):
        return Meaning(why="an attitude" if "q" in pose[0] else "a position")
    if lexicon.interval(tokens):
        return Meaning(unit=lexicon.fine(tokens), part="interval", why="an interval between stamps")
    stamp = stamp_of(tokens, joined, name)
    if stamp:
        return stamp
    if len({t for t in tokens if t in ("x", "y", "z")}) > 1:  # Gyroscope (z,x,y) names no axis
        tokens = [t for t in tokens if t not in ("x", "y", "z")]
        axis = None
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
    have, joined = set(words), "".join(words)
    refused = _refused(words, have, axis)
    if refused:
        return refused
    if have & lexicon.TEMPERATURE or any(t in joined for t in ("temperature", "temperatur")):
        return Meaning("temperature", why="named a temperature")
    if words[-1:] == ["d"] and have & {"vel", "v", "velocity"}:
        return Meaning(why="a velocity")
    kind = _increment(have, axis)
    if kind == "t":
        return Meaning(why="an interval between stamps")
    turn = have & set(directions.TURN)
    if (
        kind is None
        and turn
        and have & {"rate", "rates", "vel", "velocity", "speed"}
        and len(have) <= 3
    ):
        return Meaning("gyro", axis or directions.TURN[turn.pop()], why="named a body rate")
    if kind is None and axis in ("x", "y", "z") and _is_rotation(have):
        return Meaning("gyro", axis, rank=2, why=ROTATION)
    if kind is None:
        kind = _kind(have, joined, axis)
    if kind == "alpha":
        return Meaning(
            "alpha", axis, why="alpha beside omega is Kalibr's name for the accelerometer"
        )
    if kind is None:
        return Meaning(why="a velocity" if have & {"velocity", "vel", "speed"} else UNKNOWN)
    return _reading(kind, axis, words)


def _is_rotation(have: set[str]) -> bool:
    """Whether the words name a rotation and no more: a rate in most logs, an angle in some."""
    return bool(have) and have - lexicon.BESIDE_LETTERS in ({"rotation"}, {"rot"})


def _refused(words: list[str], have: set[str], axis: str | None) -> Meaning | None:
    """Why a heading is no inertial reading, None where nothing says so."""
    turning = have & {"rate", "rates", "velocity", "vel", "speed", "rot", "geschwindigkeit"}
    named = have & ((lexicon.GYRO | lexicon.ACCEL) - lexicon.LETTERS)
    force = have & (lexicon.ACCEL - lexicon.LETTERS)
    if have & lexicon.ANGLE and not have & (lexicon.SPEED | lexicon.DELTA):
        return Meaning(why="an angle")
    if have & FRAMES and named:
        return Meaning(why="turned into a frame of the Earth")
    if have & {"gps", "gnss"} and named and "imu" not in have:
        return Meaning(why="a satellite receiver's")
    for word in words:
        if word.startswith("grav") and have & {"including", "includes", "incl", "with"}:
            continue  # accelerationIncludingGravity is the specific force
        if word == "total" and axis and force and not have & lexicon.NOT.keys() - {"total"}:
            continue  # total_acc_x: with gravity in it
        if word in lexicon.NOT and not (word in directions.TURN and turning):
            if not (word == "speed" and have & {"angular", "ang", "rotation", "winkel"}):
                return Meaning(why=lexicon.NOT[word])
    if have & {"angular", "rotational", "ang", "rot"} and have & (lexicon.ACCEL - {"a", "f"}):
        return Meaning(why="an angular acceleration")
    if have & {"sf", "scale"} and (named - {"sf"} or have & {"g", "w", "a"}):
        return Meaning(why="a scale factor")
    return None


def _increment(have: set[str], axis: str | None) -> str | None:
    """dtheta, dv, or t for an interval of time; None where a heading names no increment."""
    if have & lexicon.DELTA:
        for kind, named in (
            ("dtheta", lexicon.DELTA_ANGLE),
            ("dv", lexicon.DELTA_VELOCITY),
            ("t", {"t", "time"}),
        ):
            if have & named:
                return kind
    return "dtheta" if have & {"dt", "da"} and axis else None


def _kind(have: set[str], joined: str, axis: str | None) -> str | None:
    """gyro, accel or alpha (which of the two its neighbours tell); None where it is neither."""
    spoken = bool(have & lexicon.ANGULAR and have & lexicon.SPEED)
    gyro = spoken or have & lexicon.GYRO or joined in lexicon.GYRO
    gyro = gyro or have & {"angularvelocity", "angularrate"}
    gyro = bool(gyro) or (have - {"imu", "sensor", "body", "raw"} == {"rate"} and bool(axis))
    # single letters tell only where they stand nearly alone
    have = {"accel" if w == "ag" else w for w in have}
    have = {w for w in have if not lexicon.CHIP.fullmatch(w)}
    others = have - lexicon.BESIDE_LETTERS
    if "a" in have:
        others -= lexicon.FREE  # user_a_x
    named = bool(have & (lexicon.GYRO - lexicon.LETTERS))
    force = have & (lexicon.ACCEL - lexicon.LETTERS) or joined in lexicon.ACCEL - lexicon.LETTERS
    force = force or {"specific", "force"} <= have or {"g", "force"} <= have
    if gyro and not named and force:
        gyro = False
    if not gyro:
        if force:
            return "accel"
        if not axis or len(others) != 1:
            return None
        return {
            "g": "gyro",
            "w": "gyro",
            "gy": "gyro",
            "a": "accel",
            "ac": "accel",
            "f": "accel",
            "alpha": "alpha",
        }.get(next(iter(others)))
    if not named and have & lexicon.LETTERS and len(others) > 1 and not spoken:
        return None
    return "gyro"


def _reading(kind: str, axis: str | None, words: list[str]) -> Meaning:
    """A reading of a kind, with its rank among others of that kind and a unit that its words
    imply.
    """
    have = {"accel" if w == "ag" else w for w in words if not lexicon.CHIP.fullmatch(w)}
    group = next(
        (w for w in words if re.fullmatch(r"(?:imu|sensor|gyro|acc|accel|mpu|s)_?\d+", w)), ""
    )
    rank = 2 if kind == "accel" and have & lexicon.FREE else 1
    if have & {"uncalibrated", "uncal", "raw", "adc", "counts", "lsb"}:
        rank = max(rank, 2)
    if have & {"unfiltered", "unfilt"}:
        rank = 3
    implied = kind == "accel" and have & {"gf", "gforce"} or {"g", "force"} <= have
    unit = "g" if implied else None
    if axis is None:
        return Meaning(kind, None, unit, rank, why=f"named {kind}", group=group)
    said = "an accelerometer" if kind in ("accel", "dv") else "a gyro"
    return Meaning(kind, axis, unit, rank, why=f"named {said}", group=group)
