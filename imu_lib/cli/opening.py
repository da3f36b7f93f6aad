"""From parsed flags to a record: in memory, or on disk where it is long."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from imu_lib.cli.progress import Share
from imu_lib.errors import InputError

READING = ("rate", "time_unit", "gyro_unit", "accel_unit", "columns", "topic", "trust_units")


def reading_options(args: argparse.Namespace) -> dict:
    """The keyword arguments of `read_record` and `read_drive` out of the flags of
    `add_reading_arguments`.
    """
    return {k: getattr(args, k) for k in READING if getattr(args, k, None) not in (None, False)}


def record_options(args: argparse.Namespace) -> dict:
    """The keyword arguments of `read_record` out of parsed flags."""
    keys = ("gyro", "accel", "only", "start", "stop", *READING)
    return {k: getattr(args, k) for k in keys if getattr(args, k, None) not in (None, False)}


def refuse_without_effect(args: argparse.Namespace, keys, why: str) -> None:
    """InputError where a flag of `keys` is given that the call cannot heed; `why` says so of it."""
    given = [k for k in keys if getattr(args, k, None) not in (None, False)]
    if given:
        flags = " and ".join(f"--{k.replace('_', '-')}" for k in given)
        raise InputError(f"{flags}: {why}")


def open_record(args: argparse.Namespace, *, tell: bool = True, one_rate: bool = True, **more):
    """The record of parsed flags; what reading did to it is told on standard error.

    With `one_rate` a record whose gyro and accelerometer come at rates of their own is refused with
    the flag that takes one of them: an estimator needs even samples.
    """
    from imu_lib.readers import read_record
    from imu_lib.readers.streams import slow_kind

    if args.start is not None and args.stop is not None and args.stop <= args.start:
        raise InputError(f"--stop {args.stop:g} is not after --start {args.start:g}.")
    path = getattr(args, "file", None)
    if path and (args.gyro or args.accel):
        raise InputError("Give one FILE, or --gyro FILE and --accel FILE, not both.")
    record = read_record(path, **record_options(args), **more)
    if tell:
        for note in record.notes:
            print(f"note: {note}", file=sys.stderr)
    if one_rate and slow_kind(record):
        raise InputError(
            f"{record.source}: gyro and accelerometer come at rates of their own; take one with "
            "--only gyro or --only accel."
        )
    return record


def open_on_disk(args: argparse.Namespace, *, least: int | None = None):
    """The record of parsed flags where it stays on disk: a long file that is read by pieces, at
    once or after it was converted, or a folder of logs; else None.
    """
    from imu_lib.long_record import on_disk

    bar = Share(f"converting {Path(args.file).name}")
    try:
        return on_disk(args.file, least=least, progress=bar.at, **record_options(args))
    finally:
        bar.close()


def open_either(args: argparse.Namespace, *, one_rate: bool = True, least: int | None = None):
    """As `open_record`; a record that is long and can be read by pieces stays on disk. What is read
    into memory all the same is said. `least` is the number of rows above which a file that need not
    be converted first counts as long, `stream.LONG` where it is None.
    """
    from imu_lib.long_record import worth_it
    from imu_lib.stream import LONG

    if args.file and not (args.gyro or args.accel or getattr(args, "only", None)):
        record = open_on_disk(args, least=least)
        if record is not None:
            for note in record.notes:
                print(f"note: {note}", file=sys.stderr)
            found = worth_it(record, least)
            if found is not record and record.rows - record.begin > (least or LONG):
                _told_whole(args.file, record.rows - record.begin, "its gaps leave no long part")
            return found
    record = open_record(args, one_rate=one_rate)
    if record.n > LONG:
        _told_whole(
            args.file or args.gyro, record.n, "save it as .parquet to have it read by pieces"
        )
    return record


def _told_whole(name, rows, why):
    print(f"note: {name} was read into memory as a whole, {rows:,} rows ({why}).", file=sys.stderr)
