"""From raw columns to a Record: units to SI, increments to rates, stamps to seconds, every value
accounted for.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from imu_lib.errors import InputError
from imu_lib.readers import axis_units, degrees, looks, names, spelling, stamps, treated
from imu_lib.readers.meaning import INCREMENT, WORD
from imu_lib.readers.possible import check_units
from imu_lib.readers.raw import Raw, numbers
from imu_lib.record import Record

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
        source = _family(raw, kind)
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
    said, and with it the columns that may be meant. UnitAsked where a unit is open.
    """
    units = {"gyro": gyro_unit, "accel": accel_unit}
    ask(raw, units)
    out = {}
    for kind, flag in units.items():
        if _family(raw, kind):
            out[kind] = _scale(raw, kind, flag)
        elif flag:
            unused = [
                c.name
                for c in raw.described
                if c.read_as is None and c.evidence.startswith("its name")
            ]
            raw.notes += (
                f"--{kind}-unit {flag} was given, but no column of {raw.source} was read as "
                f"{WORD[kind]}"
                + (
                    f" (not used: {', '.join(unused[:6])}; --columns names columns by position)."
                    if unused
                    else "."
                ),
            )
    return out


def ask(raw: Raw, units: Mapping[str, str | None]) -> None:
    """UnitAsked with all the units that are open, or that the call misspells."""
    asked: list[str] = []
    for kind, flag in units.items():
        try:
            if flag:
                spelling.stated(flag, kind)
            elif family := _family(raw, kind):
                _unit(raw, kind, family)
        except InputError as error:
            asked.append(str(error).rstrip("."))
    if asked:
        more = [a.replace(f"{raw.source} ", "it ", 1) for a in dict.fromkeys(asked[1:])]
        raise UnitAsked("; ".join([asked[0], *more]) + ".")


def _family(raw: Raw, kind: str) -> str | None:
    """What a file has of a kind: readings, increments or nothing."""
    return next((f for f in (kind, INCREMENT[kind]) if f in raw.kinds()), None)


def _scale(raw: Raw, kind: str, flag: str | None) -> tuple[float, float, str]:
    """Factor to SI, zero and unit of a kind, from the call's flag or else from the file. What the
    call says wins, with a word.
    """
    family = _family(raw, kind) or kind
    if flag:
        factor, zero, stated = names.stated(flag, kind)
        said = {raw.units[c] for c in raw.axes(family)} - {None}
        if family != kind:
            said = {_RATE_OF.get(u, u) for u in said}
        said -= {"counts", stated}
        if said and not stated.startswith("counts") or (said and raw.contract):
            raw.notes += (
                f"The file states {' and '.join(sorted(said))} for its {WORD[kind]}; "
                f"--{kind}-unit {flag} was taken.",
            )
        return factor, zero, stated
    unit = _unit(raw, kind, family)
    if unit not in names.UNITS[family]:  # the size of a count
        flag = spelling.scaled(unit, kind)
        raw.notes += (f"Readings in [{unit}] were taken as --{kind}-unit {flag} would.",)
        return names.stated(flag, kind)
    return names.UNITS[family][unit], 0.0, unit


def _unit(raw: Raw, kind: str, family: str) -> str:
    """The unit that the file states of a kind; InputError where it is open."""
    unit = raw.unit(family)
    if unit not in (None, "counts"):
        return unit
    there = raw.axes(family)
    look = ""
    if (kind, family, len(there)) == ("accel", "accel", 3):
        look = looks.gravity_said([raw.columns[c] for c in there])
    if unit == "counts":
        raise InputError(
            f"{raw.source} states counts for its {kind} columns{look}; give their scale with "
            f"--{kind}-unit counts:C (C counts per {'deg/s' if kind == 'gyro' else 'g'}, "
            "counts:C:ZERO where zero is not 0)."
        )
    raise InputError(
        f"{raw.source} does not state the unit of its {WORD[kind]} columns{look}; give "
        f"--{kind}-unit {_OTHER[kind]}."
    )
