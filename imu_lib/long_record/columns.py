"""Columns of a file on disk, read by pieces: Parquet, uncompressed `.npz` and `.npy`; those of
HDF5 files and Zarr stores are in `tree`.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from imu_lib.long_record.tree import Hdf5, Zarr
from imu_lib.readers import zarr_store
from imu_lib.stream import CHUNK, bounds


@dataclass(frozen=True)
class Parquet:
    """A Parquet file: one column is decoded at a time, a piece of a row group at a time."""

    path: str

    @property
    def _file(self):
        import pyarrow.parquet as pq

        # read in small steps: no row group is held as a whole
        return pq.ParquetFile(self.path, buffer_size=1 << 20, pre_buffer=False)

    def columns(self):
        """Name -> number of rows, of the columns that hold numbers."""
        import pyarrow as pa

        with self._file as file:
            rows = file.metadata.num_rows
            return {
                field.name: rows
                for field in file.schema_arrow
                if pa.types.is_floating(field.type) or pa.types.is_integer(field.type)
            }

    def pieces(self, name, start, stop):
        """The values start ... stop - 1 of a column, ndarrays of float or int in order."""
        with self._file as file:
            sizes = [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)]
            first = np.concatenate([[0], np.cumsum(sizes)])
            groups = [i for i, n in enumerate(sizes) if first[i] < stop and first[i] + n > start]
            at = int(first[groups[0]]) if groups else 0
            batches = file.iter_batches(CHUNK, row_groups=groups, columns=[name], use_threads=False)
            for batch in batches:
                x = _numbers(batch.column(0))
                low, high = max(start - at, 0), min(stop - at, x.size)
                at += x.size
                if low < high:
                    yield x[low:high]
                if at >= stop:
                    return

    def head(self, rows, path):
        """The first rows as a file of the same kind."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        with self._file as file:
            batch = next(file.iter_batches(rows))
            pq.write_table(pa.Table.from_batches([batch]), path)

    def rows(self, start, stop, path):
        """Some rows as a file of the same kind."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        with self._file as file, pq.ParquetWriter(path, file.schema_arrow) as out:
            sizes = [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)]
            first = np.concatenate([[0], np.cumsum(sizes)])
            groups = [i for i, n in enumerate(sizes) if first[i] < stop and first[i] + n > start]
            at = int(first[groups[0]])
            for batch in file.iter_batches(CHUNK, row_groups=groups, use_threads=False):
                low, high = max(start - at, 0), min(stop - at, batch.num_rows)
                at += batch.num_rows
                if low < high:
                    out.write_table(pa.Table.from_batches([batch.slice(low, high - low)]))
                if at >= stop:
                    return


def _numbers(column):
    """An arrow array of numbers, NaN where a value is null; without `to_numpy`, which loads pandas
    into every process.
    """
    if column.null_count:
        import pyarrow.compute as pc

        column = pc.fill_null(column.cast("double"), float("nan"))
    kind = str(column.type)
    dtype = np.dtype({"double": "f8", "float": "f4", "halffloat": "f2"}.get(kind, kind))
    start = column.offset * dtype.itemsize
    return np.frombuffer(column.buffers()[1], dtype, len(column), start)


@dataclass(frozen=True)
class Numpy:
    """An `.npz` file whose members are not compressed, or an `.npy` file: read where they lie."""

    path: str

    def _members(self):
        """Key -> (offset of the data, shape, dtype)."""
        out = {}
        with open(self.path, "rb") as file:
            if file.read(6) == b"\x93NUMPY":
                file.seek(0)
                out["data"] = _header(file)
                return out
        with zipfile.ZipFile(self.path) as archive, open(self.path, "rb") as file:
            for member in archive.infolist():
                if member.compress_type != zipfile.ZIP_STORED:
                    return {}
                file.seek(member.header_offset + 26)
                name, extra = (int.from_bytes(file.read(2), "little") for _ in range(2))
                file.seek(member.header_offset + 30 + name + extra)
                out[member.filename.removesuffix(".npy")] = _header(file)
        return out

    def columns(self):
        out = {}
        for key, (_, shape, dtype) in self._members().items():
            if dtype.kind not in "fiu" or not shape:
                continue
            if len(shape) == 1:
                out[key] = shape[0]
            elif len(shape) == 2 and shape[1] == 3:
                out |= {f"{key}_{axis}": shape[0] for axis in "xyz"}
        return out

    def pieces(self, name, start, stop):
        members = self._members()
        axis = None
        if name not in members:
            name, axis = name[:-2], "xyz".index(name[-1])
        offset, shape, dtype = members[name]
        width = shape[1] if len(shape) == 2 else 1
        with open(self.path, "rb") as file:
            for low, high in bounds(stop - start):
                file.seek(offset + (start + low) * width * dtype.itemsize)
                x = np.fromfile(file, dtype, (high - low) * width)
                yield x if axis is None else np.ascontiguousarray(x.reshape(-1, width)[:, axis])

    def head(self, rows, path):
        self.rows(0, rows, path)

    def rows(self, start, stop, path):
        arrays = {}
        members = self._members()
        total = max(shape[0] for _, shape, _ in members.values() if shape)
        with open(self.path, "rb") as file:
            for key, (offset, shape, dtype) in members.items():
                whole = not shape or shape[0] != total
                first, count = (
                    (0, shape[0] if shape else 1) if whole else (start, min(stop, total) - start)
                )
                more = int(np.prod(shape[1:])) if shape else 1
                file.seek(offset + first * more * dtype.itemsize)
                x = np.fromfile(file, dtype, count * more)
                arrays[key] = x.reshape((count, *shape[1:]) if shape else ())
        with open(path, "wb") as out:
            if list(arrays) == ["data"]:
                np.save(out, arrays["data"])
            else:
                np.savez(out, **arrays)


def shape_of(file):
    """(shape, dtype) of the `.npy` data that begin here; the file stands behind its head then."""
    read = (
        npy.read_array_header_1_0 if npy.read_magic(file) == (1, 0) else npy.read_array_header_2_0
    )
    shape, fortran, dtype = read(file)
    if fortran and len(shape) > 1 or dtype.hasobject:
        raise ValueError("columns first")
    return shape, dtype


def _header(file):
    shape, dtype = shape_of(file)
    start = file.tell()
    held = file.seek(0, 2) - start
    if held < dtype.itemsize * int(np.prod(shape, dtype=object)):
        raise ValueError("announces more than it holds")
    return start, shape, dtype


def source(path):
    """The columns of a file that can be read by pieces, or None."""
    if zarr_store.is_store(path):
        found = Zarr(str(path))
        return found if found.columns() else None
    with open(path, "rb") as file:
        magic = file.read(8)
    try:
        if magic[:4] == b"PAR1":
            found = Parquet(str(path))
        elif magic[:6] == b"\x93NUMPY" or magic[:2] == b"PK":
            found = Numpy(str(path))
        elif magic == b"\x89HDF\r\n\x1a\n":
            found = Hdf5(str(path))
        else:
            return None
        return found if found.columns() else None
    except (ValueError, OSError, zipfile.BadZipFile):
        return None  # the readers say what is wrong with it


def suffix(path):
    return Path(path).suffix or ".npz"
