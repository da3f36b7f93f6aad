"""One door for static records: the format is told by the content first, then by the name."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import arrays, bags, binary, instances, packed, rdata, streams, ulog
from imu_lib.readers.assemble import assemble, check_units
from imu_lib.readers.raw import Column, Raw
from imu_lib.readers.text import read_text
from imu_lib.record import Record

KNOWN = ".npz, .npy, .csv, .txt, .tsv, .parquet, .mat, .ulg, .rda or a ROS bag"


def read_raw(path, *, columns=None, signal=None, topic=None) -> Raw:
    """The columns of a file in its own units, of one sensor where rows of several stand in it.
    InputError or OSError where it cannot be read, or the call does not say which sensor.
    """
    raw = _read(path, columns, signal, topic)
    keep = instances.rows(raw.instances, topic, raw.source)
    if keep is not None:
        fewer = raw.rows() - len(keep)
        raw.notes += (f"{fewer:,} rows of other sensors were left out (--topic {topic}).",)
        streams.without(raw, keep)
        if raw.subseconds is not None:
            raw.subseconds = raw.subseconds[keep]
    return raw


def _read(path, columns, signal, topic) -> Raw:
    path = Path(path)
    options = {"columns": columns, "signal": signal, "topic": topic}
    if bags.is_bag(path):
        return bags.read_bag(path, topic=topic)
    if path.is_dir():
        raise InputError(f"{path} is a directory; name the file in it ({KNOWN}).")
    archive = None if path.exists() else packed.inside(path)
    if archive:
        return _of_bytes(packed.member(*archive), path, options)
    with open(path, "rb") as file:
        magic = file.read(16)
    if not magic:
        raise InputError(f"{path} is empty; {KNOWN} is expected.")
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
        return binary.read_parquet(path, **table)
    if magic[:6] == b"MATLAB" or magic[:8] == b"\x89HDF\r\n\x1a\n" or suffix == ".mat":
        return binary.read_mat(path, **table)
    if magic[:8] == b"#ROSBAG " or magic[:15] == b"SQLite format 3" or magic[:5] == b"\x89MCAP":
        return bags.read_bag(path, topic=topic)
    if magic.startswith(ulog.MAGIC):
        return ulog.read_ulog(path, topic=topic)
    if rdata.is_rdata(magic):
        return arrays.from_arrays(
            str(path), rdata.arrays(path.read_bytes(), str(path)), *table.values(), contract=False
        )
    return read_text(path, **table)


def _of_bytes(data: bytes, path: Path, options, name: str | None = None) -> Raw:
    """A file that was unpacked: text and R data from memory, binary formats from a file beside."""
    name = name or path.name
    magic = data[:16]
    if not data:
        raise InputError(f"{path} is empty inside; {KNOWN} is expected.")
    table = {"columns": options["columns"], "signal": options["signal"]}
    if rdata.is_rdata(data):
        return arrays.from_arrays(
            str(path), rdata.arrays(data, str(path)), *table.values(), contract=False
        )
    binary_ = (
        b"\x93NUMPY",
        b"PK",
        b"PAR1",
        b"MATLAB",
        b"\x89HDF",
        b"#ROSBAG ",
        b"SQLite",
        b"\x89MCAP",
        b"ULog",
    )
    suffix = Path(name).suffix.lower()
    if not magic.startswith(binary_) and suffix not in (".npz", ".npy", ".mat", ".parquet"):
        return read_text(path, data=data, **table)
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
        f"{path} holds several files ({', '.join(names[:6])}); name the one that is meant, as in '{path}/{names[0]}'."
        if names
        else f"{path} is an archive without a data file in it; {KNOWN} is expected."
    )


def _pair(path) -> tuple[Path, Path] | None:
    """Gyro and accelerometer of a folder or a zip that holds a file for each."""
    path = Path(path)
    if path.is_dir() and not bags.is_bag(path):
        two = packed.two([p.name for p in sorted(path.iterdir()) if p.is_file()])
    elif path.is_file() and (names := packed.members(path)):
        two = packed.two(names) if len(names) > 1 else None
    else:
        return None
    return (path / two[0], path / two[1]) if two else None


def read_record(path=None, **options) -> Record:
    """A static record from one file, or from a gyro and an accelerometer file; all options as in
    `read`.
    """
    return read(path, **options).record


def read_counted(path=None, **options) -> tuple[Record, int]:
    """A static record and how many of its time stamps repeated the one before; all options as in
    `read`.
    """
    found = read(path, **options)
    return found.record, found.repeats


@dataclass(frozen=True)
class Reading:
    """A record, how many of its time stamps repeated the one before, and what each column of the
    file was read as, or why it was not used.
    """

    record: Record
    repeats: int
    columns: tuple[Column, ...]


def read(
    path=None,
    *,
    gyro=None,
    accel=None,
    rate: float | None = None,
    gyro_unit: str | None = None,
    accel_unit: str | None = None,
    time_unit: str | None = None,
    columns: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    topic: str | None = None,
    only: str | None = None,
    trust_units: bool = False,
    lenient: bool = False,
) -> Reading:
    """A static record and what its columns were read as.

    Parameters
    ----------
    path : path-like, optional
        .npz / .npy, .csv / .txt / .tsv, .parquet, .mat, .ulg, .rda, ROS bag, any of them in gzip or
        zip; or `gyro` and `accel`, a file each.
    rate : float, optional
        Hz, where the file has no time.
    gyro_unit : str, optional
        rad/s, deg/s, deg/h or counts:C (C counts per deg/s).
    accel_unit : str, optional
        m/s^2, g, mg or counts:C (per g); a zero that is not at 0 counts as counts:C:ZERO.
    time_unit : str, optional
        s, ms, us, ns, min or ticks:HZ.
    columns : str, optional
        Names by position, `-` skips.
    start, stop : float, optional
        s from the first sample.
    topic : str, optional
        Of a bag.
    only : {"gyro", "accel"}, optional
        One sensor of the file, at its own rate.
    trust_units : bool
        Do not ask whether the units are possible.
    lenient : bool
        Keep single repeated stamps (for `check`).

    Raises
    ------
    InputError
        With one sentence that says what is missing or wrong.
    OSError
        Where a file cannot be opened.
    """
    options = {
        "rate": rate or None,
        "time_unit": time_unit,
        "trust": trust_units,
        "lenient": lenient,
    }
    if (path is None) == (gyro is None and accel is None):
        raise InputError("Give one file, or --gyro FILE and --accel FILE.")
    told: list[Column] = []
    pair = _pair(path) if path is not None and columns is None else None
    if pair:
        path, gyro, accel = (
            None,
            *(p if only in (None, k) else None for p, k in zip(pair, ("gyro", "accel"))),
        )
    if path is not None:
        raw = read_raw(path, columns=columns, topic=topic)
        units = {"gyro": gyro_unit, "accel": accel_unit}
        if only:
            raw = _only(raw, only)
            units = {k: u if k == only else None for k, u in units.items()}
        record, repeats = of_one(raw, units, options)
        told = raw.described
    else:
        parts, repeats = {}, 0
        for kind, file, unit in (("gyro", gyro, gyro_unit), ("accel", accel, accel_unit)):
            if file is not None:
                raw = _only(read_raw(file, columns=columns, signal=kind, topic=topic), kind)
                one, more = of_one(raw, {kind: unit}, options)
                parts[kind] = (one, raw)
                repeats += more
                told += raw.described
        if len(parts) == 1:
            record = next(iter(parts.values()))[0]
        else:
            starts = _starts(
                parts["gyro"][1], parts["accel"][1], *(p[0].duration for p in parts.values())
            )
            record = streams.merge(parts["gyro"][0], starts[0], parts["accel"][0], starts[1])
        if not trust_units and len(parts) == 2:
            record = check_units(record, {"gyro": gyro_unit or "rad/s"}, {"gyro": 1.0})
    if start is not None or stop is not None:
        try:
            record = record.slice(start, stop)
        except ValueError:
            raise InputError(
                f"{record.source}: --start {0 if start is None else start:g} and --stop "
                f"{record.duration if stop is None else stop:g} leave fewer "
                f"than two samples of a record of {record.duration:.6g} s."
            ) from None
    return Reading(record, repeats, tuple(told))


def of_one(raw: Raw, units: dict[str, str | None], options) -> tuple[Record, int]:
    """The record of one file, its streams laid side by side where they are two."""
    flags = {f"{k}_unit": u for k, u in units.items()}
    if not raw.simulated:
        streams.drop_copies(raw)
    parts = streams.separate(raw)
    if parts is None:
        held = getattr(raw, "held_rows", 1.0)
        if held > 1.0 and options["rate"]:
            options = options | {"rate": options["rate"] / held}
        return assemble(raw, **flags, **options), raw.repeats
    made = {}
    for kind, one in parts.items():
        more = dict(options)
        if more["rate"]:  # the rows' rate, which is not the stream's
            more["rate"] = (
                more["rate"] / getattr(one, "held_rows", 1.0) if "time" not in one.columns else None
            )
        made[kind] = assemble(one, **{f"{kind}_unit": flags.get(f"{kind}_unit")}, **more)
    raw.start, raw.epoch = parts["gyro"].start, parts["gyro"].epoch
    record = streams.merge(
        made["gyro"], parts["gyro"].start, made["accel"], parts["accel"].start, one_file=True
    )
    return record.with_note(*raw.notes), raw.repeats


def _starts(gyro: Raw, accel: Raw, gyro_length: float, accel_length: float):
    """First stamps of two files where they are times of one clock: both absolute, or both of a
    clock that does not begin with the file and overlaps."""
    if gyro.epoch is not None and accel.epoch is not None:
        return gyro.epoch, accel.epoch
    if gyro.start is None or accel.start is None or (gyro.epoch is None) != (accel.epoch is None):
        return None, None
    apart = accel.start - gyro.start
    if apart != 0 and -0.5 * accel_length < apart < 0.5 * gyro_length:
        return gyro.start, accel.start
    return None, None


def _only(raw: Raw, kind: str) -> Raw:
    """The columns of one kind: the file was given as --gyro or --accel."""
    for other in [c for c in raw.columns if streams.kind_of(c) not in (None, kind)]:
        raw.drop(other, f"not of the {kind}")
        raw.columns.pop(other, None)
    if kind == "accel" and "time_accel" in raw.columns:
        raw.columns["time"] = raw.columns.pop("time_accel")
        raw.units["time"], raw.headings["time"] = (
            raw.units["time_accel"],
            raw.headings["time_accel"],
        )
    raw.columns.pop("time_accel", None)
    if not raw.kinds():
        raise InputError(f"{raw.source} holds no {kind} columns; it was given as --{kind}.")
    # rows in which this sensor has nothing are rows of the other one
    empty = np.ones(raw.rows(), dtype=bool)
    for c in raw.columns:
        if streams.kind_of(c) == kind:
            empty &= np.isnan(raw.columns[c]) if raw.columns[c].dtype.kind == "f" else False
    if 0.3 < empty.mean() < 1.0:
        streams.without(raw, np.flatnonzero(~empty))
    return raw
