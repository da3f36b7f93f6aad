"""Zarr stores (format 2 and 3): a folder that holds arrays in compressed chunks, or one zipped."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.arrays import from_arrays
from imu_lib.readers.hdf5 import MOST_VALUES
from imu_lib.readers.raw import Raw

#: What names a folder a store, in its root: format 3, and format 2's group and array.
MARKS = ("zarr.json", ".zgroup", ".zarray", ".zmetadata")


def is_store(path) -> bool:
    """Whether a path is a Zarr store."""
    path = Path(path)
    if path.is_dir():
        return any((path / mark).is_file() for mark in MARKS)
    if not path.is_file() or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return not {*archive.namelist()}.isdisjoint(MARKS)
    except (OSError, zipfile.BadZipFile):
        return False


def size_and_time(path) -> tuple[int, int]:
    """Bytes of a file, or of all that a store in a folder holds, and when any of it was last
    written, ns since 1970.
    """
    path = Path(path)
    files = [p for p in path.rglob("*") if p.is_file()] if path.is_dir() else [path]
    stats = [file.stat() for file in files]
    return sum(s.st_size for s in stats), max((s.st_mtime_ns for s in stats), default=0)


def arrays_of(path) -> dict:
    """Name -> array of numbers of a store, not yet read. InputError where it is damaged, or Zarr's
    library is not installed.
    """
    try:
        import zarr
    except ImportError:
        raise InputError(
            f"{path} is a Zarr store, whose library is not installed: pip install "
            "'imu_lib[zarr]', or save the record as .parquet."
        ) from None
    try:
        where = zarr.storage.ZipStore(path, mode="r") if Path(path).is_file() else str(path)
        root = zarr.open(where, mode="r")
        if isinstance(root, zarr.Array):
            held = {"data": root}
        else:
            held = {n: x for n, x in root.members(max_depth=None) if isinstance(x, zarr.Array)}
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(_damaged(path, error)) from None
    return {name: x for name, x in held.items() if x.dtype.kind in "fiu" and x.shape}


def _damaged(path, error):
    words = str(error).splitlines()[0][:90] if str(error) else type(error).__name__
    return f"{path} is not a whole Zarr store ({words}); save it again."


def read_zarr(path, *, columns=None, signal=None) -> Raw:
    """Arrays by their names, as those of an HDF5 file."""
    out = {}
    for name, x in arrays_of(path).items():
        if x.size > MOST_VALUES:
            raise InputError(
                f"{path}, `{name}`: holds {x.size:,} values; cut the record into parts."
            )
        try:
            value = np.asarray(x[...])
        except (OSError, ValueError, RuntimeError) as error:
            raise InputError(_damaged(path, error)) from None
        out[name.replace("/", ".")] = value.T if _rows_last(value.shape) else value
    return from_arrays(str(path), out, columns, signal, contract=False)


def _rows_last(shape):
    return len(shape) == 2 and shape[0] in (1, 3) and shape[1] > 3


def write(path, arrays) -> None:
    """A store of arrays of numbers in a new folder."""
    import zarr

    root = zarr.open_group(str(path), mode="w")
    for name, values in arrays.items():
        root.create_array(name, data=np.ascontiguousarray(values))
