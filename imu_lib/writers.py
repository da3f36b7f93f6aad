"""A record into a file that the readers open again, units stated."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.record import Record
from imu_lib.stream import Scratch, bounds

UNIT = {"gyro": "rad/s", "accel": "m/s^2"}


def check_folder(folder, given=None) -> None:
    """InputError where files cannot be made in `folder`, or where the folder cannot be made
    itself; before long work. The sentence names `given`, the path of the call.
    """
    folder = Path(folder).resolve()
    there = next(path for path in (folder, *folder.parents) if path.exists())
    if not there.is_dir():
        raise InputError(
            f"{folder if given is None else given} cannot be written: {there} is a file, not a "
            "folder; choose another place."
        )
    effective = {"effective_ids": True} if os.access in os.supports_effective_ids else {}
    try:  # permissions do not tell all: file systems refuse as well
        if not os.access(there, os.W_OK | os.X_OK, **effective):
            raise PermissionError
        with tempfile.TemporaryDirectory(dir=there, prefix=".imu-lib-"):
            pass
    except OSError:
        same = given is None or Path(given).resolve() == there
        raise InputError(
            f"{'' if same else f'{given} cannot be made: '}{there} may not be written to; "
            "choose another place, or change its permissions."
        ) from None


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


def write_pieces(path, pieces, n: int, *, simulated: bool = False) -> None:
    """Write a record of `n` samples that comes in pieces, a few megabytes of it in memory.

    The file reads as that of `write_record` does; the arrays of an `.npz` are not compressed, so
    that they can be read by pieces too.

    Parameters
    ----------
    pieces : iterable of dict of str to ndarray (k,)
        `time` (s), channels, `temperature`, in that order.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        _npz_pieces(path, pieces, n, simulated)
        return
    import pyarrow as pa
    from pyarrow import csv, parquet

    if suffix not in (".csv", ".tsv", ".txt", ".parquet"):
        raise InputError(f"{path}: records are written as .npz, .csv, .tsv, .txt or .parquet.")
    with open(path, "wb") as file:
        writer = None
        for piece in pieces:
            table = pa.table({_heading(name): x for name, x in piece.items()})
            if writer is None and suffix == ".parquet":
                writer = parquet.ParquetWriter(file, table.schema, use_dictionary=False)
            elif writer is None:
                delimiter = "," if suffix == ".csv" else "\t"
                file.write((delimiter.join(table.column_names) + "\n").encode())
                options = csv.WriteOptions(include_header=False, delimiter=delimiter)
                writer = csv.CSVWriter(file, table.schema, write_options=options)
            writer.write_table(table)
        writer.close()


def _heading(name: str) -> str:
    """A column's name with its unit."""
    unit = {"time": "s", "temperature": "degC"}.get(name) or UNIT[name.partition("_")[0]]
    return f"{name} [{unit}]"


def _npz_pieces(path, pieces, n, simulated):
    """Arrays into an archive one after the other; they wait in scratch files for their turn."""
    import zipfile

    scratch = {}
    at = 0
    folder = Path(path).resolve().parent
    for piece in pieces:
        groups = _grouped(piece)
        for key, x in groups.items():
            if key not in scratch:
                scratch[key] = (Scratch(n * x.shape[1], folder=folder), x.shape[1])
            scratch[key][0].write(at * x.shape[1], x)
        at += len(next(iter(piece.values())))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for key, (held, width) in scratch.items():
            shape = (n, width) if key in UNIT and width == 3 else (n,)
            with archive.open(f"{key}.npy", "w", force_zip64=True) as member:
                header = {"descr": "<f8", "fortran_order": False, "shape": shape}
                np.lib.format.write_array_header_1_0(member, header)
                for low, high in bounds(held.n):
                    member.write(held.read(low, high).tobytes())
            held.close()
        if simulated:
            with archive.open("simulated.npy", "w") as member:
                np.lib.format.write_array(member, np.array(True))


def _grouped(piece):
    """The contract's keys: three axes as one array (k, 3), all else (k, 1)."""
    out = {}
    for name, x in piece.items():
        kind = name.partition("_")[0]
        axes = [f"{kind}_{a}" for a in "xyz"]
        if name in axes and all(a in piece for a in axes):
            if name == axes[0]:
                out[kind] = np.column_stack([piece[a] for a in axes])
        else:
            out[name] = x[:, None]
    return out
