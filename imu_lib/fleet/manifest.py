"""Which records a fleet is: a folder, or a table that says sensor, date and how to read each."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.readers import zarr_store

#: What a record's file name may end in.
SUFFIXES = (
    *(".npz", ".npy", ".parquet", ".csv", ".txt", ".tsv", ".mat", ".h5", ".hdf5", ".zarr"),
    *(".bag", ".mcap", ".db3"),
)
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
#: The table that a fleet makes.
TABLE = "fleet.parquet"
_DATE = re.compile(r"(?:^|[_\-. T])((?:19|20)\d\d)-?([01]\d)-?([0-3]\d)(?=$|[_\-. T])")


@dataclass(frozen=True)
class Entry:
    """One record: its file, the sensor it is of, the day (YYYY-MM-DD or empty), how to read it."""

    file: str
    path: str
    sensor: str
    date: str
    options: tuple
    where: str = ""  # the manifest's line, for messages

    @property
    def reading(self) -> dict:
        return dict(self.options)


def entries(path, **options) -> list[Entry]:
    """The records of a folder (with its subfolders) or of a manifest, in order of their names or
    lines.

    In a folder a sensor is a subfolder, or a file's name without its date
    (`unit012_2024-05-01.npz` is `unit012`). A manifest is a `.csv` with the column `file` and,
    where known, `sensor`, `date` and the reading options as columns. `options` hold for all
    records. InputError where there is none, or a line is wrong.
    """
    path = Path(path)
    if path.is_dir():
        found = _of_folder(path, options)
    elif path.is_file():
        found = _of_table(path, options)
    else:
        raise InputError(f"{path} does not exist; give a folder of records or a manifest (.csv).")
    if not found:
        raise InputError(f"{path} holds no record ({', '.join(SUFFIXES)}).")
    return found


def _of_folder(folder, options):
    files = sorted(
        p
        for p in folder.rglob("*")
        if p.suffix.lower() in SUFFIXES
        and (p.is_file() or zarr_store.is_store(p))
        and not any(zarr_store.is_store(above) for above in p.parents if folder in above.parents)
        and p.name != TABLE  # of an earlier run, where --out lies inside the folder
        and not any(part.startswith(".") for part in p.relative_to(folder).parts)
    )
    out = []
    for p in files:
        name = p.relative_to(folder)
        sensor, date = _named(name.stem)
        if len(name.parts) > 1:
            sensor = "/".join(name.parts[:-1])
        out.append(Entry(name.as_posix(), str(p), sensor, date, _pairs(options)))
    return out


def _named(stem):
    """Sensor and date that a file's name tells."""
    match = _DATE.search(stem)
    if not match:
        return stem, ""
    sensor = (stem[: match.start()] + stem[match.end() :]).strip("_-. T")
    return sensor or stem, "-".join(match.groups())


def _of_table(path, options):
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
            known = list(rows[0]) if rows else []
    except (UnicodeDecodeError, csv.Error):
        raise InputError(
            f"{path} is no table of records: give a folder of them, or a .csv with one record a "
            "line (file, sensor, date); `imu-lib characterise` takes a single record."
        ) from None
    if "file" not in known:
        raise InputError(
            f"{path} has no column `file`; a manifest names one record a line: file, sensor, date."
        )
    unknown = [k for k in known if k not in ("file", "sensor", "date", *OPTIONS)]
    if unknown:
        raise InputError(
            f"{path} has the column `{unknown[0]}`; known are file, sensor, date, "
            f"{', '.join(OPTIONS)}."
        )
    out, seen = [], {}
    for line, row in enumerate(rows, start=2):
        name = (row["file"] or "").strip()
        if not name:
            raise InputError(f"{path}, line {line}: names no file; remove the line.")
        if name in seen:
            raise InputError(f"{path}, line {line}: {name} stands on line {seen[name]} already.")
        seen[name] = line
        own = {}
        for key, kind in OPTIONS.items():
            text = (row.get(key) or "").strip()
            if text:
                try:
                    own[key] = kind(text)
                except ValueError:
                    raise InputError(
                        f"{path}, line {line}: `{key}` is {text!r}, not a number."
                    ) from None
        sensor, date = _named(Path(name).stem)
        sensor = (row.get("sensor") or "").strip() or sensor
        date = (row.get("date") or "").strip() or date
        if date and not re.fullmatch(r"\d{4}-\d\d-\d\d", date):
            raise InputError(
                f"{path}, line {line}: the date {date!r} is not of the form 2024-05-01."
            )
        place = Path(name) if Path(name).is_absolute() else path.parent / name
        where = f"{path}, line {line}"
        out.append(Entry(name, str(place), sensor, date, _pairs({**options, **own}), where))
    return out


def _pairs(options):
    return tuple(sorted((k, v) for k, v in options.items() if v is not None))
