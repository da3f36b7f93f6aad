"""`imu-lib book FILE`: the chapters on static records, executed on the user's own record and built
into a book.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "book"
HELP = "Execute the chapters on static records on your own record and build them into a book (HTML, readable offline)."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    common.add_record_arguments(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="where the book goes, a new or empty folder or an earlier book (default: NAME_book here)",
    )


def run(args: argparse.Namespace) -> int:
    from imu_lib.book import build, rerun

    if not (args.file or args.gyro or args.accel):
        raise InputError("book needs a record: give FILE, or --gyro FILE and --accel FILE.")
    out = Path(
        args.out or f"{rerun.safe_name(args.file or args.gyro or args.accel)}_book"
    ).resolve()
    build.check_target(out)  # before the long work
    record = common.open_record(args)
    try:
        page = rerun.book(record, out)
    except build.BuildError as problem:
        print(f"imu-lib: the pages could not be built:\n{problem}", file=sys.stderr)
        return 1
    print(page)
    return 0
