"""Tables of Arrow, as Parquet and Feather keep them, into raw columns."""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.arrays import from_arrays
from imu_lib.readers.hdf5 import MOST_VALUES
from imu_lib.readers.raw import Raw


def read_parquet(path, *, columns=None, signal=None) -> Raw:
    """The columns of a Parquet file. InputError where it is damaged, or its columns are no
    numbers.
    """

    def load():
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            if file.metadata.num_rows * max(1, file.metadata.num_columns) > MOST_VALUES:
                raise InputError(
                    f"{path} announces {file.metadata.num_rows:,} rows; cut the record into parts."
                )
            return file.read()

    return _raw(path, _whole(path, load, "Parquet"), columns, signal)


def read_feather(path, *, columns=None, signal=None) -> Raw:
    """The columns of a Feather (Arrow IPC) file, with the same errors."""

    def load():
        from pyarrow import feather

        return feather.read_table(path, memory_map=False)

    return _raw(path, _whole(path, load, "Feather"), columns, signal)


def _raw(path, table, columns, signal) -> Raw:
    arrays = _arrays(path, table, columns, signal)
    return from_arrays(str(path), arrays, columns, signal, contract=False)


def _whole(path, load, kind: str):
    """What `load` gives. InputError where the file is no whole one of its kind."""
    import pyarrow as pa

    try:
        return load()
    except (pa.ArrowException, OSError, ValueError) as error:
        if isinstance(error, PermissionError | FileNotFoundError | IsADirectoryError):
            raise
        raise InputError(
            f"{path} is not a whole {kind} file ({str(error).splitlines()[0][:90]}); write it "
            "again."
        ) from None


def _arrays(path, table, columns, signal) -> dict[str, np.ndarray]:
    """The columns of a table as arrays: moments as nanoseconds, texts as objects."""
    import pyarrow as pa

    out = {}
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
        elif pa.types.is_list(column.type) or pa.types.is_fixed_size_list(column.type):
            rows = column.to_pylist()
            if len({len(r) for r in rows if r is not None}) != 1 or None in rows:
                raise InputError(
                    f"{path}, column `{name}`: holds lists of different lengths; write a column "
                    "for each axis."
                )
            out[name] = np.array(rows)
            continue
        elif (
            pa.types.is_string(column.type)
            or pa.types.is_large_string(column.type)
            or names.parse(name, signal=signal)[0] is None
            or columns
        ):
            out[name] = np.asarray(column.to_pylist(), dtype=object)
            continue
        else:
            raise InputError(
                f"{path}, column `{name}`: holds {column.type} instead of numbers; write it as "
                "float."
            )
        out[name] = (
            column.to_numpy()
            if not (column.null_count and pa.types.is_integer(column.type))
            else column.cast(pa.float64()).to_numpy()
        )
    return out
