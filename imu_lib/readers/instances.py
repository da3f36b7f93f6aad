"""Rows of several sensors of one kind in one table, told apart by a column: `I` 0 and 1 of a flight
log, `sensor` left and right, the address of a device.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.asking import Heading
from imu_lib.readers.lexicon import words
from imu_lib.readers.names import SIGNALS, Meaning

#: Headings of a column that says whose reading a row is.
NAMED = words(
    "i instance inst imu imuid imuno imunumber imuindex id sensor sensorid sensorno sensornumber"
    " sensorindex sensorname sensortype streamtype device deviceid devicename deviceaddress "
    "deviceno dev devid unit unitid node nodeid address addr mac"
    " macaddress board boardid chip chipid channel source src name tag serial serialnumber sn port"
    " type canid slave"
)


class Several(InputError):
    """Rows of several sensors, and the call does not say which; raw: what the file holds."""

    def __init__(self, said: str, raw=None):
        super().__init__(said)
        self.raw = raw


MOST = 12  # sensors; a column of more values is no such column
FEWEST = 5  # rows of a sensor


@dataclass(frozen=True)
class Instances:
    """heading: of the column that tells sensors apart; labels (n,): what it says of each row, as
    text; values: those that stand beside readings of one kind.
    """

    heading: str
    labels: np.ndarray
    values: tuple[str, ...]


def find(
    told: Sequence[Meaning], headings: Sequence[Heading], load: Callable, kinds=None, skip: int = -1
) -> Instances | None:
    """The column that tells several sensors apart; None where the rows are of one sensor.

    kinds : masks (n,) of the rows of each kind, where those stand in rows of their own; skip : the
    column that names the kind then.
    """
    signals = kinds or [i for i, m in enumerate(told) if m.quantity in SIGNALS and m.axis]
    named = [
        i
        for i, h in enumerate(headings)
        if told[i].quantity in (None, "counter")
        and i != skip
        and h.kind in ("number", "text")
        and _plain(h.name) in NAMED
    ]
    if not named or not signals:
        return None
    values = load(named)
    for i in named:
        labels = text(values[i])
        found, place = np.unique(labels, return_inverse=True)
        if not 2 <= len(found) <= MOST:
            continue
        for there in kinds or map(_there, load(signals).values()):
            rows = np.bincount(place[there], minlength=len(found))
            if (rows >= FEWEST).sum() > 1:
                return Instances(headings[i].name, labels, tuple(found[rows >= FEWEST].tolist()))
    return None


def bare(told: Sequence[Meaning], headings: Sequence[Heading], load: Callable) -> Instances | None:
    """The column that tells the sensors of a table by rows apart whose x, y, z name none; None
    where no column of a known name does.
    """
    letters = {
        h.name.strip().lower().strip("_-. ").removesuffix("axis").strip("_-. ") for h in headings
    }
    if not {"x", "y", "z"} <= letters:
        return None
    named = [
        i
        for i, h in enumerate(headings)
        if told[i].quantity in (None, "counter") and h.kind == "number" and _plain(h.name) in NAMED
    ]
    values = load(named) if named else {}
    for i in sorted(named, key=lambda i: "type" not in _plain(headings[i].name)):
        labels = text(values[i])
        found, rows = np.unique(labels, return_counts=True)
        if 2 <= len(found) <= MOST and (rows >= FEWEST).sum() > 1:
            return Instances(headings[i].name, labels, tuple(found[rows >= FEWEST].tolist()))
    return None


def _plain(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())


def _there(x) -> np.ndarray:
    x = np.asarray(x)
    return np.isfinite(x) if x.dtype.kind == "f" else np.ones(len(x), dtype=bool)


def text(x) -> np.ndarray:
    """Values as text, whole numbers without a point."""
    x = np.asarray(x)
    if x.dtype.kind == "f" and np.isfinite(x).all() and (x == np.rint(x)).all():
        x = x.astype(np.int64)
    return np.char.strip(x.astype(str))


def numbered(headings: Sequence[Heading], values) -> str | None:
    """A clause on a column whose few whole numbers take turns from row to row; None where none
    does.

    values : column number -> values, None where they could not be loaded.
    """
    for i, x in (values or {}).items():
        x = np.asarray(x)
        if x.dtype.kind not in "iu" or len(x) < 40:
            continue
        found = np.unique(x[:4000])
        if 2 <= len(found) <= MOST and (np.diff(x) != 0).mean() > 0.5:
            periods = range(2, 2 * len(found) + 1)
            by_turns = any((x[p:] == x[:-p]).mean() > 0.8 for p in periods)
            if by_turns and 0 <= found[0] and found[-1] < 100_000:
                some = ", ".join(str(v) for v in found[:5])
                return f"`{headings[i].name}` holds {some} by turns"
    return None


def rows(found: Instances | None, topic: str | None, source: str) -> np.ndarray | None:
    """The rows to keep by `--topic COLUMN=VALUE`, None where all are. InputError where the file
    holds several sensors and the call does not say which, or says one that is not there.
    """
    if found is None:
        return None
    column, _, value = (topic or "").rpartition("=")
    if column == found.heading and value == "*":
        return None
    if column == found.heading and value in found.values:
        return np.flatnonzero(found.labels == value)
    first, *others = (f"--topic '{found.heading}={v}'" for v in found.values)
    raise Several(
        f"{source}: `{found.heading}` tells {len(found.values)} sensors apart "
        f"({', '.join(found.values)}), whose rows stand in one table; "
        f"choose one with {first} or {' or '.join(others[:3])} (--topic '{found.heading}=*' if "
        "all rows are of one sensor)."
    )
