"""Binary files of arrays: .npz and .npy, .mat (v5 to v7.3), .parquet."""

from __future__ import annotations

import re
import struct
import zlib
from pathlib import Path

import numpy as np

from imu_lib.archive import load_arrays
from imu_lib.errors import InputError
from imu_lib.readers import formats, names
from imu_lib.readers.arrays import from_arrays
from imu_lib.readers.raw import Raw

MOST_VALUES = 2_000_000_000  # 16 GB of float64: no record of an IMU


def read_numpy(path, *, columns=None, signal=None) -> Raw:
    """Arrays under the contract's keys are SI; others by what their names say."""
    return from_arrays(str(path), load_arrays(path), columns, signal, contract=True)


def read_mat(path, *, columns=None, signal=None) -> Raw:
    """Variables (also inside structs) by name, or one matrix whose columns the caller names."""
    with open(path, "rb") as file:
        start = file.read(128)
    if len(start) < 4:
        raise InputError(f"{path} is empty; a MATLAB file is expected.")
    if start[:8] == b"\x89HDF\r\n\x1a\n" or b"MATLAB 7.3" in start[:32]:
        arrays = _hdf5(path)
    else:
        import scipy.io

        try:
            arrays = scipy.io.loadmat(path, squeeze_me=False, struct_as_record=False)
        except (
            ValueError,
            TypeError,
            KeyError,
            IndexError,
            EOFError,
            NotImplementedError,
            struct.error,
            zlib.error,
            OverflowError,
            UnicodeError,
            scipy.io.matlab.MatReadError,
            AttributeError,
            MemoryError,
            OSError,
        ) as error:
            if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
                raise
            raise InputError(
                f"{path} is not a whole MATLAB file ({str(error).splitlines()[0][:90] if str(error) else type(error).__name__}); save it again with save -v7."
            ) from None
        flat: dict[str, np.ndarray] = {}
        texts: dict[str, str] = {}
        for key, value in arrays.items():
            if not key.startswith("__"):
                _flatten(key, value, flat, texts, 0)
        raw = from_arrays(str(path), flat, columns, signal, contract=False)
        formats.beside(raw, texts)
        return raw
    return from_arrays(str(path), arrays, columns, signal, contract=False)


def _flatten(key, value, out, texts, depth):
    """Numbers of structs into `out`, texts that are called units into `texts`."""
    if isinstance(value, np.ndarray) and value.dtype == object and value.size == 1:
        value = value.ravel()[0]
    if hasattr(value, "_fieldnames") and depth < 4:
        for name in value._fieldnames:
            _flatten(f"{key}.{name}", getattr(value, name), out, texts, depth + 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiubc":
        out[key] = value
    elif isinstance(value, np.ndarray) and re.search(r"(^|[._])units?([._]|$)", key, re.IGNORECASE):
        texts[key] = ",".join(str(v) for x in value.ravel() for v in np.ravel(x))


def _hdf5(path) -> dict[str, np.ndarray]:
    import h5py

    out: dict[str, np.ndarray] = {}
    try:
        with h5py.File(path, "r") as file:

            def visit(name, item):
                if (
                    not isinstance(item, h5py.Dataset)
                    or item.dtype.kind not in "fiu"
                    or name.startswith("#refs#")
                ):
                    return
                if (
                    item.size > 1000
                    and item.id.get_storage_size() * 20_000 < item.size * item.dtype.itemsize
                    or item.size > MOST_VALUES
                ):
                    raise InputError(
                        f"{path}, `{name}`: announces {item.size:,} values but stores {item.id.get_storage_size():,} bytes; it is damaged: save it again."
                    )
                value = item[()]
                out[name.replace("/", ".")] = (
                    value.T if value.ndim == 2 else value
                )  # MATLAB stores columns first

            file.visititems(visit)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
            raise
        raise InputError(
            f"{path} is not a whole HDF5 (MATLAB 7.3) file ({str(error).splitlines()[0][:90]}); save it again."
        ) from None
    return out


def read_parquet(path, *, columns=None, signal=None) -> Raw:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            if file.metadata.num_rows * max(1, file.metadata.num_columns) > MOST_VALUES:
                raise InputError(
                    f"{path} announces {file.metadata.num_rows:,} rows; cut the record into parts."
                )
            table = file.read()
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
            raise
        raise InputError(
            f"{path} is not a whole Parquet file ({str(error).splitlines()[0][:90]}); write it again."
        ) from None
    arrays = {}
    for name in table.column_names:
        column = table[name]
        if pa.types.is_timestamp(column.type):
            column = column.cast(pa.timestamp("ns")).cast(pa.int64())
            name = f"{name} [ns]"
        elif pa.types.is_floating(column.type) or pa.types.is_integer(column.type):
            pass
        elif pa.types.is_duration(column.type):
            column = column.cast(pa.duration("ns")).cast(pa.int64())
            name = f"{name} [ns]"
        elif names.parse(name, signal=signal)[0] is None or columns:
            arrays[name] = np.asarray(column.to_pylist(), dtype=object)
            continue
        else:
            raise InputError(
                f"{path}, column `{name}`: holds {column.type} instead of numbers; write it as float."
            )
        arrays[name] = (
            column.to_numpy()
            if not (column.null_count and pa.types.is_integer(column.type))
            else column.cast(pa.float64()).to_numpy()
        )
    return from_arrays(str(path), arrays, columns, signal, contract=False)


def suffix(path) -> str:
    return Path(path).suffix.lower()
