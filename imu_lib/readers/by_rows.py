"""Tables in which each row is a reading of one sensor, named in a column of text: `ACC,x,y,z` and
`GYR,x,y,z` in turn. They become columns of their own, empty where the other sensor has its row.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import families, instances, looks, names, time_columns
from imu_lib.readers.asking import LABEL, Heading, Unnamed
from imu_lib.readers.names import Meaning
from imu_lib.readers.raw import Raw


@dataclass(frozen=True)
class Sensors:
    """label: the column that names the sensor. xyz: those of the readings. words: what the numbers
    of the label stand for, where the lines above the table say it.
    """

    label: int
    xyz: tuple[int, int, int]
    words: dict[str, str] = field(default_factory=dict)


def by_call(told: Sequence[Meaning]) -> Sensors | None:
    """The same of a table whose columns the call names (sensor, x, y, z); None where it does
    not.
    """
    label = [i for i, m in enumerate(told) if m.group == LABEL]
    xyz = [i for a in "xyz" for i, m in enumerate(told) if m.quantity is None and m.axis == a]
    return Sensors(label[0], (xyz[0], xyz[1], xyz[2])) if label and len(xyz) == 3 else None


def sensors(
    raw: Raw, told: Sequence[Meaning], headings: Sequence[Heading], load: Callable
) -> Sensors | None:
    """The columns of a table by rows, None where it is none: one column of text, or of numbers
    that the lines above explain, and x, y, z that name no sensor.
    """
    if any(m.quantity in names.SIGNALS for m in told):
        return None
    bare = _axes(headings) or dict(enumerate(families.one_triple(told, headings).values()))
    if sorted(bare) != [0, 1, 2]:
        return None
    texts = [i for i, h in enumerate(headings) if h.kind == "text"]
    if not texts and raw.legend:
        for i, h in enumerate(headings):
            named = re.search(r"type|sensor|kind|id", h.name, re.IGNORECASE)
            if i not in bare.values() and h.kind == "number" and named:
                said = set(instances.text(load([i])[i]))
                if len(said) > 1 and said <= set(raw.legend):
                    return Sensors(i, (bare[0], bare[1], bare[2]), raw.legend)
    if not texts:
        return None
    named = [
        i
        for i in texts
        if headings[i].name.strip().lower()
        in (
            "sensor",
            "type",
            "name",
            "sensor_type",
            "sensorname",
            "kind",
            "label",
            "source",
            "id",
            "topic",
            "event",
            "stream type",
        )
    ]
    return Sensors((named or texts)[0], (bare[0], bare[1], bare[2]))


def _axes(headings: Sequence[Heading]) -> dict[int, int]:
    """Place of x, y, z (0, 1, 2) -> column, for headings that name an axis and nothing else."""
    words = {}
    for i, h in enumerate(headings):
        word = h.name.strip().lower().rpartition(".")[2]
        for part in ("value", "measurement", "axis"):
            word = word.replace(part, "")
        if h.kind == "number":
            words.setdefault(word.strip("_- []()."), i)
            if place := re.fullmatch(
                r"(?:values?|data|readings?)[\[_. ]?([0-2])\]?", h.name.strip(), re.I
            ):
                words.setdefault(f"#{place[1]}", i)
    for three in (
        "xyz",
        ("#0", "#1", "#2"),
        ("v0", "v1", "v2"),
        ("v1", "v2", "v3"),
        "123",
        ("s0", "s1", "s2"),
    ):
        if all(w in words for w in three):
            return {k: words[w] for k, w in enumerate(three)}
    return {}


def pivoted(
    raw: Raw, long: Sensors, told: Sequence[Meaning], headings: Sequence[Heading], load: Callable
) -> Raw:
    """The raw columns of a table by rows. InputError where its labels name no inertial sensor, or
    two of a kind.
    """
    stamps = [i for i, m in enumerate(told) if m.quantity in ("time", "date", "clock")]
    values = load([long.label, *long.xyz, *stamps])
    labels = np.asarray(values[long.label]).astype(str)
    if long.words:
        labels = np.array([long.words[x] for x in instances.text(values[long.label])])
    rows, stated = _kinds(raw, labels, headings[long.label].name)
    use = np.logical_or.reduce(list(rows.values()))
    line = raw.line
    place = np.flatnonzero(use)
    several = instances.find(told, headings, load, list(rows.values()), long.label)
    if several:
        raw.instances = replace(several, labels=several.labels[use])
    raw.line = lambda row: line(int(place[min(row, len(place) - 1)]))
    told = time_columns.one_time(raw, list(told), headings, values)
    _stamps(raw, long, told, headings, values, use, tuple(rows))
    for kind, chosen in rows.items():
        for axis, i in zip("xyz", long.xyz):
            x = np.where(chosen, np.asarray(values[i], dtype=float), np.nan)[use]
            raw.add(
                f"{kind}_{axis}",
                x,
                names.spelled_unit(headings[i].name) or stated[kind],
                f"{headings[i].name} ({kind})",
                f"rows of the {kind}",
            )
    lost = int((~use).sum())
    if lost:
        raw.notes += (f"{lost:,} rows of other sensors were left out.",)
    return raw


def _kinds(raw: Raw, labels: np.ndarray, heading: str):
    """The rows of the gyro and of the accelerometer, and the unit that their labels state.
    InputError where there is none, or more than one of a kind.
    """
    rows: dict[str, np.ndarray] = {}
    stated: dict[str, str | None] = {}
    letters = {x.strip().lower() for x in np.unique(labels) if len(x.strip()) == 1}
    for label in np.unique(labels):
        if len(label.strip()) == 1 and not ("a" in letters and letters & {"g", "w"}):
            continue  # a letter alone is a name, as left and right are
        found = names.meaning(f"{label} x")
        if found.quantity not in ("gyro", "accel"):
            continue
        if found.quantity in rows and found.rank > 1:
            continue
        if found.quantity in rows:
            raise InputError(
                f"{raw.source}, `{heading}`: more than one label names a {found.quantity}; keep "
                "the rows of one."
            )
        rows[found.quantity], stated[found.quantity] = labels == label, found.unit
    if not rows:
        raise Unnamed(
            f"{raw.source}: `{heading}` names no gyro or accelerometer "
            f"({', '.join(np.unique(labels)[:6])}); keep the rows of one sensor and give the file "
            "as --gyro FILE or --accel FILE."
        )
    return rows, stated


def _stamps(raw: Raw, long: Sensors, told, headings, values, use, kinds) -> None:
    """The stamps of the rows that are used; what else the table has is listed."""
    for i, (m, h) in enumerate(zip(told, headings)):
        if i in long.xyz:
            continue
        if i == long.label:
            raw.skip(h.name, f"names the sensor of each row: {', '.join(kinds)}")
        elif m.quantity in ("time", "date", "clock") and i in values:
            raw.add(m.canonical, np.asarray(values[i])[use], m.unit, h.name, m.why)
        else:
            raw.skip(h.name, m.why if m.quantity is None else "not an inertial reading")


def example(headings: Sequence[Heading], load: Callable) -> str | None:
    """Names by position of a table without a header whose rows begin with the name of a sensor,
    None where it is none.
    """
    label = next(
        (
            i
            for i, h in enumerate(headings)
            if h.kind == "text" and len(_sensors(load([i])[i])) == 2
        ),
        None,
    )
    if label is None:
        return None
    numbers = [i for i, h in enumerate(headings) if h.kind == "number"]
    values = load([label, *numbers])
    first = _sensors(values[label])["gyro"]
    out = ["-"] * len(headings)
    out[label] = LABEL
    free = iter(("x", "y", "z"))
    for i in numbers:
        if looks.rises(np.asarray(values[i], dtype=float)[first]):
            out[i] = "-" if "time" in out else "time"
        else:
            out[i] = next(free, "-")
    return ",".join(out) if "z" in out else None


def _sensors(labels) -> dict[str, np.ndarray]:
    """Rows of the gyro and of the accelerometer by what stands in them."""
    labels = np.asarray(labels).astype(str)
    out: dict[str, np.ndarray] = {}
    for label in np.unique(labels) if len(np.unique(labels[:4000])) <= 12 else ():
        kind = names.meaning(f"{label} x").quantity
        if kind in ("gyro", "accel"):
            out[kind] = labels == label
    return out


def refuse_mixture(
    raw: Raw, told: Sequence[Meaning], headings: Sequence[Heading], load: Callable
) -> None:
    """InputError where the caller names the columns of a table whose rows are readings of several
    sensors by turns.
    """
    for i, heading in enumerate(headings):
        if heading.kind != "text" or told[i].quantity:
            continue
        labels = np.unique(np.asarray(load([i])[i]).astype(str))
        if not 2 <= len(labels) <= 12:
            continue
        kinds = {names.meaning(f"{label} x").quantity for label in labels} & {"gyro", "accel"}
        if len(kinds) == 2:
            how = example(headings, load)
            raise InputError(
                f"{raw.source}, column {i + 1}: its rows are readings of different sensors "
                f"({', '.join(labels[:6])}); "
                + (
                    f"name that column {LABEL} and those of the readings x, y, z: --columns "
                    f"'{how}'."
                    if how
                    else "give the columns a header (time, sensor, x, y, z) and leave --columns "
                    "out."
                )
            )
