"""A drive as the flags of a command tell how to read it."""

from __future__ import annotations

import argparse
import os
import sys
import zipfile

from imu_lib.cli import common

#: Why a flag that takes one sensor is refused.
BOTH = "a drive needs gyro and accelerometer; leave it out."


def has_fixes(path: str | os.PathLike[str] | None) -> bool:
    """Whether a file is an archive with fixes, be it that their positions are missing."""
    if not path or not zipfile.is_zipfile(path):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return bool({"gnss_time.npy", "gnss_position.npy"} & set(archive.namelist()))
    except zipfile.BadZipFile:
        return False


def opened(path: str | os.PathLike[str], args: argparse.Namespace):
    """The `Drive` at `path` by the parsed flags; what reading did to it is told on standard
    error.
    """
    from imu_lib.readers import read_drive

    drive = read_drive(
        path,
        gnss=args.gnss,
        gnss_offset=args.gnss_offset,
        start=args.start,
        stop=args.stop,
        **common.reading_options(args),
    )
    for note in drive.notes:
        print(f"note: {note}", file=sys.stderr)
    return drive
