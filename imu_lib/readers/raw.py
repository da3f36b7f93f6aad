"""What a file holds before it is a record: columns under canonical names, in the file's own units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import names


@dataclass
class Raw:
    """Columns by canonical name (see `names.parse`) with the unit each one's name states (None
    where it states none).

    contract: the file says by its keys that it is in SI. simulated: it says that imu_lib drew it.
    epoch: absolute time of the first stamp, s, where the stamps tell; repeats: how many stamps
    repeated the one before. line:
    row number -> what to call it in a message.
    """

    source: str
    columns: dict[str, np.ndarray] = field(default_factory=dict)
    units: dict[str, str | None] = field(default_factory=dict)
    rate: float | None = None
    notes: tuple[str, ...] = ()
    contract: bool = False
    simulated: bool = False
    epoch: float | None = None
    repeats: int = 0
    line: Callable[[int], str] = lambda row: f"sample {row + 1}"
    headings: dict[str, str] = field(default_factory=dict)

    def add(self, canonical: str, values, unit: str | None, heading: str) -> None:
        """Take a column in; an array (n, 3) called gyro, accel, dtheta or dv is three of them."""
        values = np.asarray(values)
        if canonical in ("gyro", "accel", "dtheta", "dv"):
            if values.ndim != 2 or 3 not in values.shape:
                raise InputError(
                    f"{self.source}: `{heading}` has the shape {values.shape}; three axes, (n, 3), are expected."
                )
            values = values if values.shape[1] == 3 else values.T
            for i, axis in enumerate("xyz"):
                self.add(f"{canonical}_{axis}", values[:, i], unit, heading)
            return
        if values.ndim == 2 and 1 in values.shape:
            values = values.ravel()
        if values.ndim != 1:
            raise InputError(
                f"{self.source}: `{heading}` has the shape {values.shape}; one value per sample is expected."
            )
        if canonical in self.columns:
            raise InputError(
                f"{self.source}: both `{self.headings[canonical]}` and `{heading}` would be {canonical}; "
                "say which is meant with --columns (names by position, - skips)."
            )
        self.columns[canonical] = values
        self.units[canonical] = unit
        self.headings[canonical] = heading

    def kinds(self) -> set[str]:
        return {
            c.rpartition("_")[0]
            for c in self.columns
            if c.rpartition("_")[0] in ("gyro", "accel", "dtheta", "dv")
        }

    def unit(self, kind: str) -> str | None:
        """The one unit that the columns of a kind state, None where none does. InputError where
        they contradict or are unknown.
        """
        said = {
            u
            for c, u in self.units.items()
            if (c == kind or c.startswith(kind + "_")) and u is not None
        }
        if len(said) > 1:
            raise InputError(
                f"{self.source}: the {kind} columns state different units ({', '.join(sorted(said))}); give one with --{kind}-unit."
            )
        unit = said.pop() if said else None
        if unit is not None and unit != "counts" and unit not in names.UNITS[kind]:
            raise InputError(
                f"{self.source}: the unit [{unit}] of "
                f"`{self.headings.get(kind) or next(h for c, h in self.headings.items() if c.startswith(kind))}` "
                f"is not known; give it in {', '.join(names.UNITS[kind])}."
            )
        return unit


def by_position(
    columns: str | list[str] | tuple[str, ...], found: int, source: str, signal: str | None
) -> list[tuple[str | None, str | None, str]]:
    """(canonical, unit, heading) for each of `found` columns from the names the caller gave.
    InputError where they do not fit.
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
            out.append((None, None, name))
            continue
        canonical, unit = names.parse(name, signal=signal)
        if canonical is None or canonical in ("gyro", "accel"):
            raise InputError(
                f"--columns: {name!r} is no column name; use time, date, clock, temperature, gyro_x .. gyro_z, accel_x .. accel_z, "
                "dtheta_x .. dtheta_z, dv_x .. dv_z or -."
            )
        out.append((canonical, unit, name))
    if not any(c and c[:2] in ("gy", "ac", "dt", "dv") for c, _, _ in out):
        raise InputError("--columns names no signal; at least one of gyro_x .. accel_z is needed.")
    return out
