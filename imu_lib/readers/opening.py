"""A file, folder or archive into raw columns: the format is told by the content first, then by the
name.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.readers import (
    arrays,
    arrow_tables,
    bags,
    binary,
    instances,
    json_tables,
    oxts,
    packed,
    rdata,
    streams,
    ulog,
    zarr_store,
)
from imu_lib.readers.raw import Raw
from imu_lib.readers.text import read_text

#: How binary formats begin that are read from a file.
BINARY = (
    *(b"\x93NUMPY", b"PK", b"PAR1", b"MATLAB", b"\x89HDF", b"#ROSBAG ", b"SQLite", b"\x89MCAP"),
    *(b"ULog", b"ARROW1", b"FEA1"),
)
KNOWN = (
    ".npz, .npy, .csv, .txt, .tsv, .parquet, .feather, .mat, .h5, .zarr, .ulg, .rda or a ROS bag"
)


def read_raw(path, *, columns=None, signal=None, topic=None) -> Raw:
    """The columns of a file in its own units, of one sensor where rows of several stand in it.
    InputError or OSError where it cannot be read, or the call does not say which sensor.
    """
    raw = _read(path, columns, signal, topic)
    if topic and raw.instances is None and not raw.has_topics:
        raise InputError(
            f"{raw.source} has no topics and no column that tells several sensors apart; leave "
            f"--topic {topic} out."
        )
    try:
        keep = instances.rows(raw.instances, topic, raw.source)
    except instances.Several as error:
        error.raw = raw
        raise
    if keep is not None:
        fewer = raw.rows() - len(keep)
        raw.notes += (f"{fewer:,} rows of other sensors were left out (--topic {topic}).",)
        streams.without(raw, keep)
    return raw


def _read(path, columns, signal, topic) -> Raw:
    path = Path(path)
    options = {"columns": columns, "signal": signal, "topic": topic}
    if bags.is_bag(path):
        return bags.read_bag(path, topic=topic)
    if zarr_store.is_store(path):
        return zarr_store.read_zarr(path, columns=columns, signal=signal)
    if path.is_dir():
        if oxts.folder(path) is not None:
            return oxts.read_oxts(oxts.folder(path))
        raise InputError(f"{path} is a directory; name the file in it ({KNOWN}).")
    archive = None if path.exists() else packed.inside(path)
    if archive:
        return _of_bytes(packed.member(*archive), path, options)
    with open(path, "rb") as file:
        magic = file.read(16)
        begin = magic + file.read(64)
    if not magic:
        raise InputError(f"{path} is empty; {KNOWN} is expected.")
    packed.refuse_pointer(begin, path)
    if path.suffix.lower() in (".xlsx", ".xls", ".ods"):
        raise InputError(f"{path} is a spreadsheet; save its sheet as .csv.")
    how = packed.how(magic, path)
    if how:
        return _of_bytes(packed.unpacked(path, how), path, options, path.with_suffix("").name)
    if magic[:2] == b"PK":
        names = packed.members(path)
        if names is not None:
            return _of_zip(path, names, options)
    return _of_file(path, magic, options)


def _of_file(path: Path, magic: bytes, options) -> Raw:
    """A file that is not packed, by its content and then by its name."""
    topic = options["topic"]
    table = {"columns": options["columns"], "signal": options["signal"]}
    suffix = path.suffix.lower()
    if magic[:6] == b"\x93NUMPY" or magic[:2] == b"PK" or suffix in (".npz", ".npy"):
        return binary.read_numpy(path, **table)
    if magic[:4] == b"PAR1" or suffix in (".parquet", ".pq"):
        return arrow_tables.read_parquet(path, **table)
    if magic.startswith((b"ARROW1", b"FEA1")):
        return arrow_tables.read_feather(path, **table)
    if magic[:1] == b"\x80" and magic[1:2] in b"\x02\x03\x04\x05" or suffix in (".pkl", ".pickle"):
        raise InputError(
            f"{path} is a Python pickle, which runs code when it is opened; write what it holds "
            "as .npz, .csv or .parquet."
        )
    if magic[:3] == b"\xa3\x95\x80":
        raise InputError(
            f"{path} is a binary log of ArduPilot; write it as text first (`mavlogdump.py --format "
            "csv --types IMU`, or Mission Planner's conversion)."
        )
    if magic[:6] == b"MATLAB" or magic[:8] == b"\x89HDF\r\n\x1a\n" or suffix == ".mat":
        return binary.read_mat(path, **table)
    if magic[:15] == b"SQLite format 3" and (tables := packed.tables(path)) is not None:
        raise InputError(
            f"{path} is a database of SQLite and no ROS bag (it holds {', '.join(tables[:6])}); "
            "export the table of the readings as .csv."
        )
    if magic[:8] == b"#ROSBAG " or magic[:15] == b"SQLite format 3" or magic[:5] == b"\x89MCAP":
        return bags.read_bag(path, topic=topic)
    if magic.startswith(ulog.MAGIC):
        return ulog.read_ulog(path, topic=topic)
    return _of_text(path.read_bytes(), path, table)


def _of_text(data: bytes, path: Path, table) -> Raw:
    """R data, a document of JSON or a text table, from memory."""
    if rdata.is_rdata(data):
        return arrays.from_arrays(
            str(path), rdata.arrays(data, str(path)), *table.values(), contract=False
        )
    if data[:16].lstrip(b"\xef\xbb\xbf \t\r\n")[:1] in (b"[", b"{"):
        found = json_tables.read_json(data, str(path), *table.values())
        if found is not None:
            return found
    if re.match(rb"[^\s{\[,;]{1,80}\s+\{.*\}\s*\n[^\s{\[,;]{1,80}\s+\{", data[:4000]):
        # a broker's client prints the topic before each message
        messages = re.sub(rb"(?m)^[^\s{\[,;]{1,80}\s+(?=\{)", b"", data)
        if (found := json_tables.read_json(messages, str(path), *table.values())) is not None:
            return found
    if data[257:262] == b"ustar":
        raise InputError(f"{path} holds a tar archive; unpack it and give the file in it.")
    if re.match(rb"\s*<(?:!doctype html|html)", data[:200], re.IGNORECASE):
        raise InputError(
            f"{path} is a web page, no table: the address gave a page in the place of the file; "
            "fetch the file itself."
        )
    if re.match(rb"\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}##?[0-9A-Fa-fR]*\s*\n", data[:200]):
        raise InputError(
            f"{path} holds raw frames of a CAN bus (candump), no values of signals; decode them "
            "by the sensor's .dbc file into a table with a row a sample."
        )
    return read_text(path, data=data, **table)


def _of_bytes(data: bytes, path: Path, options, name: str | None = None) -> Raw:
    """A file that was unpacked: text and R data from memory, binary formats from a file beside."""
    name = name or path.name
    if not data:
        raise InputError(f"{path} is empty inside; {KNOWN} is expected.")
    packed.refuse_pointer(data, path)
    binary_ = Path(name).suffix.lower() in (".npz", ".npy", ".mat", ".parquet")
    if not binary_ and not data.startswith(BINARY):
        return _of_text(data, path, {k: options[k] for k in ("columns", "signal")})
    with tempfile.TemporaryDirectory() as folder:
        inner = Path(folder) / Path(name).name
        inner.write_bytes(data)
        try:
            raw = _read(inner, **options)
        except InputError as error:
            raise InputError(str(error).replace(str(inner), str(path))) from None
    raw.source = str(path)
    raw.notes = tuple(n.replace(str(inner), str(path)) for n in raw.notes)
    return raw


def _of_zip(path: Path, names: list[str], options) -> Raw:
    if len(names) == 1:
        return _of_bytes(packed.member(path, names[0]), path, options, Path(names[0]).name)
    if options["signal"] in ("gyro", "accel") and (two := packed.two(names)):
        name = two[options["signal"] == "accel"]
        return _of_bytes(packed.member(path, name), path, options, Path(name).name)
    raise InputError(
        f"{path} holds several files ({', '.join(names[:6])}); name the one that is meant, as in "
        f"'{path}/{names[0]}'."
        if names
        else f"{path} is an archive without a data file in it; {KNOWN} is expected."
    )


def pair(path) -> tuple[Path, Path] | None:
    """Gyro and accelerometer of a folder or a zip that holds a file for each."""
    path = Path(path)
    if path.is_dir() and not bags.is_bag(path) and not zarr_store.is_store(path):
        two = packed.two([p.name for p in sorted(path.iterdir()) if p.is_file()])
    elif path.is_file() and (names := packed.members(path)):
        two = packed.two(names) if len(names) > 1 else None
    else:
        return None
    return (path / two[0], path / two[1]) if two else None
