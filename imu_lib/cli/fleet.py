"""`imu-lib fleet FOLDER|MANIFEST --out DIR`: every record of a fleet characterised, one table."""

from __future__ import annotations

import sys
from pathlib import Path

from imu_lib.cli import common, named
from imu_lib.errors import InputError
from imu_lib.fleet.folders import TABLE

NAME = "fleet"
#: Names of the files in --out DIR.
WRITES = ("fleet.parquet", "fleet.json", "model.json")
HELP = (
    "Characterise every record of a folder or of a manifest (.csv with the columns file, sensor, "
    "date) into one Parquet table; started again, it goes on where it was. Prints the spread of "
    "each coefficient over the sensors, outliers and drift, and writes a fleet model with typical "
    "values and the worst of 95 %."
)


def add_arguments(parser):
    parser.add_argument(
        "records", metavar="FOLDER|MANIFEST", help="a folder of records, or a table of them (.csv)"
    )
    parser.add_argument(
        "--out",
        required=True,
        metavar="DIR",
        help="fleet.parquet, fleet.json and model.json go there",
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes at a time; default one per core"
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="a Dask scheduler that is there (tcp://host:8786) instead of processes here",
    )
    parser.add_argument(
        "--gap", action="store_true", help="also look for what each record's model misses"
    )
    parser.add_argument(
        "--sensor",
        choices=("folder", "file"),
        help="what names a sensor in subfolders; default what the names tell, which is said",
    )
    parser.add_argument(
        "--record",
        choices=("folder", "file"),
        help="whether files of a subfolder that differ in numbers alone are the logs of one record "
        "or a record each; default what their time stamps tell",
    )
    common.add_json_argument(parser)
    group = parser.add_argument_group("what is in the files, where they do not say")
    for flag, kind, text in (
        ("--rate", common.positive, "samples per second"),
        ("--time-unit", str, "s, ms, us or ns"),
        ("--gyro-unit", str, "rad/s, deg/s, deg/h, mdps or counts:C"),
        ("--accel-unit", str, "m/s^2, g, mg or counts:C"),
        ("--columns", str, "names by position"),
    ):
        group.add_argument(flag, type=kind, metavar=flag[2:].upper(), help=text)


def run(args):
    from imu_lib import fleet

    if args.workers is not None and args.workers < 1:
        raise InputError("--workers must be at least 1")
    common.check_writable(args.json)
    out = Path(args.out)
    common.check_out(out)
    reading = ("rate", "time_unit", "gyro_unit", "accel_unit", "columns")
    entries = fleet.entries(
        args.records,
        sensor=args.sensor,
        record=args.record,
        **{key: getattr(args, key) for key in reading},
    )
    named.refuse_overwriting(args, [e.path for e in entries])
    _some_there(entries)
    out.mkdir(exist_ok=True)
    left = len(fleet.Ledger(out, entries, gap=args.gap).open())
    done = len(entries) - left
    print(
        understood(entries) + (f"; {done} of them characterised before" if done else ""),
        file=sys.stderr,
    )
    notes = tuple(dict.fromkeys(e.note for e in entries if e.note))
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    _characterised(args, fleet, entries, out, left)
    _told(args, fleet, out, entries, notes)
    return 0


def understood(entries) -> str:
    """How many records of which sensors and dates, and the first as an example."""
    dates, first = sorted({e.date for e in entries if e.date}), entries[0]
    days = f"{len(dates)}" + (f" ({dates[0]} to {dates[-1]})" if len(dates) > 1 else "")
    return (
        f"records: {len(entries)}, sensors: {len({e.sensor for e in entries})}, dates: {days}; "
        f"{first.file} is of {first.sensor}, {first.date or 'no date'}"
    )


def _some_there(entries):
    """InputError, before anything is written, where no file of the fleet exists."""
    if not any(Path(e.path).exists() for e in entries):
        first = entries[0]
        raise InputError(
            f"{first.where + ': ' if first.where else ''}{first.path} does not "
            f"exist{_nor(entries)}; correct the path (it counts from the manifest's folder)."
        )


def _some_read(entries, table):
    """InputError where no record of the fleet could be read: a table of nothing is no result."""
    wrong = dict(zip(table["file"], table["error"]))
    if not all(isinstance(wrong.get(e.file), str) for e in entries):
        return
    first = entries[0]
    raise InputError(
        "No record of the fleet could be used; "
        f"{first.where + ': ' if first.where else ''}{wrong[first.file]}"
    )


def _nor(entries) -> str:
    others = len(entries) - 1
    return f", nor does any of the other {others:,}" if others else ""


def _characterised(args, fleet, entries, out, left):
    bar = common.progress(about="records", total=left)

    def ended(entry, rows):
        bar.update(1)
        wrong = next((row["error"] for row in rows if row["error"]), None)
        if wrong:
            print(f"left out: {entry.where + ': ' if entry.where else ''}{wrong}", file=sys.stderr)

    try:
        fleet.characterise(
            entries,
            out,
            workers=args.workers,
            address=args.scheduler,
            gap=args.gap,
            progress=ended,
        )
    finally:
        bar.close()


def _told(args, fleet, out, entries, notes):
    table = fleet.load(out)
    try:
        _some_read(entries, table)
    except InputError:
        (out / TABLE).unlink(missing_ok=True)
        raise
    summary = fleet.summary(table, notes)
    common.write_json(summary, out / "fleet.json")
    if summary.model is not None:
        summary.model.save(out / "model.json")
    common.write_json(summary, args.json)
    if args.json == "-":
        return
    print(summary.text())
    written = ["fleet.parquet", "fleet.json"] + ["model.json"] * (summary.model is not None)
    print(f"written to {out}: {', '.join(written)}")
