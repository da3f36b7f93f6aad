"""`imu-lib gap FILE [--model MODEL]`, FILE a record or a drive: where simulation and measurement disagree, and what is
missing.
"""

from __future__ import annotations

import os
import sys
import time

#: Beyond these shares a channel is left out (missing; stuck at one value; one value scattered all
#: over), and a record is cut to
#: its longest stretch: there is no noise left to compare, or a filled hole would be taken for what
#: the sensor does.
MOST_LOST, LONGEST_STUCK, MOST_ALIKE, LONGEST_HOLES = 0.5, 0.1, 0.95, 0.2

NAME = "gap"
HELP = "Where simulation and measurement disagree, of a record or of a drive, what is missing, and how far the gap shrinks when it is added."


def add_arguments(parser):
    from imu_lib.cli.common import add_json_argument, add_record_arguments

    add_record_arguments(parser)
    parser.add_argument(
        "--gnss", metavar="FILE", help="the GNSS solution of a drive (RTKLIB .pos or NMEA)"
    )
    parser.add_argument(
        "--gnss-offset",
        type=float,
        metavar="S",
        help="the IMU's time of the first fix, where the clocks do not say",
    )
    parser.add_argument(
        "--heading",
        type=float,
        metavar="DEG",
        help="of a drive: the heading at the start as it was given; it is checked",
    )
    parser.add_argument(
        "--model",
        metavar="MODEL",
        help="the model to compare with, a file or preset:NAME; without it one is fitted first",
    )
    parser.add_argument("--out", metavar="DIR", help="write model.json and report.html there")
    parser.add_argument("--seed", type=int, default=0, help="of the simulations (default 0)")
    parser.add_argument(
        "--simulations",
        type=int,
        default=100,
        metavar="K",
        help="size of the ensembles (default 100; 0 leaves the gap index out)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=None,
        metavar="J",
        help="processes (default: 2 where there are two cores)",
    )
    add_json_argument(parser)


def run(args) -> int:
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    from imu_lib.cli import common
    from imu_lib.errors import InputError
    from imu_lib.gap import close
    from imu_lib.model import Model

    common.check_writable(args.json)
    common.check_out(args.out)
    if args.simulations and args.simulations < 20:
        raise InputError(
            f"--simulations {args.simulations} is too few for a scatter; give 20 or more, or 0."
        )
    if args.seed < 0:
        raise InputError(f"--seed {args.seed} must be 0 or above.")
    if args.jobs is not None and args.jobs < 1:
        raise InputError(f"--jobs {args.jobs} is not above 0.")
    model = Model.load(args.model) if args.model else None
    from imu_lib.cli import gap_drive

    if gap_drive.asked(args):
        return gap_drive.run(args, model)
    record = _sound(common.open_record(args), args.file or f"{args.gyro or args.accel}")
    if record.n < 2000:
        raise InputError(
            f"{args.file or args.gyro or args.accel}: {record.n:,} samples are too few; the gap workflow needs 2000 or more."
        )
    if model is not None:
        absent = [c for c in record.channel_names if c not in model]
        if len(absent) == len(record.channel_names):
            raise InputError(
                f"{args.model} has none of the channels of the record ({', '.join(record.channel_names)})."
            )
        if absent:
            print(
                f"note: {args.model} has no {', '.join(absent)}; their base is fitted.",
                file=sys.stderr,
            )
        for name, channel in model.channels.items():
            if (
                any(t.name == "temperature" for t in channel.terms)
                and record.temperature is None
                and name in record
            ):
                raise InputError(
                    f"{args.model} has a temperature term for {name}, but the record has no temperature."
                )
    found = close(
        record,
        model,
        seed=args.seed,
        simulations=args.simulations,
        jobs=args.jobs,
        progress=_progress,
    )
    if args.json:
        common.write_json(found.to_json(), args.json)
    if args.out:
        with common.atomic_folder(args.out) as folder:
            from imu_lib.cli.gap_report import write

            found.model.save(folder / "model.json")
            write(found, folder / "report.html")
    from imu_lib.gap.table import table

    print(table(found))
    return 0


def _sound(record, name):
    """The record without channels that say next to nothing and without long holes; what is left
    out is told on standard error.
    """
    from dataclasses import replace

    import numpy as np

    from imu_lib.errors import InputError

    kept = {}
    for channel, x in record.channels.items():
        lost = np.isnan(x).mean()
        run = np.diff(
            np.flatnonzero(np.concatenate([[True], np.diff(x) != 0, [True]]))
        ).max() / len(x)
        same = (x == np.nanmedian(x)).mean()
        reason = (
            f"is missing in {lost:.0%} of the samples"
            if lost > MOST_LOST
            else "never changes"
            if same == 1
            else f"is stuck at one value for {run:.0%} of the record"
            if run > LONGEST_STUCK
            else f"has one value in {same:.0%} of its samples, which hides its noise"
            if same > MOST_ALIKE
            else None
        )
        if reason:
            print(f"note: {channel} {reason}; it is left out.", file=sys.stderr)
        else:
            kept[channel] = x
    if not kept:
        raise InputError(
            f"{name}: no channel says anything of its noise (stuck, missing or rounded away); check the logger."
        )
    record = replace(record, channels=kept)
    whole = int(record.slots()[-1]) + 1
    lost = 1 - (record.n - record.missing().sum()) / whole
    if lost <= LONGEST_HOLES:
        return record
    part = record.longest_stretch()
    if (
        part.n < 2000 and whole <= 10 * record.n
    ):  # samples lost all over the record: the workflow knows how to miss them
        return record
    print(
        f"note: {lost:.0%} of the samples are missing; the longest stretch without a gap is taken, {part.duration:.4g} s.",
        file=sys.stderr,
    )
    return part


_TOLD = [0.0]  # when the last line of progress was written


def _progress(done, total, text):
    """A bar that a terminal draws over; a line now and then where standard error is a file."""
    if not sys.stderr.isatty():
        from imu_lib.cli import common

        if done == 0 or done >= total or time.monotonic() - _TOLD[0] > common.Lines.EVERY:
            print(f"gap: {done:,} of {total:,}, {text[:70]}", file=sys.stderr, flush=True)
            _TOLD[0] = time.monotonic()
        return
    width = 24
    bar = "#" * int(width * min(done, total) / total)
    print(
        f"\r[{bar:<{width}}] {text[:70]:<70}",
        end="\n" if done >= total else "",
        file=sys.stderr,
        flush=True,
    )
