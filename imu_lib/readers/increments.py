"""Increments under the names of rates: at rest the length of the accelerometer is gravity over the
rate.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.readers import looks, names
from imu_lib.readers.raw import Raw

RATES = (20.0, 5000.0)  # Hz; slower, such a length may be a reading's own
_OF = {"m/s": units.G, "g*s": 1.0}  # length of gravity in the unit of a rate


def refuse(raw: Raw, rate: float | None, flags: Mapping[str, str | None]) -> None:
    """InputError where the columns of an accelerometer, in m/s^2, g or an open unit, have the
    length of gravity over the rate.

    rate, flags : what the call says, Hz and the unit of each kind.
    """
    there = [] if raw.contract else raw.axes("accel")
    rate = rate or raw.rate or _stamped(raw)
    if len(there) < 3 or not rate or not RATES[0] < rate < RATES[1]:
        return
    if not _stated(raw, "accel", flags) <= {None, "m/s^2", "g"}:
        return
    three = [raw.columns[c] for c in there]
    if any(np.asarray(x).dtype.kind not in "fiu" for x in three) or looks.gravity_said(three):
        return
    x = np.column_stack([np.asarray(x, dtype=float) for x in three])
    x = x[np.isfinite(x).all(axis=1)]
    size = float(np.linalg.norm(np.median(x, axis=0))) if len(x) else 0.0
    fit = [u for u, g in _OF.items() if abs(size * rate / g - 1.0) < looks.NEAR]
    # of a vector that keeps its length: noise without gravity has none
    if not fit or float(looks.lengths(three).std()) > 0.3 * size:
        return
    told = _columns(raw, fit[0], "deg" if "deg/s" in _stated(raw, "gyro", flags) else "rad")
    raise InputError(
        f"{raw.source}: the length of its accelerometer is {size:.4g}, gravity in "
        f"{'m/s^2' if fit[0] == 'm/s' else 'g'} over the rate of {rate:.5g} Hz: these look like "
        f"increments, not rates; give --columns '{told}', or --accel-unit with "
        "--trust-units if they are rates."
    )


def _stated(raw: Raw, kind: str, flags) -> set[str | None]:
    """Units of a kind by the call, or else by its headings."""
    return {flags[kind]} if flags.get(kind) else {raw.units[c] for c in raw.axes(kind)}


def _columns(raw: Raw, force: str, angle: str) -> str:
    """Names by position under which the readings are increments in these units."""
    told = []
    for column in raw.described:
        kind, _, axis = (column.read_as or "-").partition("_")
        name = {"gyro": f"dtheta_{axis}[{angle}]", "accel": f"dv_{axis}[{force}]"}.get(kind)
        stated = f"[{column.unit}]" if column.unit and column.read_as else ""
        told.append(name or f"{column.read_as or '-'}{stated}")
    return ",".join(told)


def _stamped(raw: Raw) -> float | None:
    """Rate (Hz) of stamps in the unit that the file states, or else in the one of s, ms, us and ns
    in which it is usual; None where there are none.
    """
    stamp = np.asarray(raw.columns.get("time", ()))
    if stamp.dtype.kind not in "fiu" or len(stamp) < 3:
        return None
    step = float(np.median(np.diff(stamp)))
    unit = raw.units.get("time")
    for per in [names.TIME_UNITS.get(unit, 0.0)] if unit else [1.0, 1e-3, 1e-6, 1e-9]:
        if step * per > 0 and RATES[0] < 1.0 / (step * per) < RATES[1]:
            return 1.0 / (step * per)
    return None
