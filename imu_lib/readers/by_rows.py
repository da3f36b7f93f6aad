"""Tables in which each row is a reading of one sensor, named in a column of text: `ACC,x,y,z` and
`GYR,x,y,z` in turn. They become columns of their own, empty where the other sensor has its row.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import instances, names, time_columns
from imu_lib.readers.asking import Heading, Unnamed
from imu_lib.readers.names import Meaning
from imu_lib.readers.raw import Raw


@dataclass(frozen=True)
class Sensors:
    """label: the column that names the sensor. xyz: those of the readings."""

    label: int
    xyz: tuple[int, int, int]


def sensors(told: Sequence[Meaning], headings: Sequence[Heading]) -> Sensors | None:
    """The columns of a table by rows, None where it is none: one column of text, and x, y, z that name
    no sensor.
    """
    if any(m.quantity in names.SIGNALS for m in told):
        return None
    texts = [i for i, h in enumerate(headings) if h.kind == "text"]
    bare = _axes(headings)
    if not texts or sorted(bare) != [0, 1, 2]:
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
            words.setdefault(word.strip("_ []()."), i)
    for three in ("xyz", ("v0", "v1", "v2"), ("v1", "v2", "v3"), "123", ("s0", "s1", "s2")):
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
    rows: dict[str, np.ndarray] = {}
    stated: dict[str, str | None] = {}
    letters = {x.strip().lower() for x in np.unique(labels) if len(x.strip()) == 1}
    for label in np.unique(labels):
        if len(label.strip()) == 1 and not ("a" in letters and letters & {"g", "w"}):
            continue  # a letter alone is a name, as left and right are
        found = names.meaning(f"{label} x")
        rank = found.rank
        if found.quantity not in ("gyro", "accel"):
            continue
        if found.quantity in rows and rank > 1:
            continue
        if found.quantity in rows:
            raise InputError(
                f"{raw.source}, `{headings[long.label].name}`: more than one label names a {found.quantity}; keep the rows of one."
            )
        rows[found.quantity], stated[found.quantity] = labels == label, found.unit
    if not rows:
        raise Unnamed(
            f"{raw.source}: `{headings[long.label].name}` names no gyro or accelerometer ({', '.join(np.unique(labels)[:6])}); "
            "keep the rows of one sensor and give the file as --gyro FILE or --accel FILE."
        )
    use = np.logical_or.reduce(list(rows.values()))
    line = raw.line
    place = np.flatnonzero(use)
    several = instances.find(told, headings, load, list(rows.values()), long.label)
    if several:
        raw.instances = replace(several, labels=several.labels[use])
    raw.line = lambda row: line(int(place[min(row, len(place) - 1)]))
    told = time_columns.one_time(raw, list(told), headings, values)
    for i, (m, h) in enumerate(zip(told, headings)):
        if i in long.xyz:
            continue
        if i == long.label:
            raw.skip(h.name, f"names the sensor of each row: {', '.join(rows)}")
        elif m.quantity in ("time", "date", "clock") and i in values:
            raw.add(m.canonical, np.asarray(values[i])[use], m.unit, h.name, m.why)
        else:
            raw.skip(h.name, m.why if m.quantity is None else "not an inertial reading")
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
            raise InputError(
                f"{raw.source}, column {i + 1}: its rows are readings of different sensors ({', '.join(labels[:6])}), which no --columns can tell apart; "
                "give the columns a header (time, sensor, x, y, z) and leave --columns out."
            )
