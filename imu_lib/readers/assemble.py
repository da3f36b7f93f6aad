"""From raw columns to a Record: units to SI, increments to rates, stamps to seconds, every value
accounted for.
"""

from __future__ import annotations

from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.readers import axis_units, degrees, names, spelling, stamps, treated
from imu_lib.readers.possible import check_units
from imu_lib.readers.raw import Raw, numbers
from imu_lib.record import Record

_INCREMENT = {"gyro": "dtheta", "accel": "dv"}
_RATE_OF = {"rad": "rad/s", "deg": "deg/s", "m/s": "m/s^2", "g*s": "g"}
_OTHER = {
    "gyro": "rad/s, deg/s, deg/h, mdps or counts:C (C counts per deg/s)",
    "accel": "m/s^2, g, mg or counts:C (C counts per g)",
}


class UnitAsked(InputError):
    """The unit of a sensor is open."""


def assemble(
    raw: Raw,
    *,
    rate=None,
    gyro_unit=None,
    accel_unit=None,
    time_unit=None,
    trust=False,
    lenient=False,
) -> Record:
    """The record that a file's columns and the call's units and rate make. InputError where they
    do not make one.
    """
    n = raw.rows()
    # what is missing is asked for all at once, before anything is computed
    axis_units.one_each(raw, {"gyro": gyro_unit, "accel": accel_unit})
    if not trust:
        treated.refuse_angles(raw)
    scale = scales(raw, gyro_unit, accel_unit)
    found = stamps.settle(raw, rate, time_unit=time_unit, lenient=lenient, trust=trust)
    time, rate, keep = found.time, found.rate, found.keep
    channels = {}
    for kind, (factor, zero, unit) in scale.items():
        source = kind if kind in raw.kinds() else _INCREMENT[kind]
        for axis in "xyz":
            if f"{source}_{axis}" not in raw.columns:
                continue
            x = numbers(raw, f"{source}_{axis}")
            x = x if len(keep) == n else x[keep]
            x = (x - zero) * factor if zero or factor != 1.0 else x.copy()
            if source != kind:
                x *= rate
            x.setflags(write=False)
            channels[f"{kind}_{axis}"] = x
            raw.told(f"{source}_{axis}", unit)
        if source != kind:
            raw.notes += (
                f"{'Delta angles' if kind == 'gyro' else 'Delta velocities'} were divided by the "
                f"sampling interval, 1/{rate:.6g} s.",
            )
    record = _record(raw, channels, rate, time, degrees.celsius(raw, keep))
    if not (trust or raw.simulated):
        record = check_units(
            record,
            {k: s[2] for k, s in scale.items()},
            {k: s[0] for k, s in scale.items()},
            strict=not raw.contract or _contradicted(scale),
        )
    missing = int(record.missing().sum())
    if missing:
        record = record.with_note(
            f"{missing:,} of {record.n:,} samples have no number in at least one channel."
        )
    gaps = record.gaps()
    if gaps:
        record = record.with_note(
            f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''} in the time stamps, "
            f"{sum(g.missing for g in gaps):,} samples missing; the longest lasts "
            f"{max(g.duration for g in gaps):.4g} s."
        )
    return record


def _contradicted(scale) -> bool:
    """Whether the call states another unit than SI, in which files with the contract's keys are."""
    return any(s[2] not in ("rad/s", "m/s^2") for s in scale.values())


def _record(raw, channels, rate, time, temperature):
    try:
        return Record(
            channels, rate, time, temperature, Path(raw.source).stem, raw.source, raw.notes
        )
    except ValueError as error:
        raise InputError(f"{raw.source}: {str(error).replace('`', '')}.") from None


def scales(raw: Raw, gyro_unit, accel_unit) -> dict[str, tuple[float, float, str]]:
    """Factor to SI, zero and unit of each kind; a unit given for what the file does not have is
    said, and with it the columns that may be meant.
    """
    out = {}
    asked: list[str] = []
    ask_for_both(raw, gyro_unit, accel_unit)
    for kind, flag in (("gyro", gyro_unit), ("accel", accel_unit)):
        if kind in raw.kinds() or _INCREMENT[kind] in raw.kinds():
            try:
                out[kind] = _scale(raw, kind, flag)
            except InputError as error:
                asked.append(str(error))
        elif flag:
            spelling.stated(flag, kind)  # a wrong unit is wrong all the same
            word = "gyro" if kind == "gyro" else "accelerometer"
            unused = [
                c.name
                for c in raw.described
                if c.read_as is None and c.evidence.startswith("its name")
            ]
            raw.notes += (
                f"--{kind}-unit {flag} was given, but no column of {raw.source} was read as {word}"
                + (
                    f" (not used: {', '.join(unused[:6])}; --columns names columns by position)."
                    if unused
                    else "."
                ),
            )
    if asked:  # two questions at once
        raise UnitAsked("; ".join(a.rstrip(".") for a in dict.fromkeys(asked)) + ".")
    return out


def ask_for_both(raw: Raw, gyro_unit, accel_unit) -> None:
    """InputError where both units are missing: asked for at once."""
    ask_of_two(raw, gyro_unit, raw, accel_unit)


def ask_of_two(gyro: Raw, gyro_unit, accel: Raw, accel_unit) -> None:
    """The same of a gyro's and an accelerometer's file."""
    for kind, raw, flag in (("gyro", gyro, gyro_unit), ("accel", accel, accel_unit)):
        family = kind if kind in raw.kinds() else _INCREMENT[kind]
        try:
            known = family not in raw.kinds() or flag or raw.unit(family) is not None
        except InputError:
            return  # asked about with the other one
        if known:
            return
    whose = "its" if accel is gyro else f"{accel.source}'s"
    raise InputError(
        f"{gyro.source} does not state the unit of its gyro columns; give --gyro-unit "
        f"{_OTHER['gyro']}; nor that of {whose} accelerometer columns;"
        f" give --accel-unit {_OTHER['accel']}."
    )


def _scale(raw: Raw, kind: str, flag: str | None) -> tuple[float, float, str]:
    """Factor to SI, zero and unit of a kind, from the call's flag or else from the file; asked for
    where neither states one. What the call says wins, with a word.
    """
    increments = kind not in raw.kinds()
    family = _INCREMENT[kind] if increments else kind
    if flag:
        factor, zero, stated = names.stated(flag, kind)
        said = {
            u for c, u in raw.units.items() if c.startswith(family + "_") and c in raw.columns and u
        }
        said = {_RATE_OF.get(u, u) if increments else u for u in said} - {"counts", stated}
        if said and not stated.startswith("counts") or (said and raw.contract):
            raw.notes += (
                f"The file states {' and '.join(sorted(said))} for its "
                f"{'gyro' if kind == 'gyro' else 'accelerometer'}; --{kind}-unit {flag} was taken.",
            )
        return factor, zero, stated
    unit = raw.unit(family)
    if unit == "counts":
        raise InputError(
            f"{raw.source} states counts for its {kind} columns; give their scale with "
            f"--{kind}-unit counts:C (C counts per {'deg/s' if kind == 'gyro' else 'g'}, "
            "counts:C:ZERO where zero is not 0)."
        )
    if unit is None:
        raise InputError(
            f"{raw.source} does not state the unit of its "
            f"{'gyro' if kind == 'gyro' else 'accelerometer'} columns; give --{kind}-unit "
            f"{_OTHER[kind]}."
        )
    if unit not in names.UNITS[family]:  # the size of a count
        flag = spelling.scaled(unit, kind)
        raw.notes += (f"Readings in [{unit}] were taken as --{kind}-unit {flag} would.",)
        return names.stated(flag, kind)
    return names.UNITS[family][unit], 0.0, unit
