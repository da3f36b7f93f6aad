"""Binary files of arrays: .npz and .npy, .mat (v5 to v7.3), .parquet."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

from imu_lib.archive import load_arrays
from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.raw import Raw, by_position
from imu_lib.record import CHANNELS

MOST_VALUES = 2_000_000_000  # 16 GB of float64: no record of an IMU
CONTRACT = {"time", "gyro", "accel", "temperature", *CHANNELS}


def read_numpy(path, *, columns=None, signal=None) -> Raw:
    """Arrays under the contract's keys are SI; others by what their names say."""
    return _from_arrays(str(path), load_arrays(path), columns, signal, contract=True)


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
        for key, value in arrays.items():
            if not key.startswith("__"):
                _flatten(key, value, flat, 0)
        arrays = flat
    return _from_arrays(str(path), arrays, columns, signal, contract=False)


def _flatten(key, value, out, depth):
    if isinstance(value, np.ndarray) and value.dtype == object and value.size == 1:
        value = value.ravel()[0]
    if hasattr(value, "_fieldnames") and depth < 4:
        for name in value._fieldnames:
            _flatten(f"{key}.{name}", getattr(value, name), out, depth + 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "fiu":
        out[key] = value


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
        elif names.parse(name, signal=signal)[0] is None:
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
    return _from_arrays(str(path), arrays, columns, signal, contract=False)


def _from_arrays(source, arrays, columns, signal, *, contract) -> Raw:
    raw = Raw(source)
    if columns:
        matrix = _matrix(source, arrays)
        plan = by_position(columns, matrix.shape[1], source, signal)
        for i, (canonical, unit, heading) in enumerate(plan):
            if canonical:
                raw.add(canonical, matrix[:, i], unit, heading)
        return _checked(raw)
    raw.simulated = contract and "simulated" in arrays
    exact = {k for k in arrays if k in CONTRACT} if contract else set()
    for key, value in arrays.items():
        value = np.asarray(value)
        if key in exact:
            canonical, unit = key, {"g": "rad/s", "a": "m/s^2"}.get(key[0])
        else:
            leaf = key.rpartition(".")[2]
            canonical, unit = names.parse(key, signal=signal)
            if canonical is None:
                canonical, unit = names.parse(leaf, signal=signal)
            kind = canonical.rpartition("_")[0] or canonical if canonical else None
            if (
                exact
                and canonical
                and (
                    canonical in exact
                    or kind in exact
                    or any(k.startswith(kind + "_") for k in exact)
                )
            ):
                continue  # a drive's further arrays do not compete with the contract's own
            if canonical == "time" and raw.columns.get("time") is not None:
                continue
        if canonical in (None, "index", "date", "clock"):
            if leaf_is_rate(key) and value.size == 1 and value.dtype.kind in "fiu":
                raw.rate = float(value.ravel()[0])
            continue
        if value.dtype.kind not in "fiub":
            raise InputError(
                f"{source}, `{key}`: holds {value.dtype} instead of numbers; save it as real numbers."
            )
        if value.size < 2 and canonical not in CONTRACT:
            continue
        raw.add(canonical, value, unit, key)
    raw.contract = bool(exact)
    if not raw.kinds() and not (signal == "temperature" and "temperature" in raw.columns):
        found = ", ".join(f"{k} {np.shape(v)}" for k, v in list(arrays.items())[:8]) or "nothing"
        raise InputError(
            f"{source} has no array called gyro, accel or one of their axes (found: {found}); rename them, or give --columns for the columns of one matrix."
        )
    return _checked(raw)


def leaf_is_rate(key: str) -> bool:
    return key.rpartition(".")[2].lower() in (
        "fs",
        "rate",
        "sample_rate",
        "sampling_rate",
        "samplerate",
    )


def _matrix(source, arrays):
    found = {k: np.asarray(v) for k, v in arrays.items() if np.asarray(v).dtype.kind in "fiub"}
    wide = [
        v if v.shape[0] >= v.shape[1] else v.T
        for v in found.values()
        if v.ndim == 2 and max(v.shape) > 1
    ]
    if len(wide) == 1:
        return wide[0]
    flat = [v.ravel() for v in found.values() if v.size > 1 and max(v.shape) == v.size]
    if flat and len(flat) == len(found) and len({len(v) for v in flat}) == 1:
        return np.column_stack(flat)
    raise InputError(
        f"{source} holds {len(wide)} matrices ({', '.join(list(found)[:8]) or 'no numbers'}); --columns needs one matrix, or columns of one length."
    )


def _checked(raw: Raw) -> Raw:
    lengths = {h: len(raw.columns[c]) for c, h in raw.headings.items() if c in raw.columns}
    if len(set(lengths.values())) > 1:
        raise InputError(
            f"{raw.source}: its arrays differ in length ({', '.join(f'{h} {n:,}' for h, n in list(lengths.items())[:6])}); every one needs a value per sample."
        )
    if next(iter(lengths.values())) < 2:
        raise InputError(
            f"{raw.source} has {'only 1 sample' if 1 in lengths.values() else 'no samples'}; at least two are needed."
        )
    return raw


def suffix(path) -> str:
    return Path(path).suffix.lower()
