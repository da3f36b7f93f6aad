"""What a heading is by those beside it: sensors named by their place, turned signs, p, q and r."""

from __future__ import annotations

import re

from imu_lib.readers import directions, lexicon, names
from imu_lib.readers.asking import Asked, Unnamed, suggestion, units_too
from imu_lib.readers.names import SIGNALS, Meaning
from imu_lib.readers.raw import Raw


def families(told: list[Meaning], headings) -> list[Meaning]:
    """Sensors that are named by their place (left_gx, right_gx; gx_A, gx_B), where several places
    are named; and directions that no second one stands beside, which are none (vert_acc of a
    receiver).
    """
    out = _compass(_following(told, headings), headings)
    places = [directions.place(h.name) for h in headings]
    if len({p[0] for p in places if p}) > 1:
        for i, found in enumerate(places):
            if found and out[i].quantity is None and out[i].why == names.UNKNOWN:
                out[i] = names.meaning(found[1])
    out = _by_unit(out, headings)
    for kind in ("gyro", "accel"):
        said = {
            i: m
            for i, m in enumerate(out)
            if m.quantity == kind and directions.ALONG in m.why and not m.unit
        }
        if len({m.axis for m in said.values()}) == 1:
            for i in said:
                if not directions.turn(headings[i].name):
                    out[i] = Meaning(why=names.UNKNOWN)
    return out


def _by_unit(told: list[Meaning], headings) -> list[Meaning]:
    """Three axes of one abbreviation (AsX, AsY, AsZ) that state a unit of rate or force, where no
    other column is that sensor: they are. A word that is not known may be anything's.
    """
    out = list(told)
    for kind in ("gyro", "accel"):
        if any(m.quantity == kind and m.axis for m in out):
            continue
        found: dict[str, dict[str, tuple[int, str]]] = {}
        for i, (m, h) in enumerate(zip(out, headings)):
            unit = names.unit_of(h.unit or names.spelled_unit(h.name) or "")
            head, axis = names.stem(h.name)
            short = len(head) <= 2 and m.why == names.UNKNOWN and h.kind == "number"
            if short and axis and unit in names.UNITS[kind]:
                found.setdefault(head, {})[axis] = i, unit
        whole = [three for three in found.values() if set(three) == set("xyz")]
        for axis, (i, unit) in whole[0].items() if len(whole) == 1 else ():
            out[i] = Meaning(kind, axis, unit, 2, why=f"one of three axes in {unit}")
    return out


#: An axis before a word that says nothing; X_Value alone is LabVIEW's abscissa.
_VALUE = re.compile(r"([xyz])[ _.-]?(val(?:ue)?|axis|data|reading)", re.IGNORECASE)


def values(told: list[Meaning], headings) -> list[Meaning]:
    """X_Value beside Y_Value and Z_Value is an axis, no abscissa."""
    there = {
        m[1].lower(): i for i, h in enumerate(headings) if (m := _VALUE.fullmatch(h.name.strip()))
    }
    if set(there) != set("xyz") or told[there["x"]].quantity != "time":
        return told
    out = list(told)
    out[there["x"]] = Meaning(why=names.UNKNOWN)
    return out


def one_triple(told: list[Meaning], headings) -> dict[str, int]:
    """x, y, z -> column, where three columns of unknown names differ in the axis at their end
    alone, and no other three do; empty otherwise.
    """
    found: dict[str, dict[str, int]] = {}
    for i, (m, h) in enumerate(zip(told, headings)):
        first = _VALUE.fullmatch(h.name.strip())
        head, axis = (first[2], first[1].lower()) if first else names.stem(h.name)
        if axis in ("x", "y", "z") and h.kind == "number" and m.why == names.UNKNOWN:
            found.setdefault(head.lower(), {}).setdefault(axis, i)
    whole = [three for three in found.values() if len(three) == 3]
    return {a: whole[0][a] for a in "xyz"} if len(whole) == 1 else {}


def _following(told: list[Meaning], headings) -> list[Meaning]:
    """Bare y and z behind a column that names its sensor and x are of that sensor; so are x, y and
    z behind one that names the sensor alone and is empty, as a nested message is laid flat.
    """
    out = list(told)
    bare = [h.name.strip().lower() for h in headings]
    for i, m in enumerate(told[:-3]):
        empty = headings[i].kind == "empty" and m.quantity in SIGNALS and not m.axis
        if empty and bare[i + 1 : i + 4] == ["x", "y", "z"]:
            for k, axis in enumerate("xyz", i + 1):
                out[k] = Meaning(
                    m.quantity, axis, m.unit, m.rank, why=f"under `{headings[i].name.strip()}`"
                )
    for i, m in enumerate(told[:-2]):
        if m.quantity in SIGNALS and m.axis == "x" and bare[i + 1 : i + 3] == ["y", "z"]:
            if all(told[k].quantity is None for k in (i + 1, i + 2)):
                for k, axis in ((i + 1, "y"), (i + 2, "z")):
                    out[k] = Meaning(
                        m.quantity, axis, m.unit, m.rank, why=f"behind `{headings[i].name.strip()}`"
                    )
    return out


_ORDER = re.compile(r"\(\s*([xyz])\s*,\s*([xyz])\s*,\s*([xyz])\s*\)", re.IGNORECASE)


def behind(raw: Raw, told: list[Meaning], headings) -> list[Meaning]:
    """Columns called 1 and 2, or nothing, behind one that names a sensor and no axis are its
    others; in which order is said in the name, (z,x,y), or asked.
    """
    out = list(told)
    for i, m in enumerate(told[:-2]):
        rest = [h.name.strip() for h in headings[i + 1 : i + 3]]
        if m.quantity not in ("gyro", "accel") or m.axis or rest not in (["1", "2"], ["", ""]):
            continue
        if any(headings[k].kind != "number" or told[k].quantity for k in (i + 1, i + 2)):
            continue
        order = _ORDER.search(headings[i].name)
        axes = [a.lower() for a in order.groups()] if order else ["x", "y", "z"]
        three = [
            Meaning(m.quantity, a, m.unit, m.rank, why=f"under `{headings[i].name.strip()}`")
            for a in axes
        ]
        out[i : i + 3] = three
        if sorted(axes) != ["x", "y", "z"] or not order:
            raise Unnamed(
                f"{raw.source}: `{headings[i].name}` and the two columns behind it are three axes, "
                "and nothing says in what order (a camera's may be z, x, y); "
                f"{suggestion(out, headings)}{units_too(out)}."
            )
    return out


_POINT = re.compile(
    r"^(.*[A-Za-z\d])(?:[ _.]|(?<=[a-z])(?=[A-Z]))((?i:east|north|up|down|[enud]))(?=[ _.\[(]|"
    r"$)(.*)$"
)
#: Points of the compass as the axes that they are in a right-handed frame.
_FRAMES = ({"e": "x", "n": "y", "u": "z"}, {"n": "x", "e": "y", "d": "z"})


def _compass(told: list[Meaning], headings) -> list[Meaning]:
    """Readings along east, north, up or north, east, down, where all three are named."""
    out = list(told)
    found: dict[str, dict[str, tuple[int, Meaning]]] = {}
    for i, h in enumerate(headings):
        if point := _POINT.match(h.name.strip()):
            along = names.meaning(f"{point[1]}_x{point[3]}")
            if along.quantity in ("gyro", "accel") and along.axis == "x":
                there = found.setdefault(along.quantity, {})
                there.setdefault(point[2][0].lower(), (i, along))
    for there in found.values():
        frame = next((f for f in _FRAMES if set(f) == set(there)), {})
        for letter, axis in frame.items():
            i, along = there[letter]
            unit = names.unit_of(headings[i].unit or "") or along.unit
            why = f"{along.why}, {', '.join(frame)} as x, y, z"
            out[i] = Meaning(along.quantity, axis, unit, along.rank, why=why)
    return out


def turned(raw: Raw, told: list[Meaning], headings) -> None:
    """InputError where a heading says that the sign of a reading was turned."""
    heads = [h.name.strip() for h in headings]
    plain = [names.meaning(directions.TURNED.sub("", n, count=1)) for n in heads]
    turned = [
        i
        for i, n in enumerate(heads)
        if directions.TURNED.match(n) and plain[i].quantity in SIGNALS and plain[i].axis
    ]
    if turned:
        all_told = [plain[i] if i in turned else m for i, m in enumerate(told)]
        raise Asked(
            f"{raw.source}: `{heads[turned[0]]}` says that its sign is turned; turn it in the "
            "file and rename the column, or have the values "
            f"as they stand: {suggestion(all_told, headings)}{units_too(all_told)}."
        )


def _suffix_unit(name: str) -> str | None:
    """The unit behind a lone letter: p_radps."""
    tail = lexicon.SUFFIX.search(name.strip().lower())
    return lexicon.SUFFIX_UNIT.get(tail[1]) or names.unit_of(tail[1]) if tail else None


def body_rates(told: list[Meaning], headings) -> list[Meaning]:
    """p, q, r are the body rates of aeronautics where all three stand there, no other column is the
    gyro, and they may not be part of a quaternion.
    """
    heads = [
        lexicon.SUFFIX.sub("", re.sub(r"[\[(].*", "", h.name).strip().lower()) for h in headings
    ]
    there = [i for i, m in enumerate(told) if m.quantity is None and m.why == names.UNKNOWN]
    rates = {heads[i]: i for i in there if heads[i] in ("p", "q", "r")}
    whole = {"q0", "q1", "q2", "q3"} <= set(heads) or {"qw", "qx", "qy", "qz"} <= set(heads)
    scalar = {"qw", "q0", "q_w", "q_0"} & set(heads) and not whole  # p, q, r may be its vector
    if scalar or len(rates) < 3 or any(m.quantity in ("gyro", "dtheta") and m.axis for m in told):
        return told
    out = list(told)
    for axis, i in zip("xyz", (rates["p"], rates["q"], rates["r"])):
        out[i] = Meaning(
            "gyro",
            axis,
            names.spelled_unit(headings[i].name) or _suffix_unit(headings[i].name),
            why="p, q, r: the body rates of aeronautics",
        )
    return out
