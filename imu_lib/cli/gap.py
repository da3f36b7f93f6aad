"""`imu-lib gap FILE [--model MODEL]`, FILE a record or a drive: where simulation and measurement
disagree, and what is missing.
"""

from __future__ import annotations

import os
import sys
import time

NAME = "gap"
#: Names of the files in --out DIR.
WRITES = ("model.json", "report.html")
HELP = (
    "Where simulation and measurement disagree, of a record or of a drive, what is missing, "
    "and how far the gap shrinks when it is added."
)


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
    from imu_lib.cli import common, gap_drive
    from imu_lib.gap import close
    from imu_lib.model import Model

    _refuse_numbers(args)
    model = Model.load(args.model) if args.model else None
    if gap_drive.asked(args):
        return gap_drive.run(args, model)
    common.refuse_without_effect(
        args,
        ("heading", "gnss_offset"),
        f"{args.file or args.gyro or args.accel} is a record without fixes, and this is of a "
        "drive; leave it out, or add the fixes with --gnss FILE.",
    )
    record = common.open_either(args)
    if model is not None:
        _fits(model, record, args.model)
    found = close(
        record,
        model,
        seed=args.seed,
        simulations=args.simulations,
        jobs=args.jobs,
        progress=_progress,
    )
    _write(found, args)
    return 0


def _refuse_numbers(args):
    """Outputs that cannot be written and numbers out of range, before anything is read."""
    from imu_lib.cli import common
    from imu_lib.errors import InputError

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


def _fits(model, record, path):
    """Refuse a model that has nothing to say about this record, and say what it leaves open."""
    from imu_lib.errors import InputError

    absent = [c for c in record.channel_names if c not in model]
    if len(absent) == len(record.channel_names):
        names = ", ".join(record.channel_names)
        raise InputError(f"{path} has none of the channels of the record ({names}).")
    if absent:
        print(f"note: {path} has no {', '.join(absent)}; their base is fitted.", file=sys.stderr)
    for name, channel in model.channels.items():
        follows = any(t.name == "temperature" for t in channel.terms)
        if follows and record.temperature is None and name in record:
            raise InputError(
                f"{path} has a temperature term for {name}, but the record has no temperature: "
                "add a column or array `temperature` (degC) to the record, or take the term out "
                f"of {path}."
            )


def _write(found, args):
    """Notes, JSON, model and page of a result, and its table last."""
    from imu_lib.cli import common
    from imu_lib.gap.table import table

    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    if args.json:
        common.write_json(found.to_json(), args.json)
    if args.out:
        with common.atomic_folder(args.out) as folder:
            from imu_lib.cli.gap_report import write

            found.model.save(folder / "model.json")
            write(found, folder / "report.html")
    print(table(found))


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
