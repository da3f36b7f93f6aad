"""A long file as small files of the same kind, one after the other, each with the file's head."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.long_record import columns
from imu_lib.readers import fields, layout, packed

#: Bytes of a part of a text file; rows of a part of another.
TEXT, ROWS = 1 << 26, 1 << 19
_OPEN = {"gzip": gzip.open, "bzip2": bz2.open, "xz": lzma.open}
TEXTS = (".csv", ".txt", ".tsv", ".log", ".dat", ".asc")


def rows_of(path) -> int:
    """Rows of a file, nearly; 0 where it is of no kind that is taken in parts."""
    path = Path(path)
    if (held := columns.source(path)) is not None:
        return max(held.columns().values())
    if path.is_dir():
        return 0
    with open(path, "rb") as file:
        magic = file.read(16)
    if magic[:2] == b"PK":
        return max((shape[0] for shape, _ in _compressed(path).values() if shape), default=0)
    opener = _opener(path, magic)
    if opener is None:
        return 0
    try:
        with opener() as file:
            head = file.read(fields.HEAD)
    except (OSError, EOFError, zlib.error, lzma.LZMAError):
        return 0  # cut off or damaged: the readers say so
    lines = head.count(b"\n")
    size = Path(path).stat().st_size
    if packed.how(magic, path):  # text of numbers packs to a third or less
        size *= 3
    return int(size * lines / max(len(head), 1)) if lines > 10 else 0


def _opener(path, magic):
    """How the text of a file is opened; None where it holds none."""
    how = packed.how(magic, path)
    name = Path(path).name.lower()
    if how:
        inner = Path(name).suffixes[-2:-1]
        return (lambda: _OPEN[how](path, "rb")) if inner and inner[0] in TEXTS else None
    return (lambda: open(path, "rb")) if Path(name).suffix in TEXTS else None


def parts(path):
    """(small file, share of the long one that is read, function that mends what is said of it), in
    order; each file is gone when the next is asked for.
    """
    path = Path(path)
    magic = b""
    if path.is_file():
        with open(path, "rb") as file:
            magic = file.read(16)
    with tempfile.TemporaryDirectory(prefix="imu-lib-") as folder:
        place = Path(folder)
        if (held := columns.source(path)) is not None:
            yield from _slices(held, path, place)
        elif magic[:2] == b"PK":
            yield from _members(path, place)
        else:
            yield from _lines(path, _opener(path, magic), place)


def _named(path):
    return lambda text, small: text.replace(str(small), str(path))


def _slices(held, path, place):
    total = max(held.columns().values())
    small = place / f"{path.stem}{columns.suffix(path)}"
    for low in range(0, total, ROWS):
        high = min(low + ROWS, total)
        if total - high < ROWS // 8:
            high = total
        held.rows(low, high, small)
        yield small, high / total, _named(path)
        if high == total:
            return


def _compressed(path) -> dict:
    """Key -> (shape, dtype) of the members of an `.npz`."""
    out = {}
    try:
        with zipfile.ZipFile(path) as archive:
            for member in archive.infolist():
                if member.filename.endswith(".npy"):
                    with archive.open(member) as file:
                        shape, dtype = columns.shape_of(file)
                    if int(np.prod(shape, dtype=object)) * dtype.itemsize > member.file_size:
                        return {}  # it announces more than it holds: the readers say so
                    out[member.filename.removesuffix(".npy")] = shape, dtype
    except (ValueError, OSError, zipfile.BadZipFile):
        return {}
    return out


def _members(path, place):
    """The compressed members of an `.npz`, all read side by side."""
    shapes = _compressed(path)
    total = max(shape[0] for shape, _ in shapes.values() if shape)
    small = place / path.name
    with zipfile.ZipFile(path) as archive:
        files = {key: archive.open(f"{key}.npy") for key in shapes}
        for file in files.values():
            columns.shape_of(file)
        whole = {
            k: _taken(files[k], shapes[k], None)
            for k, (s, _) in shapes.items()
            if not s or s[0] != total
        }
        for low in range(0, total, ROWS):
            high = min(low + ROWS, total)
            if total - high < ROWS // 8:
                high = total
            rows = {k: _taken(f, shapes[k], high - low) for k, f in files.items() if k not in whole}
            np.savez(small, **rows, **whole)
            yield small, high / total, _named(path)
            if high == total:
                return


def _taken(file, held, rows):
    shape, dtype = held
    shape = shape if rows is None else (rows, *shape[1:])
    data = file.read(int(np.prod(shape, dtype=object)) * dtype.itemsize)
    return np.frombuffer(data, dtype).reshape(shape)


def _lines(path, opener, place):
    """Parts of a text table, each below the file's own head."""
    name = Path(path).name
    inner = name if Path(name).suffix.lower() in TEXTS else Path(name).stem
    small = place / inner
    size = path.stat().st_size
    try:
        with opener() as file:
            start = file.read(fields.HEAD)
            first = layout.sniff(start, str(path), whole=False).first
            head = b"".join(start.splitlines(keepends=True)[:first])
            rest, before = start[len(head) :], 0
            done = 0
            while True:
                more = file.read(TEXT - len(rest))
                block = rest + more
                if not block.strip():
                    return
                end = len(block) if not more or len(block) < TEXT else block.rfind(b"\n") + 1
                if end == 0:
                    raise InputError(f"{path}: a line of {TEXT:,} bytes is no row of a table.")
                small.write_bytes(head + block[:end])
                rest = block[end:]
                done += end
                yield small, min(done / size, 1.0), _with_lines(path, first, before)
                before += block[:end].count(b"\n")
                if not more and not rest:
                    return
    except (OSError, EOFError, lzma.LZMAError) as error:
        if isinstance(error, PermissionError | FileNotFoundError):
            raise
        raise InputError(
            f"{path} cannot be unpacked to its end ({str(error)[:80]}); compress it again."
        ) from None


def _with_lines(path, first, before):
    """Line numbers of a part as those of the file."""

    def mended(text, small):
        text = text.replace(str(small), str(path))
        return re.sub(
            r"\bline (\d+)",
            lambda m: f"line {int(m[1]) + (before if int(m[1]) > first else 0)}",
            text,
        )

    return mended
