"""From raw columns to a Record: units to SI, increments to rates, stamps to seconds, every value
accounted for.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import names, plausibility, stamps
from imu_lib.readers.raw import Raw
from imu_lib.record import Record

_INCREMENT = {"gyro": "dtheta", "accel": "dv"}
_OTHER = {
    "gyro": "rad/s, deg/s, deg/h or counts:C (C counts per deg/s)",
    "accel": "m/s^2, g, mg or counts:C (C counts per g)",
}


def assemble(
    raw: Raw, *, rate=None, gyro_unit=None, accel_unit=None, trust=False, lenient=False
) -> Record:
    """The record that a file's columns and the call's units and rate make. InputError where they
    do not make one.
    """
    n = len(next(iter(raw.columns.values())))
    # what is missing is asked for all at once, before anything is computed
    scale = {
        kind: _scale(raw, kind, flag)
        for kind, flag in (("gyro", gyro_unit), ("accel", accel_unit))
        if kind in raw.kinds() or _INCREMENT[kind] in raw.kinds()
    }
    time, rate, keep = stamps.settle(raw, rate, lenient=lenient)
    channels = {}
    for kind, (factor, zero, _) in scale.items():
        source = kind if kind in raw.kinds() else _INCREMENT[kind]
        for axis in "xyz":
            if f"{source}_{axis}" not in raw.columns:
                continue
            x = _values(raw, f"{source}_{axis}")
            x = x if len(keep) == n else x[keep]
            x = (x - zero) * factor if zero or factor != 1.0 else x.copy()
            if source != kind:
                x *= rate
            x.setflags(write=False)
            channels[f"{kind}_{axis}"] = x
        if source != kind:
            raw.notes += (
                f"{'Delta angles' if kind == 'gyro' else 'Delta velocities'} were divided by the sampling interval, 1/{rate:.6g} s.",
            )
    record = _record(raw, channels, rate, time, _temperature(raw, keep))
    if not (trust or raw.simulated):
        check_units(
            record,
            {k: s[2] for k, s in scale.items()},
            {k: s[0] for k, s in scale.items()},
            strict=not raw.contract,
        )
    missing = int(record.missing().sum())
    if missing:
        record = record.with_note(
            f"{missing:,} of {record.n:,} samples have no number in at least one channel."
        )
    gaps = record.gaps()
    if gaps:
        record = record.with_note(
            f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''} in the time stamps, {sum(g.missing for g in gaps):,} samples missing; "
            "the longest lasts "
            f"{max(g.duration for g in gaps):.4g} s."
        )
    return record


def _record(raw, channels, rate, time, temperature):
    try:
        return Record(
            channels, rate, time, temperature, Path(raw.source).stem, raw.source, raw.notes
        )
    except ValueError as error:
        raise InputError(f"{raw.source}: {str(error).replace('`', '')}.") from None


def _scale(raw: Raw, kind: str, flag: str | None) -> tuple[float, float, str]:
    """Factor to SI, zero and unit of a kind, from the call's flag or else from the file; asked for
    where neither states one.
    """
    increments = kind not in raw.kinds()
    unit = raw.unit(_INCREMENT[kind] if increments else kind)
    if flag:
        factor, zero, stated = names.stated(flag, kind)
        if (
            unit not in (None, "counts", stated)
            and not raw.contract
            and not (
                increments and {"rad": "rad/s", "deg": "deg/s", "m/s": "m/s^2"}[unit] == stated
            )
        ):
            raise InputError(
                f"{raw.source} states {unit} for its {kind} columns, --{kind}-unit {flag}; drop the flag or correct the header."
            )
        return factor, zero, stated
    if unit == "counts":
        raise InputError(
            f"{raw.source} states counts for its {kind} columns; give their scale with --{kind}-unit counts:C "
            f"(C counts per {'deg/s' if kind == 'gyro' else 'g'}, counts:C:ZERO where zero is not 0)."
        )
    if unit is None:
        raise InputError(
            f"{raw.source} does not state the unit of its {'gyro' if kind == 'gyro' else 'accelerometer'} columns; give --{kind}-unit {_OTHER[kind]}."
        )
    return names.UNITS[_INCREMENT[kind] if increments else kind][unit], 0.0, unit


def _values(raw: Raw, canonical: str) -> np.ndarray:
    """A column as float64; infinite values are refused, a wholly empty column too."""
    x = raw.columns[canonical]
    if x.dtype.kind not in "fiub":
        raise InputError(
            f"{raw.source}, `{raw.headings[canonical]}`: holds {x.dtype} instead of numbers."
        )
    x = np.ascontiguousarray(x, dtype=np.float64)
    if x.size and not np.isfinite(x.sum()):
        infinite = np.flatnonzero(np.isinf(x))
        if infinite.size:
            raise InputError(
                f"{raw.source}, `{raw.headings[canonical]}`, {raw.line(int(infinite[0]))}: the value is infinite "
                f"({infinite.size:,} of them); "
                "leave the field empty (NaN) where a sample is missing."
            )
        if np.isnan(x).all():
            raise InputError(
                f"{raw.source}, `{raw.headings[canonical]}`: holds no number at all; name the columns with --columns and skip it with -."
            )
    return x


def _temperature(raw: Raw, keep):
    if "temperature" not in raw.columns:
        return None
    if raw.units["temperature"] not in (None, "degC"):
        raise InputError(
            f"{raw.source}: the temperature is in [{raw.units['temperature']}]; degC is expected."
        )
    t = _values(raw, "temperature")[keep]
    middle = float(np.nanmedian(t))
    if not -90 < middle < 200:
        raw.notes += (
            f"The temperature column (median {middle:.6g}) is not in degC and was left out.",
        )
        return None
    if np.isnan(t).any():
        good = ~np.isnan(t)
        t = np.interp(np.arange(len(t)), np.flatnonzero(good), t[good])
    return t


def check_units(
    record: Record, unit: dict[str, str], factor: dict[str, float], *, strict: bool = True
) -> None:
    """InputError where a stated unit is impossible, with the likely one."""
    accel = record["accel"] if all(f"accel_{a}" in record for a in "xyz") else None
    if accel is not None and "accel" in unit:
        said = plausibility.accel_unit(accel, unit["accel"], factor["accel"])
        if said:
            raise InputError(
                f"{record.source}: {said}; correct --accel-unit or the header (--trust-units if it is right)."
            )
    axes = [record.channels[c] for c in record.channels if c.startswith("gyro")]
    if axes and "gyro" in unit:
        said = plausibility.gyro_unit(
            np.column_stack(axes), accel, record.rate, unit["gyro"], strict=strict
        )
        if said:
            raise InputError(
                f"{record.source}: {said}; correct --gyro-unit or the header (--trust-units if it is right)."
            )
