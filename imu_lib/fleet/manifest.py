"""Which records a fleet is: a folder, or a table that says sensor, date and how to read each."""

from __future__ import annotations

import csv
import difflib
import io
from dataclasses import dataclass, replace
from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.fleet import folders, names
from imu_lib.fleet.folders import SUFFIXES
from imu_lib.words import listed

#: Columns of a manifest that say how to read the file, and what makes of its text an option.
OPTIONS = {
    "rate": float,
    "time_unit": str,
    "gyro_unit": str,
    "accel_unit": str,
    "columns": str,
    "topic": str,
    "start": float,
    "stop": float,
}
COLUMNS = ("file", "sensor", "date", *OPTIONS)
#: Likeness of two names from which one is taken for the other misspelt.
ALIKE = 0.75


@dataclass(frozen=True)
class Entry:
    """One record: its file, the sensor it is of, the day (YYYY-MM-DD or empty), how to read it."""

    file: str
    path: str
    sensor: str
    date: str
    options: tuple
    where: str = ""  # the manifest's line, for messages
    note: str = ""  # how its name was understood, where it might be otherwise

    @property
    def reading(self) -> dict:
        return dict(self.options)


def entries(path, *, sensor=None, record=None, **options) -> list[Entry]:
    """The records of a folder (with its subfolders) or of a manifest, in order of their names or
    lines.

    In a folder a sensor is a subfolder, or a file's name without its date
    (`unit012_2024-05-01.npz` is `unit012`); a subfolder of consecutive logs is one record
    (`folders.records`, which `sensor` and `record` are for). A manifest is a `.csv` with the column
    `file` and, where known, `sensor`, `date` and the reading options as columns. `options` hold for
    all records. InputError where there is none, or a line is wrong.
    """
    path = Path(path)
    if path.is_dir():
        found = [
            Entry(one.name, str(one.path), one.sensor, one.date, _pairs(options), note=one.note)
            for one in folders.records(path, sensor=sensor, record=record, **options)
        ]
    elif path.is_file():
        if sensor or record:
            raise InputError(
                f"{path} is a manifest: its columns say what is a sensor and a record; leave out "
                f"--{'sensor' if sensor else 'record'}."
            )
        found = _of_table(path, options)
    else:
        raise InputError(f"{path} does not exist; give a folder of records or a manifest (.csv).")
    if not found:
        raise InputError(f"{path} holds no record ({', '.join(SUFFIXES)}).")
    return found


def _rows(path):
    """(names of a manifest's columns, (line, its fields by name) of each row)."""
    raw = path.read_bytes()
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", "replace")
    head = next((line for line in text.splitlines() if line.strip()), "")
    if "\0" in text[:4096] or not head:
        raise InputError(
            f"{path} is no table of records: give a folder of them, or a .csv with one record a "
            "line (file, sensor, date); `imu-lib characterise` takes a single record."
        )
    before = text.index(head)
    blank = len(text[:before].splitlines())
    between = max(",;\t", key=head.count)
    try:
        reader = csv.DictReader(io.StringIO(text[before:], newline=""), delimiter=between)
        known = [(name or "").strip().lower() for name in reader.fieldnames or []]
        reader.fieldnames = known
        return known, [(blank + reader.line_num, row) for row in reader]
    except csv.Error as error:
        raise InputError(f"{path} cannot be read as a table ({error}); save it anew.") from None


def _of_table(path, options):
    known, rows = _rows(path)
    if "file" not in known:
        raise InputError(
            f"{path} has no column `file`; a manifest names one record a line: file, sensor, date."
        )
    left = _left_out(path, known)
    if not rows:
        raise InputError(f"{path} names no record; a line is one: file, sensor, date.")
    out, seen = [], {}
    for line, row in rows:
        where = f"{path}, line {line}"
        if row.get(None):
            raise InputError(f"{where}: has more fields than the first line; mend the line.")
        one = _of_line(path, where, {k: (v or "").strip() for k, v in row.items()}, options)
        file = Path(one.path).resolve()
        if file in seen:
            raise InputError(f"{where}: {one.file} stands on line {seen[file]} already.")
        seen[file] = line
        out.append(one)
    return [replace(one, note=left) for one in out]


def _left_out(path, known):
    """The sentence on columns that a fleet has no use for; InputError where one looks like a
    misspelt one that it has.
    """
    ours = {_letters(k): k for k in COLUMNS}
    left = [k for k in known if k and k not in COLUMNS]
    for name in left:
        near = difflib.get_close_matches(_letters(name), ours, 1, ALIKE)
        near += [own for own in ours if _letters(name).endswith(own)]
        if near:
            raise InputError(
                f"{path} has the column `{name}`; where `{ours[near[0]]}` is meant, rename it, "
                f"else remove it (known are {listed(list(COLUMNS))})."
            )
    if not left:
        return ""
    some = listed([f"`{name}`" for name in left])
    return f"{path}: a fleet has no use for {some}; known columns are {listed(list(COLUMNS))}."


def _letters(name):
    return "".join(filter(str.isalpha, name.lower()))


def _of_line(path, where, row, options) -> Entry:
    name = row["file"]
    if not name:
        raise InputError(f"{where}: names no file; remove the line.")
    own = {
        key: _option(where, key, kind, row[key]) for key, kind in OPTIONS.items() if row.get(key)
    }
    place = _place(path, name)
    sensor, date = names.sensor_and_date(Path(name.replace("\\", "/")).stem)
    if row.get("date"):
        date = names.a_date(row["date"])
        if not date:
            raise InputError(f"{where}: the date {row['date']!r} is no day of the form 2024-05-01.")
    sensor = row.get("sensor") or sensor
    return Entry(name, str(place), sensor, date, _pairs({**options, **own}), where)


def _option(where, key, kind, text):
    if kind is str:
        return text
    try:
        number = kind(text.replace(",", ".") if text.count(",") == 1 else text)
    except ValueError:
        raise InputError(f"{where}: `{key}` is {text!r}, not a number.") from None
    if number < 0 or (key == "rate" and not 0 < number < float("inf")):
        raise InputError(f"{where}: `{key}` is {text}; it is above 0.")
    return number


def _place(path, name):
    """The file that a line names, from the manifest's folder; one written with backslashes too."""
    place = path.parent / name  # an absolute name stays what it is
    other = path.parent / name.replace("\\", "/")
    return other if other.exists() and not place.exists() else place


def _pairs(options):
    return tuple(sorted((k, v) for k, v in options.items() if v is not None))
