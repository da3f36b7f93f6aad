"""One door for static records: the format is told by the content first, then by the name."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

from imu_lib.errors import InputError
from imu_lib.readers import (
    at_once,
    axis_units,
    increments,
    one_sensor,
    other_rows,
    sentinels,
    streams,
    treated,
    unsigned,
    unused,
)
from imu_lib.readers.assemble import UnitAsked, ask, assemble
from imu_lib.readers.opening import pair, read_raw
from imu_lib.readers.possible import check_units
from imu_lib.readers.raw import Column, Raw
from imu_lib.record import Record


def read_record(path=None, **options) -> Record:
    """A static record from one file, or from a gyro and an accelerometer file; all options as in
    `read`.

    Warns
    -----
    UserWarning
        Where columns of unknown names may be a sensor that the record does not hold.
    """
    found = read(path, **options)
    lost = None if path is None or options.get("only") else unused.lost(found)
    if lost:
        warnings.warn(lost, stacklevel=2)
    return found.record


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
        rad/s, deg/s, deg/h, mdps or counts:C (C counts per deg/s).
    accel_unit : str, optional
        m/s^2, g, mg or counts:C (per g); a zero that is not at 0 counts as counts:C:ZERO.
    time_unit : str, optional
        s, ms, us, ns, min or ticks:HZ; none leaves the time stamps out, for `rate`.
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
    units = {"gyro": gyro_unit, "accel": accel_unit}
    both = pair(path) if path is not None and columns is None else None
    if both:
        path, gyro, accel = (
            None,
            *(p if only in (None, k) else None for p, k in zip(both, ("gyro", "accel"))),
        )
    if path is not None:
        found = _of_one_file(path, columns, topic, only, units, options)
    else:
        found = _of_two_files({"gyro": gyro, "accel": accel}, columns, topic, units, options)
    return replace(found, record=_cut(found.record, start, stop))


def _of_one_file(path, columns, topic, only, units, options) -> Reading:
    """What one file holds, or one sensor of it."""
    raw = one_sensor.read_bare(path, columns, topic, units, options)
    if only:
        raw = one_sensor.only(raw, only)
        units = {k: u if k == only else None for k, u in units.items()}
    record, repeats = of_one(raw, units, options)
    return Reading(record, repeats, tuple(raw.described))


def _of_two_files(files, columns, topic, units, options) -> Reading:
    """What a file of the gyro and one of the accelerometer hold, side by side; one of them may
    be None.
    """
    raws = {
        kind: one_sensor.only(read_raw(file, columns=columns, signal=kind, topic=topic), kind)
        for kind, file in files.items()
        if file is not None
    }
    parts, repeats, asked = {}, 0, []
    for kind, raw in raws.items():
        try:
            parts[kind], more = of_one(raw, {kind: units[kind]}, options)
            repeats += more
        except UnitAsked as error:
            asked.append(str(error).rstrip("."))
    if asked:
        raise UnitAsked("; and ".join(asked) + ".")
    told = tuple(c for raw in raws.values() for c in raw.described)
    if len(parts) == 1:
        return Reading(next(iter(parts.values())), repeats, told)
    starts = _starts(raws["gyro"], raws["accel"], *(r.duration for r in parts.values()))
    record = streams.merge(parts["gyro"], starts[0], parts["accel"], starts[1])
    if not options["trust"]:
        record = check_units(record, {"gyro": units["gyro"] or "rad/s"}, {"gyro": 1.0})
    return Reading(record, repeats, told)


def _cut(record: Record, start, stop) -> Record:
    """The stretch of a record from `start` to `stop` (s, None for its ends)."""
    if start is None and stop is None:
        return record
    try:
        return record.slice(start, stop)
    except ValueError:
        raise InputError(
            f"{record.source}: --start {0 if start is None else start:g} and --stop "
            f"{record.duration if stop is None else stop:g} leave fewer "
            f"than two samples of a record of {record.duration:.6g} s."
        ) from None


def of_one(raw: Raw, units: dict[str, str | None], options) -> tuple[Record, int]:
    """The record of one file, its streams laid side by side where they are two."""
    flags = {f"{k}_unit": u for k, u in units.items()}
    if (options["time_unit"] or "").strip().lower() == "none":
        options = options | {"time_unit": None}
        for c in [c for c in ("time", "date", "clock", "time_accel") if c in raw.columns]:
            raw.drop(c, "left out by --time-unit none")
    if not (raw.simulated or raw.contract):
        sentinels.missing(raw)
        unsigned.signed(raw, units)
    if not raw.simulated:
        other_rows.drop_copies(raw)
    axis_units.one_each(raw, units)
    if not options["trust"]:
        treated.refuse_angles(raw)
        increments.refuse(raw, options["rate"], units)
    try:
        ask(raw, units)
    except UnitAsked as error:
        raise at_once.with_time(error, raw, options) from None
    parts = streams.separate(raw)
    if parts is None:
        held = raw.held_rows
        if held > 1.0 and options["rate"]:
            options = options | {"rate": options["rate"] / held}
        return assemble(raw, **flags, **options), raw.repeats
    made = {}
    for kind, one in parts.items():
        more = dict(options)
        if more["rate"]:  # the rows' rate, which is not the stream's
            more["rate"] = more["rate"] / one.held_rows if "time" not in one.columns else None
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
