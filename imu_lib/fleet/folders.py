"""Which records a folder of files holds, and of which sensor and date each is: told by the names of
files and folders, and where these leave it open by the time stamps.

A folder of consecutive logs is one record: its files' names differ in their numbers alone and the
stamps of one go on where those of the one before end. What was taken for what is said.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.fleet import names
from imu_lib.long_record.folder import by_numbers
from imu_lib.readers import zarr_store
from imu_lib.words import listed

#: What a record's file name may end in, and what it may be packed by.
SUFFIXES = (
    *(".npz", ".npy", ".parquet", ".csv", ".txt", ".tsv", ".mat", ".h5", ".hdf5", ".zarr"),
    *(".bag", ".mcap", ".db3"),
)
PACKED = (".gz", ".bz2", ".xz")
#: The table that a fleet makes.
TABLE = "fleet.parquet"
#: A pause between two logs of one record, s, or as a share of the first.
PAUSE, SHARE = 2.0, 0.01


@dataclass(frozen=True)
class Found:
    """A record in a folder: its name there, its path, sensor, date, what is to be said of it."""

    name: str
    path: Path
    sensor: str
    date: str
    note: str = ""


def records(folder: Path, *, sensor=None, record=None, **reading) -> list[Found]:
    """The records of a folder and its subfolders, in order of their names.

    Parameters
    ----------
    folder : path
    sensor : {"folder", "file"}, optional
        What names a sensor where a subfolder holds files of several names; default what the names
        tell.
    record : {"folder", "file"}, optional
        Whether a subfolder's files that differ in numbers alone are one record or one each; default
        what their stamps tell.
    reading
        As for `read_record`.

    Raises
    ------
    InputError
        Where the folder itself is one record of consecutive logs.
    """
    rows: dict[Path, list[Path]] = {}
    for file in _files(folder):
        rows.setdefault(file.parent, []).append(file)
    logs, told = _logs(folder, rows, record, reading)
    out = [_of_logs(folder, place) for place in logs]
    single = [file for place, files in rows.items() if place not in logs for file in files]
    out += _of_files(folder, single, sensor, told)
    return sorted(out, key=lambda found: found.name)


def _files(folder):
    return sorted(
        p
        for p in folder.rglob("*")
        if _stem(p)[1] in SUFFIXES
        and (p.is_file() or zarr_store.is_store(p))
        and not any(zarr_store.is_store(above) for above in p.parents if folder in above.parents)
        and p.name != TABLE  # of an earlier run, where --out lies inside the folder
        and not any(part.startswith(".") for part in p.relative_to(folder).parts)
    )


def _stem(path):
    """(the name without its suffix, the suffix), what it is packed by left out."""
    path = path.with_suffix("") if path.suffix.lower() in PACKED else path
    return path.stem, path.suffix.lower()


def _logs(folder, rows, record, reading):
    """(folders that are one record of consecutive logs, folder -> what could not be told)."""
    logs, told, kinds = set(), {}, {}
    for place, files in rows.items():
        kind = re.sub(r"\d+", "#", str(place.relative_to(folder) / files[0].name.lower()))
        alike = {re.sub(r"\d+", "#", file.name.lower()) for file in files}
        if (
            len(files) < 2
            or len(alike) > 1
            or record == "file"
            or not all(map(Path.is_file, files))
        ):
            continue
        if record is None and kind not in kinds:
            kinds[kind] = _go_on(sorted(files, key=by_numbers), reading)
        if record is None and place == folder and kinds[kind]:
            first, second = (file.name for file in sorted(files, key=by_numbers)[:2])
            raise InputError(
                f"{folder} is one record: the stamps of {second} go on where those of {first} end. "
                f"`imu-lib characterise {folder}` takes it as that; --record file takes each file "
                "as a record of its own."
            )
        if place != folder and (record == "folder" or kinds.get(kind)):
            logs.add(place)
        elif place != folder and kinds.get(kind) is None and not _all_dated(files) and not told:
            told[place] = (
                f"Folders such as {place.relative_to(folder).as_posix()} hold several files whose "
                "stamps begin anew: each file is taken as a record of its own; --record folder "
                "takes the files of a folder as consecutive logs of one."
            )
    return logs, told


def _all_dated(files):
    return all(names.dated(_stem(file)[0])[1] for file in files)


def _go_on(files, reading):
    """Whether the second file's stamps go on where the first one's end; False where there is more
    between them, None where they begin anew or cannot be read.
    """
    try:
        (_, end, length, half), (start, *_) = (_span(file, reading) for file in files[:2])
    except (InputError, OSError, ValueError, TypeError):
        return None  # each file's own sentence comes when it is characterised
    if start < end - half:
        return None
    return start - end <= max(PAUSE, SHARE * length)


def _span(file, reading):
    """(first stamp, end, length, half a sample) of a file, s; TypeError where it has no stamps."""
    from imu_lib.readers.opening import read_raw
    from imu_lib.readers.stamps import settle

    raw = read_raw(file, **{k: reading.get(k) for k in ("columns", "topic")})
    found = settle(raw, reading.get("rate"), time_unit=reading.get("time_unit"), trust=True)
    n = len(found.keep)
    length = (n if found.time is None else found.time[-1] * found.rate + 1) / found.rate
    return raw.start, raw.start + length, length, 0.5 / found.rate


def _of_logs(folder, place):
    """The record of a folder of logs: the sensor is what the folders are called beside the date."""
    inside = place.relative_to(folder)
    told = [names.dated(part) for part in inside.parts]
    days = [when for _, when, _ in told if when]
    called = [" ".join(filter(None, (before, after))) for before, _, after in told]
    called = [part for part in called if part]
    return Found(
        inside.as_posix(), place, "/".join(called) or folder.resolve().name, (days or [""])[-1]
    )


def _of_files(folder, files, sensor, told):
    """The records of single files. In a subfolder a sensor is the folder, a date in its name left
    out; where a subfolder holds files of several names that no other has, each name is a sensor.
    """
    places: dict[str, list] = {}
    for file in files:
        inside = file.relative_to(folder)
        parts = [names.dated(part) for part in inside.parts[:-1]]
        place = "/".join(filter(None, ("_".join(filter(None, (b, a))) for b, _, a in parts)))
        own, day = names.sensor_and_date(_stem(file)[0])
        days = [when for _, when, _ in parts if when]
        places.setdefault(place, []).append((inside, own, day or (days or [""])[-1]))
    seen: dict[str, set] = {}
    for place, entries in places.items():
        for _, own, _ in entries:
            seen.setdefault(own, set()).add(place)
    out, noted = [], set()
    for place, entries in places.items():
        apart, note = _apart(place, entries, seen, sensor)
        note = "" if apart in noted else note  # said of the first such folder
        noted |= {apart} if note else set()
        for inside, own, day in entries:
            name = (f"{place}/{own}" if place and own else own or place) if apart else place
            said = " ".join(filter(None, (told.get((folder / inside).parent), note)))
            out.append(
                Found(inside.as_posix(), folder / inside, name or folder.resolve().name, day, said)
            )
    return out


def _apart(place, entries, seen, sensor):
    """(whether the names of a place's files are sensors, what is to be said of that)."""
    own = sorted({name for _, name, _ in entries if name})
    if not place or sensor == "file":
        return True, ""
    if sensor == "folder" or len(own) < 2:
        return False, ""
    some = f"{listed(own[:3])}{' ...' * (len(own) > 3)}"
    row = len({re.sub(r"\d+", "#", name) for name in own}) == 1
    if row and len(own) > 2 and all(len(seen[name]) == 1 for name in own):
        return True, (
            f"The files of {place} ({some}) are taken as sensors of their own, since no other "
            "folder has files of these names; --sensor folder takes the folder as one sensor."
        )
    return False, (
        f"The files of {place} ({some}) are taken as records of one sensor, {place}; --sensor "
        "file takes their names as sensors."
    )
