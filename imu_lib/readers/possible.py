"""Are the units that a record was read in possible? One answer for gyro and accelerometer."""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import gravity, plausibility, treated
from imu_lib.record import Record


def check_units(
    record: Record, unit: dict[str, str], factor: dict[str, float], *, strict: bool = True
) -> Record:
    """InputError where a stated unit is impossible, with the likely one; a note on the record where
    it is unusual.
    """
    accel = [record.channels[f"accel_{a}"] for a in "xyz" if f"accel_{a}" in record]
    whole = record["accel"] if len(accel) == 3 else None
    refused: list[str] = []
    if accel and "accel" in unit:
        told = gravity.accel_unit(np.column_stack(accel), unit["accel"], factor["accel"])
        record = _told(record, told, "accel", refused)
        if strict and whole is not None and gravity.without_gravity(whole):
            record = record.with_note(
                "The accelerometer shows no gravity (its vector averages to nothing): it was "
                "taken out before the file was written."
            )
    axes = [record.channels[c] for c in record.channels if c.startswith("gyro")]
    if axes and "gyro" in unit:
        told = plausibility.gyro_unit(
            np.column_stack(axes),
            None if refused else whole,
            record.rate,
            unit["gyro"],
            factor["gyro"],
            strict=strict,
        )
        record = _told(record, told, "gyro", refused)
        said = treated.bias_note(np.column_stack(axes), record.rate) if strict else None
        record = record.with_note(said) if said else record
    if refused:
        raise InputError(f"{record.source}: {'; '.join(refused)}, or --trust-units if it is right.")
    return record


def _told(record: Record, told, kind: str, refused: list[str]) -> Record:
    """The record with what is unusual as a note; what is impossible goes to `refused`."""
    if told is None:
        return record
    if told.refused:
        likely = (told.likely, *told.also) if told.likely else ()
        how = ": " + " or ".join(f"--{kind}-unit {u}" for u in likely) if likely else ""
        refused.append(f"{told.why}; correct --{kind}-unit or the header{how}")
        return record
    return record.with_note(f"{told.why[:1].upper()}{told.why[1:]}.")
