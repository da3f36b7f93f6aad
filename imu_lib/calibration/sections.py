"""What was done when in a record of poses or rate steps.

The list (`--poses`) is a CSV file with a header and one row per pose or rate step, or a JSON file
of named sections (`x_p x_a y_p y_a z_p z_a x_rot y_rot z_rot`, each with `start` and `stop` in
samples), as the six positions and three turns of Ferraris are usually stored.

| column | meaning |
|---|---|
| `start`, `stop` | s from the first sample of the record |
| `x`, `y`, `z` | what ideal accelerometers read there, g (0, 0, 1 with z up) |
| `rate_x`, `rate_y`, `rate_z` | true angular rate, deg/s |
| `angle_x`, `angle_y`, `angle_z` | true angle turned between start and stop, deg |
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..units import DEG, G
from .triad import AXES

GROUPS = {
    "force": ("x", "y", "z"),
    "rate": ("rate_x", "rate_y", "rate_z"),
    "angle": ("angle_x", "angle_y", "angle_z"),
}


@dataclass(frozen=True)
class Section:
    """One pose or rate step: `start`, `stop` in s; `force` (3,) in g, `rate` (3,) in rad/s where
    known.
    `turn` holds an angle (3,) in rad instead, whose sign is taken from the record when `signed` is
    False.
    """

    start: float
    stop: float
    force: np.ndarray | None = None
    rate: np.ndarray | None = None
    turn: np.ndarray | None = None
    signed: bool = True


def read_poses(path: str | Path, fs: float) -> list[Section]:
    """Sections from a CSV or JSON file (see the top of this module); `fs` turns samples into
    seconds.

    Raises
    ------
    InputError
        Naming the file and the row or column.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "not text"
        raise InputError(
            f"{path}: the poses cannot be read ({why}); name a CSV or JSON file of poses."
        ) from None
    return (
        _json_sections(path, text, fs)
        if path.suffix.lower() == ".json"
        else _csv_sections(path, text)
    )


def _json_sections(path: Path, text: str, fs: float) -> list[Section]:
    try:
        table = json.loads(text)
        items = [
            (name, float(v["start"]) / fs, float(v.get("stop", v.get("end"))) / fs)
            for name, v in table.items()
        ]
    except (ValueError, TypeError, AttributeError, KeyError):
        raise InputError(
            f'{path}: expected named sections in samples, {{"x_p": {{"start": 540, "stop": '
            f"1271}}, ...}}."
        ) from None
    out = []
    for name, start, stop in items:
        axis, _, what = name.partition("_")
        if axis not in AXES or what not in ("p", "a", "rot"):
            raise InputError(
                f"{path}: section {name!r} is not one of x_p, x_a, x_rot and the same of y and z."
            )
        unit = np.eye(3)[AXES.index(axis)]
        out.append(
            Section(start, stop, turn=2 * np.pi * unit, signed=False)
            if what == "rot"
            else Section(start, stop, force=unit if what == "p" else -unit)
        )
    return out


def _csv_sections(path: Path, text: str) -> list[Section]:
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    between = max(",;\t", key=lines[0].count) if lines else ","
    rows = list(csv.DictReader(lines, delimiter=between))
    if not rows:
        raise InputError(
            f"{path}: no pose in the file; a header and one row per pose are expected."
        )
    names = {(k or "").strip() for k in rows[0]}
    if not {"start", "stop"} <= names:
        raise InputError(
            f"{path}: the columns start and stop (s) are needed; found {', '.join(sorted(names))}."
        )
    found = [
        _section(path, number, _numbers(path, number, row)) for number, row in enumerate(rows, 2)
    ]
    sizes = [np.linalg.norm(s.force) for s in found if s.force is not None]
    if sizes and np.all(np.abs(np.divide(sizes, G) - 1.0) < 0.05):
        raise InputError(
            f"{path}: x, y, z are in g, and those of every row are {np.mean(sizes):.3g} together, "
            f"as in m/s^2; divide them by {G:g}."
        )
    return found


def _numbers(path: Path, number: int, row: dict) -> dict[str, float]:
    """The numbers of a row by column; other columns are left alone."""
    values = {}
    for key, cell in row.items():
        key = (key or "").strip()
        if key in ("start", "stop") or any(key in g for g in GROUPS.values()):
            if cell is None or not cell.strip():
                continue
            try:
                values[key] = float(cell.replace(",", "."))
            except ValueError:
                values[key] = np.nan
            if not np.isfinite(values[key]):
                raise InputError(
                    f"{path}: row {number}, column {key}: {cell.strip()!r} is not a number."
                )
    return values


def _section(path: Path, number: int, values: dict[str, float]) -> Section:
    if not {"start", "stop"} <= values.keys():
        raise InputError(f"{path}: row {number} has no start or no stop.")
    found = {
        g: np.array([values.get(c, 0.0) for c in cols])
        for g, cols in GROUPS.items()
        if values.keys() & set(cols)
    }
    if not found:
        raise InputError(
            f"{path}: row {number} says nothing about the pose; give x, y, z in g or rate_x, "
            "rate_y, rate_z in deg/s."
        )
    return Section(
        values["start"],
        values["stop"],
        found.get("force"),
        found["rate"] * DEG if "rate" in found else None,
        found["angle"] * DEG if "angle" in found else None,
    )
