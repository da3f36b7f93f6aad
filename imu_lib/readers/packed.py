"""Files in gzip, bzip2, xz or zip: what is in them, and which of several is meant."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from imu_lib.errors import InputError

MOST = 8_000_000_000  # bytes unpacked: no log of an IMU
MAGIC = {b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ": "xz"}
CLOSED = {b"7z\xbc\xaf": "7-Zip", b"\x28\xb5\x2f\xfd": "Zstandard", b"Rar!": "RAR"}
_OPEN = {"gzip": gzip.open, "bzip2": bz2.open, "xz": lzma.open}
_DATA = (
    ".csv",
    ".txt",
    ".tsv",
    ".log",
    ".dat",
    ".mat",
    ".npy",
    ".parquet",
    ".ulg",
    ".bag",
    ".asc",
    ".json",
    ".imu",
    ".rda",
    ".npz",
    ".db3",
    ".mcap",
)


def refuse_pointer(data: bytes, path) -> None:
    """InputError where a file of any suffix is the pointer that Git LFS leaves in its place."""
    if data.startswith(b"version https://git-lfs"):
        raise InputError(
            f"{path} is a pointer of Git LFS, not the file itself; fetch the file with "
            "`git lfs pull`."
        )


def how(magic: bytes, path) -> str | None:
    """By what a file is packed, by its first bytes; None where it is not. InputError where it is
    not unpacked here.
    """
    for start, name in CLOSED.items():
        if magic.startswith(start):
            raise InputError(
                f"{path} is compressed ({name}); unpack it first, or save it as .npz, .zip or .gz."
            )
    return next((name for start, name in MAGIC.items() if magic.startswith(start)), None)


def unpacked(path: Path, name: str) -> bytes:
    """The content of a gzip, bzip2 or xz file. InputError where it is cut off or damaged."""
    try:
        with _OPEN[name](path, "rb") as file:
            data = file.read(MOST + 1)
    except (OSError, EOFError, zlib.error, lzma.LZMAError, ValueError) as error:
        if isinstance(error, PermissionError | FileNotFoundError):
            raise
        raise InputError(
            f"{path} is not a whole {name} file ({str(error)[:80]}); compress it again."
        ) from None
    if len(data) > MOST:
        raise InputError(f"{path} unpacks to more than {MOST:,} bytes; cut the record into parts.")
    return data


def inside(path: Path) -> tuple[Path, str] | None:
    """Archive and member of a path like `log.zip/Gyroscope.csv`; None where it is no such path."""
    for parent in path.parents:
        if parent.is_file():
            return (
                (parent, str(PurePosixPath(path.relative_to(parent))))
                if zipfile.is_zipfile(parent)
                else None
            )
    return None


def members(path: Path) -> list[str] | None:
    """Names of the data files in a zip; None where it is none, is one of NumPy's, or a
    spreadsheet.
    """
    if not zipfile.is_zipfile(path):
        return None
    try:
        with zipfile.ZipFile(path) as archive:
            found = [m.filename for m in archive.infolist() if not m.is_dir()]
    except (zipfile.BadZipFile, OSError):
        return None
    if all(f.endswith(".npy") for f in found) or "[Content_Types].xml" in found:
        return None
    shown = [f for f in found if not re.search(r"(^|/)(__MACOSX|\.|meta)", f)]
    data = [f for f in shown if f.lower().endswith(_DATA)]
    return data or shown


def member(path: Path, name: str) -> bytes:
    """One file of a zip. InputError where it is not there or damaged."""
    try:
        with zipfile.ZipFile(path) as archive:
            if archive.getinfo(name).file_size > MOST:
                raise InputError(
                    f"{path}/{name} unpacks to more than {MOST:,} bytes; cut the record into parts."
                )
            return archive.read(name)
    except KeyError:
        raise InputError(
            f"{path} holds no {name}; it holds {', '.join((members(path) or [])[:8])}."
        ) from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise InputError(
            f"{path}/{name} cannot be unpacked ({str(error)[:80]}); pack it again."
        ) from None


_GYRO = re.compile(r"gyro|angular|drehrate|giroscop|rotation_?rate", re.IGNORECASE)
_ACCEL = re.compile(r"acc(?!uracy)|beschleunig|aceler|acelero", re.IGNORECASE)
_NOT = re.compile(r"linear|uncal|gravity|user|total|orient|without_?g", re.IGNORECASE)


def two(names: list[str]) -> tuple[str, str] | None:
    """The gyro's and the accelerometer's file out of several names, None where they do not stand
    out as one each.
    """
    # Sensor Logger keeps gravity in TotalAcceleration and takes it out of Accelerometer
    whole = [n for n in names if re.search(r"total_?accel", Path(n).stem, re.IGNORECASE)]
    gyro = [n for n in names if _GYRO.search(Path(n).stem) and not _NOT.search(Path(n).stem)]
    accel = [n for n in names if _ACCEL.search(Path(n).stem) and not _NOT.search(Path(n).stem)]
    accel = whole if len(whole) == 1 else accel
    return (gyro[0], accel[0]) if len(gyro) == len(accel) == 1 and gyro != accel else None


def tables(path) -> list[str] | None:
    """Names of the tables of an SQLite database; None where it is that of a ROS bag, or damaged."""
    import sqlite3

    try:
        with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as base:
            found = [
                r[0] for r in base.execute("select name from sqlite_master where type='table'")
            ]
    except sqlite3.Error:
        return None
    return None if "topics" in found or not found else found
