"""Long files that cannot be read where they lie (text, packed or compressed files, stamps that
jitter): read once, part by part, into a Parquet file in the user's cache, and from there after.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from imu_lib import beside
from imu_lib.errors import InputError
from imu_lib.long_record import parts
from imu_lib.long_record.columns import Parquet
from imu_lib.long_record.log import Log, record_of
from imu_lib.readers import zarr_store
from imu_lib.readers.assemble import assemble
from imu_lib.readers.opening import read_raw
from imu_lib.readers.streams import slow_kind
from imu_lib.stream import LONG

#: Changes when what earlier versions have converted no longer serves.
VERSION = 2
UNITS = {"gyro": "rad/s", "accel": "m/s^2"}


def cache() -> Path:
    """The folder of what was converted; `IMU_LIB_CACHE` names another."""
    import pooch

    own = os.environ.get("IMU_LIB_CACHE")
    return Path(own) if own else Path(pooch.os_cache("imu_lib")) / "converted"


def open_converted(path, *, least=None, rate=None, progress=None, **options):
    """The record of a long file as a LongRecord, converted first where that was not done before;
    None where the file is short, or of no kind that is taken in parts.

    Parameters
    ----------
    path : path
    least : int, optional
        Rows above which a file counts as long.
    progress : callable, optional
        Called with the share that is done.
    rate, options
        As for `read_record`.

    Raises
    ------
    InputError
        As `read_record` raises it, with the line or the row of the file; and where the cache has no
        room.
    """
    path = Path(path)
    known = path.is_file() or zarr_store.is_store(path)
    if not known or options.get("start") is not None or options.get("stop") is not None:
        return None
    if parts.rows_of(path) <= (LONG if least is None else least):
        return None
    reading = {k: options.get(k) for k in ("columns", "topic")}
    units = {k: options.get(k) for k in ("gyro_unit", "accel_unit", "time_unit")}
    units["trust"] = options.get("trust_units", False)
    folder = cache()
    kept = folder / f"{path.stem[:40]}-{_key(path, rate, reading, units)}.parquet"
    fresh = not (kept.exists() and kept.with_suffix(".npz").exists())
    if fresh and not _convert(path, kept, rate, reading, units, progress):
        return None
    state = _state(kept.with_suffix(".npz"))
    source = Parquet(str(kept))
    record = record_of(state, path, lambda name: (source, _column(name)))
    size = kept.stat().st_size / 1e6
    done = f"converted once into {kept} ({size:.0f} MB)" if fresh else f"read from {kept}"
    note = f"The record stays on disk: {done}; delete that file when it is no longer needed."
    return replace(record, notes=(*record.notes, note))


def _key(path, *how):
    state = zarr_store.size_and_time(path)
    said = [VERSION, str(path.resolve()), *state, *map(str, how)]
    return hashlib.sha256(json.dumps(said).encode()).hexdigest()[:16]


def _column(name):
    if name == "temperature":
        return "temperature [degC]"
    return f"{name} [{UNITS[name.partition('_')[0]]}]"


class _Sink:
    """Rows into one Parquet file."""

    def __init__(self, path):
        self.path, self.out = path, None

    def write(self, columns, time):
        import pyarrow as pa
        from pyarrow import parquet

        table = pa.table({"time [s]": time} | {_column(n): x for n, x in columns.items()})
        if self.out is None:
            self.out = parquet.ParquetWriter(self.path, table.schema)
        self.out.write_table(table.select(self.out.schema.names))

    def close(self):
        if self.out is not None:
            self.out.close()


def _convert(path, kept, rate, reading, units, progress) -> bool:
    """Read the file part by part into the cache; False where its parts are no single record."""
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{kept.parent} cannot be made: {error.strerror}.") from None
    need = 2 * zarr_store.size_and_time(path)[0]
    if need > shutil.disk_usage(kept.parent).free:
        raise InputError(
            f"{path} would be converted into {kept.parent}, which has no room for it "
            f"({need / 1e9:.2g} GB); name another folder in IMU_LIB_CACHE."
        )
    part = kept.with_name(f".{kept.name}.{os.getpid()}.part")
    sink = _Sink(part)
    log = Log(path, sink, of_files=False)
    try:
        for number, (small, share, mended) in enumerate(parts.parts(path), start=1):
            try:
                raw = read_raw(small, **reading)
                record = assemble(raw, rate=rate, **units)
            except InputError as error:
                raise InputError(mended(str(error), small)) from None
            if slow_kind(record):
                return False
            log.append(f"part {number} of {path}", record, raw.start, raw.tick)
            if progress is not None:
                progress(share)
        if log.rate is None:
            return False
        state = log.state()
        sink.close()
        _keep(state, kept.with_suffix(".npz"))
        part.replace(kept)
    except OSError as error:
        raise InputError(f"{kept} cannot be written: {error.strerror or error}.") from None
    finally:
        sink.close()
        part.unlink(missing_ok=True)
    return True


def _keep(state, path):
    told = json.dumps({k: v for k, v in state.items() if k not in ("steps", "bad")})
    with beside.whole(path) as part, open(part, "wb") as out:
        np.savez_compressed(out, told=np.array(told), steps=state["steps"], bad=state["bad"])


def _state(path):
    with np.load(path) as held:
        return {**json.loads(str(held["told"])), "steps": held["steps"], "bad": held["bad"]}
