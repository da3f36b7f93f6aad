"""What the commands share: the flags that open a record, results written whole or not at all,
tables, progress.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import sys
from collections.abc import Iterable, Sequence
from contextlib import contextmanager

from imu_lib.cli.opening import (  # noqa: F401 - part of what is shared
    open_either,
    open_on_disk,
    open_record,
    reading_options,
    record_options,
    refuse_without_effect,
)
from imu_lib.cli.outputs import (  # noqa: F401 - part of what is shared
    atomic_folder,
    atomic_path,
    check_out,
    check_writable,
)
from imu_lib.cli.progress import Lines, Share, progress  # noqa: F401 - part of what is shared


def number(text: str) -> float:
    """An argparse type: a finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive(text: str) -> float:
    """An argparse type: a positive number."""
    value = number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def from_zero(text: str) -> float:
    """An argparse type: s from the first sample, which lies at 0."""
    value = number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is below 0, where the first sample lies")
    return value


def add_record_arguments(
    parser: argparse.ArgumentParser, *, positional: str | None = "FILE", required: bool = True
) -> None:
    """The record's file (or two files) and the flags that say what is in it."""
    if positional:
        parser.add_argument(
            "file",
            nargs="?",
            metavar=positional,
            help="the record: .npz .csv .txt .tsv .parquet .mat .ulg .rda or a ROS bag, also in "
            "gzip or zip",
        )
    group = parser.add_argument_group("what is in the file")
    group.add_argument(
        "--gyro", metavar="FILE", help="the gyro's file, where gyro and accelerometer are two files"
    )
    group.add_argument("--accel", metavar="FILE", help="the accelerometer's file")
    add_reading_arguments(group)
    group.add_argument(
        "--only",
        choices=("gyro", "accel"),
        help="one sensor of the file, at its own rate",
    )
    group.add_argument(
        "--start",
        type=from_zero,
        metavar="S",
        help="leave out what comes before, s from the first sample",
    )
    group.add_argument(
        "--stop", type=from_zero, metavar="S", help="leave out what comes from here on, s"
    )


def add_reading_arguments(group) -> None:
    """The flags that say how the columns of a file are to be read, for a parser or a group of one:
    everything that `reading_options` takes.
    """
    group.add_argument(
        "--rate", type=positive, metavar="HZ", help="samples per second, where the file has no time"
    )
    group.add_argument(
        "--time-unit",
        metavar="UNIT",
        help="of the time stamps: s, ms, us, ns, min or ticks:HZ (HZ ticks per second); none "
        "leaves them out, with --rate",
    )
    group.add_argument(
        "--gyro-unit",
        metavar="UNIT",
        help="rad/s, deg/s, deg/h, mdps or counts:C (C counts per deg/s)",
    )
    group.add_argument(
        "--accel-unit", metavar="UNIT", help="m/s^2, g, mg or counts:C (C counts per g)"
    )
    group.add_argument(
        "--columns",
        metavar="NAMES",
        help="names by position, as in time,gyro_x,gyro_y,gyro_z,-,accel_x; - skips",
    )
    group.add_argument(
        "--topic",
        metavar="NAME",
        help="the IMU topic of a ROS bag that has several; COLUMN=VALUE, as in I=0, of a table "
        "with rows of several sensors",
    )
    group.add_argument(
        "--trust-units", action="store_true", help="do not refuse units that look impossible"
    )


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json", metavar="FILE", help="write the whole result as JSON (- for standard output)"
    )


def plain(value):
    """A result as JSON knows it: dataclasses with `to_json`, arrays, NumPy numbers; NaN and
    infinities become null.
    """
    if hasattr(value, "to_json"):
        return plain(value.to_json())
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (str, int, bool)):
        return value
    return str(value)


def write_json(value, path) -> None:
    """The result as JSON to a file, whole or not at all, or to standard output for `-`. Does
    nothing for None.
    """
    if path is None:
        return
    text = json.dumps(plain(value), indent=2, allow_nan=False) + "\n"
    if path == "-":
        (_OUTPUT[-1] if _OUTPUT else sys.stdout).write(text)
        return
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def table(rows: Iterable[Sequence], header: Sequence[str] | None = None) -> str:
    """Rows as aligned text: the first column to the left, the others to the right."""
    body = [[str(c) for c in row] for row in rows]
    lines = ([list(header)] if header else []) + body
    widths = (
        [max(len(line[i]) for line in lines if i < len(line)) for i in range(max(map(len, lines)))]
        if lines
        else []
    )
    out = [
        "  ".join(
            c.ljust(w) if i == 0 else c.rjust(w) for i, (c, w) in enumerate(zip(line, widths))
        ).rstrip()
        for line in lines
    ]
    if header:
        out.insert(1, "  ".join("-" * w for w in widths))
    return "\n".join(out)


def in_datasheet_unit(value: float | None, symbol: str, channel: str) -> str:
    """A coefficient in SI as text in its datasheet unit, without the unit; `-` for None."""
    from imu_lib import units

    if value is None or not math.isfinite(value):
        return "-"
    return f"{value / units.datasheet(symbol, channel)[0]:.4g}"


def estimate_text(estimate, symbol: str, channel: str) -> str:
    """An Estimate as `value [low, high]` in its datasheet unit, or `< high` where the record does
    not show it.
    """
    low, high = (in_datasheet_unit(v, symbol, channel) for v in (estimate.low, estimate.high))
    if estimate.value is None:
        return f"< {high}"
    return f"{in_datasheet_unit(estimate.value, symbol, channel)} [{low}, {high}]"


_OUTPUT: list = []  # where JSON goes while a command's other words are kept off standard output


@contextmanager
def json_alone(path):
    """While it lasts, standard output is JSON alone where `path` is `-`: what a command prints for
    readers is left out.
    """
    if path != "-":
        yield
        return
    _OUTPUT.append(sys.stdout)
    sys.stdout = io.StringIO()
    try:
        yield
    finally:
        sys.stdout = _OUTPUT.pop()
