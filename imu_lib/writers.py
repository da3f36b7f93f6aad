"""A record into a file that the readers open again, units stated."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.record import Record

UNIT = {"gyro": "rad/s", "accel": "m/s^2"}


def check_folder(folder) -> None:
    """InputError where files cannot be made in `folder`, or where the folder cannot be made
    itself; before long work.
    """
    folder = Path(folder).resolve()
    there = next(path for path in (folder, *folder.parents) if path.exists())
    effective = {"effective_ids": True} if os.access in os.supports_effective_ids else {}
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK, **effective):
        raise InputError(
            f"{there} may not be written to; choose another place, or change its permissions."
        )


def arrays(record: Record) -> dict[str, np.ndarray]:
    """The contract's keys: time, gyro and accel as (n, 3) where all axes are there, else single
    channels, temperature.
    """
    out = {"time": record.times()}
    for kind in ("gyro", "accel"):
        axes = [f"{kind}_{a}" for a in "xyz" if f"{kind}_{a}" in record]
        if len(axes) == 3:
            out[kind] = record[kind]
        else:
            out |= {c: record[c] for c in axes}
    if record.temperature is not None:
        out["temperature"] = record.temperature
    return out


def write_record(record: Record, path) -> None:
    """Write `.npz` (SI, the contract's keys), or `.csv`, `.tsv`, `.txt`, `.parquet` with the unit
    in each column's name.

    A simulated record says so in its .npz, and its units are then not doubted. InputError for
    another suffix.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        more = {"simulated": np.array(True)} if record.source.startswith("simulated") else {}
        with open(path, "wb") as file:
            np.savez_compressed(file, **arrays(record), **more)
        return
    import pyarrow as pa
    from pyarrow import csv, parquet

    columns = {"time [s]": record.times()} | {
        f"{c} [{UNIT[c.partition('_')[0]]}]": x for c, x in record.channels.items()
    }
    if record.temperature is not None:
        columns["temperature [degC]"] = record.temperature
    table = pa.table(columns)
    if suffix in (".csv", ".tsv", ".txt"):
        delimiter = "," if suffix == ".csv" else "\t"
        with open(path, "wb") as file:  # the shortest digits that give the same number back
            file.write((delimiter.join(columns) + "\n").encode())
            csv.write_csv(table, file, csv.WriteOptions(include_header=False, delimiter=delimiter))
    elif suffix == ".parquet":
        parquet.write_table(table, path)
    else:
        raise InputError(f"{path}: records are written as .npz, .csv, .tsv, .txt or .parquet.")
