"""What a fleet has found so far, on disk: nothing lost, nothing twice, whenever it is ended.

Each record that ends is one file of its rows, which appears whole or not at all; the table is made
of these, in the order of the manifest, and replaced as a whole. So the table is the same bytes
however many workers there were and however often they were stopped.
"""

from __future__ import annotations

import hashlib
import json
import time
from pathlib import Path

from imu_lib import beside
from imu_lib.errors import InputError
from imu_lib.fleet.folders import TABLE
from imu_lib.fleet.manifest import Entry
from imu_lib.fleet.rows import COLUMNS
from imu_lib.readers import zarr_store

#: The table is written anew when this many times the last writing's own time has passed.
SPARE = 20.0
#: Changes when rows of earlier versions no longer serve.
VERSION = 1


class Ledger:
    """The records that have ended, in the folder `out`.

    Parameters
    ----------
    out : path
        Made if needed.
    entries : list of Entry
        In the order of the table.
    gap : bool
        Whether effects are asked for.
    """

    def __init__(self, out, entries: list[Entry], *, gap=False):
        self.out, self.entries = Path(out), entries
        self.parts = self.out / "records"
        self.parts.mkdir(parents=True, exist_ok=True)
        self.keys = [_key(entry, gap) for entry in entries]
        self._written, self._spent = 0.0, 0.0
        for stray in (*self.parts.glob(".*.part"), *self.out.glob(".*.part")):
            if time.time() - stray.stat().st_mtime > 60:  # of a process that was ended
                stray.unlink(missing_ok=True)

    def open(self) -> list[int]:
        """Places of the records that have not ended yet."""
        return [i for i, key in enumerate(self.keys) if not self._part(key).exists()]

    def put(self, place, rows: list[dict]) -> None:
        """A record has ended: its rows, and the table with them as soon as there is time."""
        _replace(self._part(self.keys[place]), (json.dumps(rows) + "\n").encode())
        if time.monotonic() - self._written > SPARE * self._spent:
            self.write()

    def rows(self):
        """All rows so far, in the order of the manifest."""
        for key in self.keys:
            part = self._part(key)
            if part.exists():
                yield from json.loads(part.read_text(encoding="utf-8"))

    def write(self) -> Path:
        """The table, whole or not at all."""
        import pyarrow as pa
        from pyarrow import parquet

        start = time.monotonic()
        rows = list(self.rows())
        kinds = {"string": pa.string(), "double": pa.float64()}
        schema = pa.schema([(name, kinds[kind]) for name, kind in COLUMNS.items()])
        columns = [
            pa.array([row.get(name) for row in rows], type=kinds[kind])
            for name, kind in COLUMNS.items()
        ]
        sink = pa.BufferOutputStream()
        parquet.write_table(pa.Table.from_arrays(columns, schema=schema), sink)
        _replace(self.out / TABLE, sink.getvalue())
        self._written = time.monotonic()
        self._spent = self._written - start
        return self.out / TABLE

    def _part(self, key):
        return self.parts / f"{key}.json"


def _key(entry, gap):
    """Name of a record's part: the same file, read in the same way, with the same question."""
    try:
        state = zarr_store.size_and_time(entry.path)
    except OSError:
        state = None
    said = json.dumps(
        [VERSION, entry.file, entry.sensor, entry.date, entry.options, state, bool(gap)]
    )
    return hashlib.sha256(said.encode()).hexdigest()[:32]


def _replace(path, content):
    try:
        with beside.whole(path, sync=True) as part:
            part.write_bytes(content)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}.") from None


def load(path):
    """The table of a fleet as a DataFrame, from its folder or its file."""
    import pandas as pd

    path = Path(path)
    path = path / TABLE if path.is_dir() else path
    try:
        table = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path} is no table of a fleet ({str(error).splitlines()[0][:80]}); "
            "`imu-lib fleet FOLDER --out DIR` makes one."
        ) from None
    if missing := [name for name in COLUMNS if name not in table]:
        raise InputError(f"{path} has no column `{missing[0]}`: it is no table of a fleet.")
    return table
