"""One door for static records: the format is told by the content first, then by the name."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import bags, binary
from imu_lib.readers.assemble import assemble, check_units
from imu_lib.readers.raw import Raw
from imu_lib.readers.text import read_text
from imu_lib.record import Record

KNOWN = ".npz, .npy, .csv, .txt, .tsv, .parquet, .mat or a ROS bag"
PACKED = {
    b"\x1f\x8b": "gzip",
    b"BZh": "bzip2",
    b"\xfd7zXZ": "xz",
    b"7z\xbc\xaf": "7-Zip",
    b"\x28\xb5\x2f\xfd": "Zstandard",
}


def read_raw(path, *, columns=None, signal=None, topic=None) -> Raw:
    """The columns of a file in its own units. InputError or OSError where it cannot be read."""
    path = Path(path)
    if bags.is_bag(path):
        return bags.read_bag(path, topic=topic)
    if path.is_dir():
        raise InputError(f"{path} is a directory; name the file in it ({KNOWN}).")
    with open(path, "rb") as file:
        magic = file.read(16)
    if not magic:
        raise InputError(f"{path} is empty; {KNOWN} is expected.")
    for start, how in PACKED.items():
        if magic.startswith(start):
            raise InputError(
                f"{path} is compressed ({how}); unpack it first, or save it as .npz or .parquet."
            )
    if path.suffix.lower() in (".xlsx", ".xls", ".ods"):
        raise InputError(f"{path} is a spreadsheet; save its sheet as .csv.")
    options = {"columns": columns, "signal": signal}
    if magic[:6] == b"\x93NUMPY" or magic[:2] == b"PK" or path.suffix.lower() in (".npz", ".npy"):
        return binary.read_numpy(path, **options)
    if magic[:4] == b"PAR1" or path.suffix.lower() in (".parquet", ".pq"):
        return binary.read_parquet(path, **options)
    if magic[:6] == b"MATLAB" or magic[:8] == b"\x89HDF\r\n\x1a\n" or path.suffix.lower() == ".mat":
        return binary.read_mat(path, **options)
    if magic[:8] == b"#ROSBAG " or magic[:15] == b"SQLite format 3" or magic[:5] == b"\x89MCAP":
        return bags.read_bag(path, topic=topic)
    return read_text(path, **options)


def read_record(path=None, **options) -> Record:
    """A static record from one file, or from a gyro and an accelerometer file; all options as in
    `read_counted`.
    """
    return read_counted(path, **options)[0]


def read_counted(
    path=None,
    *,
    gyro=None,
    accel=None,
    rate: float | None = None,
    gyro_unit: str | None = None,
    accel_unit: str | None = None,
    columns: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    topic: str | None = None,
    trust_units: bool = False,
    lenient: bool = False,
) -> tuple[Record, int]:
    """A static record and how many of its time stamps repeated the one before.

    path: .npz / .npy, .csv / .txt / .tsv, .parquet, .mat, ROS bag; or `gyro` and `accel`, a file
    each. rate: Hz, where the file
    has no time.
    gyro_unit: rad/s, deg/s, deg/h or counts:C (C counts per deg/s). accel_unit: m/s^2, g, mg or
    counts:C (per g); a zero that is not at 0
    counts as counts:C:ZERO. columns: names by position, `-` skips. start, stop: s from the first
    sample. topic: of a bag.
    trust_units: do not ask whether the units are possible. lenient: keep single repeated stamps
    (for `check`).
    Raises InputError with one sentence, OSError where a file cannot be opened.
    """
    options = {"rate": rate or None, "trust": trust_units, "lenient": lenient}
    if (path is None) == (gyro is None and accel is None):
        raise InputError("Give one file, or --gyro FILE and --accel FILE.")
    if path is not None:
        raw = read_raw(path, columns=columns, topic=topic)
        record, repeats = (
            assemble(raw, gyro_unit=gyro_unit, accel_unit=accel_unit, **options),
            raw.repeats,
        )
    else:
        parts, repeats = {}, 0
        for kind, file, unit in (("gyro", gyro, gyro_unit), ("accel", accel, accel_unit)):
            if file is not None:
                raw = _only(read_raw(file, columns=columns, signal=kind, topic=topic), kind)
                parts[kind] = (assemble(raw, **{f"{kind}_unit": unit}, **options), raw.epoch)
                repeats += raw.repeats
        record = (
            next(iter(parts.values()))[0]
            if len(parts) == 1
            else merge(*parts["gyro"], *parts["accel"])
        )
        if not trust_units and len(parts) == 2:
            check_units(record, {"gyro": gyro_unit or "rad/s"}, {"gyro": 1.0})
    if start is not None or stop is not None:
        try:
            record = record.slice(start, stop)
        except ValueError:
            raise InputError(
                f"{record.source}: --start {0 if start is None else start:g} and --stop "
                f"{record.duration if stop is None else stop:g} leave fewer "
                f"than two samples of a record of {record.duration:.6g} s."
            ) from None
    return record, repeats


def _only(raw: Raw, kind: str) -> Raw:
    """The columns of one kind: the file was given as --gyro or --accel."""
    own = (kind, {"gyro": "dtheta", "accel": "dv"}[kind])
    for other in [
        c
        for c in raw.columns
        if c.startswith(("gyro", "accel", "dtheta", "dv")) and not c.startswith(own)
    ]:
        del raw.columns[other]
    if not raw.kinds():
        raise InputError(f"{raw.source} holds no {kind} columns; it was given as --{kind}.")
    return raw


def merge(
    gyro: Record, gyro_epoch: float | None, accel: Record, accel_epoch: float | None
) -> Record:
    """Two files of one sensor on one time base: overlapped where both tell the absolute time, else
    from their first samples.
    """
    source = f"{gyro.source} and {accel.source}"
    if not 0.98 < gyro.rate / accel.rate < 1.02:
        raise InputError(
            f"{gyro.source} has {gyro.rate:.6g} Hz and {accel.source} {accel.rate:.6g} Hz; read them one at a time, or resample one."
        )
    shift = (
        (accel_epoch - gyro_epoch) if gyro_epoch is not None and accel_epoch is not None else 0.0
    )
    notes = tuple(
        f"{kind}: {n}" for kind, part in (("gyro", gyro), ("accel", accel)) for n in part.notes
    )
    if shift >= gyro.duration or -shift >= accel.duration:
        notes += (
            f"The two files do not overlap in time ({accel.source} begins {shift:.6g} s after {gyro.source}); they are laid "
            f"side by side from their first "
            "samples, so nothing common to gyros and accelerometers can be seen.",
        )
        shift = 0.0
    temperature = gyro.temperature
    if gyro.time is None and accel.time is None and shift == 0.0:
        n = min(gyro.n, accel.n)
        left, right = np.arange(n), np.arange(n)
    else:
        # each gyro sample with the nearest accelerometer sample, where there is one within half a
        # sample: no interpolation, it
        # would smooth the noise
        a, b = gyro.slots(), accel.slots() + int(round(shift * gyro.rate))
        _, left, right = np.intersect1d(a, b, return_indices=True)
    if len(left) < 2:
        raise InputError(f"{source} have no two samples in common; read them one at a time.")
    lost = max(gyro.n, accel.n) - len(left)
    if lost:
        notes += (
            f"{lost:,} samples of the longer file have no partner in the other and were left out.",
        )
    channels = {c: x[left] for c, x in gyro.channels.items()} | {
        c: x[right] for c, x in accel.channels.items()
    }
    time = (
        None
        if gyro.time is None and len(left) == left[-1] - left[0] + 1
        else gyro.times()[left] - gyro.times()[left[0]]
    )
    return Record(
        channels,
        gyro.rate,
        time,
        None if temperature is None else temperature[left],
        gyro.name,
        source,
        notes,
    )
