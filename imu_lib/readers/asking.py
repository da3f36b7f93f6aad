"""Columns that are named by the caller, and the sentence that asks for their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.names import SIGNALS, Meaning

STAMPS = ("date", "clock", "moment")


@dataclass(frozen=True)
class Heading:
    """name: as in the file. kind: number, date, clock, moment, text or empty. unit: of a row of
    units below the header, where there is one.
    """

    name: str
    kind: str = "number"
    unit: str | None = None


def example(told, headings) -> str:
    """Names by position for columns that say nothing: clocks and text as they are, then the
    numbers as they most often stand.
    """
    out = []
    numbers = [
        i
        for i, h in enumerate(headings)
        if h.kind in ("number", "empty") and told[i].quantity is None
    ]
    order = ["gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"]
    stamped = any(h.kind in STAMPS for h in headings) or any(m.quantity == "time" for m in told)
    if not stamped and len(numbers) not in (1, 3, 6):
        order = ["time", *order]
    fill = dict(zip(numbers, order + ["-"] * len(numbers)))
    for i, (m, h) in enumerate(zip(told, headings)):
        if i in fill:
            out.append(fill[i])
        elif h.kind in STAMPS:
            out.append("clock" if h.kind == "clock" else "date")
        else:
            out.append(
                m.canonical if m.canonical in ("time", "temperature", "date", "clock") else "-"
            )
    return ",".join(out)


def suggestion(told, headings, skip: Sequence[int] = ()) -> str:
    """`--columns ...` as the file would be read when the columns of `skip` are left out."""
    taken: set[str] = set()
    out = []
    numbers = 0
    for i, (m, _) in enumerate(zip(told, headings)):
        axis = m.axis
        if m.axis and m.axis.isdigit():
            axis = "xyz"[min(int(m.axis), 2)]
        name = (
            f"{m.quantity}_{axis}"
            if m.quantity in SIGNALS and axis in ("x", "y", "z")
            else m.quantity
        )
        if (
            i in skip
            or name is None
            or name in taken
            or name in (*SIGNALS, "part", "counter", "alpha")
        ):
            out.append("-")
            continue
        taken.add(name)
        numbers += 1
        out.append(f"{name}[{m.unit}]" if m.unit and name != "clock" else name)
    return f"say which is meant with --columns, as in --columns '{','.join(out)}'"


def by_position(
    columns: str | Sequence[str], found: int, source: str, signal: str | None
) -> list[Meaning]:
    """What each of `found` columns is, from the names the caller gave. InputError where they do not
    fit.
    """
    given = (
        [c.strip() for c in columns.split(",")]
        if isinstance(columns, str)
        else [str(c).strip() for c in columns]
    )
    if len(given) != found:
        raise InputError(
            f"{source} has {found} columns but --columns names {len(given)}; name every one by position, - skips."
        )
    out = []
    for name in given:
        if name in ("-", ""):
            out.append(Meaning(why="skipped by --columns"))
            continue
        told = names.meaning(name, signal=signal)
        if (
            told.canonical is None
            or told.quantity in SIGNALS
            and not told.axis
            or told.quantity == "part"
        ):
            raise InputError(
                f"--columns: {name!r} is no column name; use time, date, clock, temperature, counter, gyro_x .. gyro_z, accel_x .. accel_z, "
                "dtheta_x .. dtheta_z, dv_x .. dv_z or -."
            )
        out.append(replace(told, why=f"--columns names it {name}"))
    if not any(m.quantity in SIGNALS for m in out):
        raise InputError("--columns names no signal; at least one of gyro_x .. accel_z is needed.")
    return out
