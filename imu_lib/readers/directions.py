"""Axes that are named by their direction in the body: longitudinal and lateral acceleration, yaw
rate, forward and down; and sensors that are numbered beside their axis.
"""

from __future__ import annotations

import re

from imu_lib.readers import lexicon

FORCE = {
    "longitudinal": "x", "long": "x", "longi": "x", "surge": "x", "inline": "x", "lon": "x",
    "lateral": "y", "lat": "y", "sway": "y", "transverse": "y",
    "vertical": "z", "vert": "z", "heave": "z",
}  # fmt: skip
TURN = {"roll": "x", "pitch": "y", "yaw": "z"}
_BODY = {
    "fwd": "x",
    "forward": "x",
    "front": "x",
    "right": "y",
    "left": "y",
    "down": "z",
    "up": "z",
}
ALONG = "by its direction"
TURNED = re.compile(
    r"^(?:[-\u2212]\s*|(?:neg|minus|inv|inverted|negated)[ _])(?=[A-Za-z])", re.IGNORECASE
)
_PLACES = "left|right|l|r|a|b|c|front|rear|upper|lower|top|bottom|wrist|thigh|shank|foot|hip|chest|waist|head|back|primary|secondary"
_LETTERS = {"g", "w", "a", "f", "t"}
_WHOLE = {
    **{f"{w}rate": ("rate", a) for w, a in {**TURN, "gier": "z", "nick": "y", "wank": "x"}.items()},
    **{f"{w}speed": ("rate", a) for w, a in TURN.items()},
    **{
        f"{w}beschleunigung": ("acceleration", a)
        for w, a in {"langs": "x", "laengs": "x", "quer": "y", "vertikal": "z"}.items()
    },
    **{
        f"{w}{kind}": ("acceleration", FORCE[w])
        for w in ("long", "lon", "lat", "vert", "inline", "lateral", "longitudinal", "vertical")
        for kind in ("acc", "accel", "g")
    },
}
_KINDS = "|".join(sorted(lexicon.KIND_OF, key=len, reverse=True))


def axis_of(words: list[str]) -> tuple[list[str], str] | None:
    """The words without the direction and the axis that it is; None where no direction stands
    beside a word for a sensor.
    """
    if len(words) == 1 and words[0] in _WHOLE:
        word, axis = _WHOLE[words[0]]
        return (["gyro"] if word == "rate" else [word]), axis
    said = [w for w in words if w in FORCE or w in TURN or w in _BODY]
    rest = [w for w in words if w not in said]
    if len(said) != 1 or not rest:
        return None
    have = set(rest)
    if have == {"g"} and said[0] in FORCE:
        return ["gforce"], FORCE[said[0]]  # G_Lon
    force = bool(have & (lexicon.ACCEL - _LETTERS)) or have == {"a"}
    turn = bool(have & (lexicon.GYRO - _LETTERS))
    for is_there, axes in ((force, FORCE), (turn, TURN), (force or turn, _BODY)):
        if is_there and said[0] in axes:
            return rest, axes[said[0]]
    return None


def without_number(tokens: list[str], axis: str | None) -> list[str]:
    """The words of a heading without the number of the sensor: gyro1_x, gx1, acc_x_2 are the gyro,
    the gyro and the accelerometer. A number that may be the axis stays.
    """
    out = [re.sub(rf"^((?:{_KINDS})[xyz])\d{{1,2}}$", r"\1", t) for t in tokens]
    out = [re.sub(rf"^({_KINDS})\d{{1,2}}([xyz])$", r"\1\2", t) for t in out]
    if len(out) > 1:
        out = [re.sub(r"^([xyz])\d{1,2}$", r"\1", t) for t in out]
    if axis is None and not any(re.fullmatch(rf"(?:{_KINDS})?[xyz]", t) for t in out):
        return tokens
    out = [re.sub(rf"^({_KINDS})\d{{1,2}}$", r"\1", t) for t in out]
    return [t for t in out if not t.isdigit()] or tokens


def place(name: str) -> tuple[str, str] | None:
    """The place that a heading begins or ends with, and the heading without it; None where there is
    none.
    """
    found = re.match(rf"^({_PLACES})[ _.](?=[^\W\d])(.+)$", name.strip(), re.IGNORECASE)
    if found:
        return found[1].lower(), found[2]
    found = re.match(rf"^(.+)[ _.]({_PLACES})$", name.strip(), re.IGNORECASE)
    return (found[2].lower(), found[1]) if found else None


def turn(name: str) -> bool:
    """Whether a heading names a turn (roll, pitch, yaw), which stands alone in many a log."""
    return bool(re.search(r"roll|pitch|yaw|gier|nick|wank", name, re.IGNORECASE))
