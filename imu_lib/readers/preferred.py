"""Of several columns for one axis, one time and one temperature the one that is meant; asked for
where two are equal.
"""

from __future__ import annotations

import re

from imu_lib.readers import names, time_columns, twins
from imu_lib.readers.asking import Asked, suggestion, units_too
from imu_lib.readers.names import SIGNALS, Meaning
from imu_lib.readers.raw import Raw

#: Gravity, or a gyro: a rotation rate in words goes before it.
_LETTER_G = re.compile(r"g[_ .]?[xyz]", re.IGNORECASE)


def one_each(raw: Raw, told, headings, load) -> list[Meaning]:
    """Of several columns for one axis the one that such a name usually heads: the sensor's own
    reading before one that a device has worked on, rates before increments. Asked for where two
    are equal.
    """
    out = list(told)
    own_force = _own_force(told, headings)
    second: dict[str, tuple[int, int]] = {}
    skip: list[int] = []
    equal: list[tuple[str, int, int]] = []
    for canonical in sorted({m.canonical for m in told if m.quantity in SIGNALS and m.axis}):
        there = [i for i, m in enumerate(told) if m.canonical == canonical]
        first = _first(told, headings, there)
        if own_force and canonical.startswith("gyro"):
            first = [i for i in first if not names.worked_on(headings[i].name)] or first
        if len(first) > 1:
            equal.append((canonical, *first[:2]))
            skip += first[1:]
        for i in there:
            if i not in first:
                out[i] = Meaning(why=f"`{headings[first[0]].name}` is {canonical}")
                second.setdefault(canonical.rpartition("_")[0], (first[0], i))
    if equal:  # one sensor's three axes in the example, not a mixture
        canonical, one, other = equal[0]
        skip += time_columns.all_but_best(told, headings, load)
        raise Asked(
            f"{raw.source}: both `{headings[one].name}` and `{headings[other].name}` would be "
            f"{canonical}; {suggestion(told, headings, skip)}{units_too(told, skip)}."
        )
    twins.say(raw, second, headings)
    return _one_temperature(_without_increments(out), headings)


def _own_force(told, headings) -> bool:
    """Whether the accelerometer that is taken is the sensor's own reading beside one that a device
    has worked on: the gyro of that sensor is its own reading too.
    """
    force = [i for i, h in enumerate(headings) if names.meaning(h.name).quantity == "accel"]
    left = [i for i in force if names.worked_on(headings[i].name)]
    own = [i for i in force if i not in left and told[i].quantity == "accel"]
    return bool(left and own) and min(told[i].rank for i in own) <= min(
        (told[i].rank for i in left if told[i].quantity == "accel"), default=9
    )


def _first(told, headings, there: list[int]) -> list[int]:
    """Those of the best rank, what a device has worked on behind the sensor's own."""
    best = min(told[i].rank for i in there)
    first = [i for i in there if told[i].rank == best]
    first.sort(key=lambda i: names.worked_on(headings[i].name))
    lone = [i for i in first if _LETTER_G.fullmatch(headings[i].name.strip())]
    spoken = [i for i in first if re.search(r"[A-Za-z]{3}", headings[i].name)]
    return spoken if lone and len(lone) + len(spoken) == len(first) and spoken else first


def _without_increments(told: list[Meaning]) -> list[Meaning]:
    """Increments are not used where the rates stand beside them."""
    out = told
    for increment, rate, word in (("dtheta", "gyro", "rates"), ("dv", "accel", "specific force")):
        if any(m.quantity == rate and m.axis for m in out):
            beside = Meaning(why=f"increments; the {word} stand beside them")
            out = [beside if m.quantity == increment else m for m in out]
    return out


def _one_temperature(told: list[Meaning], headings) -> list[Meaning]:
    out = list(told)
    temperature = [i for i, m in enumerate(out) if m.quantity == "temperature"]
    if len(temperature) > 1:
        own = [i for i in temperature if out[i].rank <= 1]
        keep = own[0] if own else temperature[0]
        for i in temperature:
            if i != keep:
                out[i] = Meaning(why=f"`{headings[keep].name}` is the temperature")
    return out
