"""`imu-lib book FILE`: pages about the user's own record or drive, executed on it, with a verdict
on page one.
"""

from __future__ import annotations

import argparse
import shlex
import shutil
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from imu_lib.cli import common, named
from imu_lib.cli.opening import READING
from imu_lib.errors import InputError

NAME = "book"
#: Names of the files in --out DIR.
WRITES = ("*",)
HELP = (
    "A book about your own record or drive (HTML, readable offline): page one is a verdict with a "
    "datasheet, what is wrong, what limits the record and files for other programs."
)
#: What the pages are made with, and how each is installed; an extra of the package.
TOOLS = {
    "jupyter_book": "jupyter-book<2",
    "sphinx_exercise": "sphinx-exercise<2",
    "nbclient": "nbclient",
    "nbformat": "nbformat",
    "ipykernel": "ipykernel",
    "plotly": "plotly",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    common.add_record_arguments(parser)
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="where the book goes, a new or empty folder or an earlier book (default: NAME_book "
        "here)",
    )
    parser.add_argument("--title", help="title of the book (default: the file's name)")


def run(args: argparse.Namespace) -> int:
    if not (args.file or args.gyro or args.accel):
        raise InputError("book needs a record: give FILE, or --gyro FILE and --accel FILE.")
    drive = _drive(args)
    record = None if drive else common.open_record(args)
    _check_tools()
    from imu_lib.book import build, own

    given = args.file or args.gyro or args.accel
    args.out = args.out or f"{own.safe_name(given)}_book"
    named.check(args)  # an earlier book is replaced whole, with what lies in it
    out = Path(args.out).resolve()
    build.check_target(out)  # before the long work
    with tempfile.TemporaryDirectory(prefix="imu-lib-book-") as folder:
        subject = _of_drive(args, drive, folder) if drive else _of_record(args, record, folder)
        template = "own_drive" if drive else "own_record"
        try:
            page = own.book(subject, template, out, progress=_say)
        except build.BuildError as problem:
            print(f"imu-lib: the pages could not be built:\n{problem}", file=sys.stderr)
            return 1
    print(page)
    return 0


def _check_tools() -> None:
    lacking = [name for name in TOOLS if find_spec(name) is None]
    if lacking:
        wanted = " ".join(f'"{TOOLS[name]}"' for name in lacking)
        raise InputError(
            f"book needs {', '.join(lacking).replace('_', '-')}, not installed here: "
            f"`pip install {wanted}` adds what lacks."
        )


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _drive(args):
    """The drive that FILE holds, or None where it is a record at rest."""
    from imu_lib.cli.drives import has_fixes

    if not args.file or not has_fixes(args.file):
        return None
    common.refuse_without_effect(
        args,
        ("only", "start", "stop", *READING),
        f"the book takes the drive {args.file} as it stands; leave it out.",
    )
    from imu_lib.readers import read_drive

    return read_drive(args.file)


def _of_record(args, record, folder):
    from imu_lib.book import own
    from imu_lib.gap.fault_masking import LEAST
    from imu_lib.writers import arrays

    path = Path(folder) / f"{own.safe_name(record.name)}.npz"
    np.savez(path, **arrays(record))
    about = own.described(record.n, record.duration)
    temperature = "recorded" if record.temperature is not None else "not recorded"
    gap = ("gap {} --out gap",) if record.n >= LEAST else ()  # a command that is shown works
    return own.Subject(
        title=args.title or record.name or path.stem,
        shown=shlex.quote(args.file or args.gyro or args.accel),
        call=shlex.quote(args.file) if args.file else "",
        path=path,
        about=about,
        facts=(
            ("record", record.source or record.name or "without a name"),
            ("channels", ", ".join(record.channel_names)),
            ("rate", f"{record.rate:.4g} Hz"),
            ("length", about),
            ("temperature", temperature),
        ),
        notes=tuple(record.notes),
        options=_options(args),
        commands=(
            "check {}",
            "characterise {} --out results --export kalibr",
            *gap,
            "book {}",
        ),
    )


def _of_drive(args, drive, folder):
    from imu_lib.book import own

    seconds = float(drive.time[-1] - drive.time[0])
    about = own.described(len(drive.time), seconds)
    fixes, velocity = len(drive.gnss_time), ""
    if drive.gnss_velocity is not None:
        velocity = ", with velocity"
    path = Path(folder) / f"{own.safe_name(args.file)}.npz"
    shutil.copyfile(args.file, path)
    return own.Subject(
        title=args.title or Path(args.file).stem,
        shown=shlex.quote(args.file),
        call=shlex.quote(args.file),
        path=path,
        about=about,
        facts=(
            ("drive", args.file),
            ("IMU", f"{drive.rate:.4g} Hz, {about}"),
            ("fixes", f"{fixes:,}{velocity}"),
            ("reference", "yes" if drive.reference_time is not None else "none"),
        ),
        options=_options(args),
        commands=("check {}", "outages {} --duration 30 --every 30", "gap {}", "book {}"),
    )


#: Flags that say what is in the file.
FLAGS = (
    "gyro",
    "accel",
    "rate",
    "time_unit",
    "gyro_unit",
    "accel_unit",
    "columns",
    "topic",
    "only",
    "start",
    "stop",
)


def _options(args) -> str:
    """The flags that the file was opened with, as they were given."""
    words = []
    for flag in FLAGS:
        value = getattr(args, flag, None)
        if value is not None:
            words += [f"--{flag.replace('_', '-')}", shlex.quote(str(value))]
    return " ".join(words + ["--trust-units"] * bool(getattr(args, "trust_units", False)))
