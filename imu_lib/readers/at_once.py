"""Questions that are put together, so that one answer is enough."""

from __future__ import annotations

from imu_lib.errors import InputError
from imu_lib.readers import stamps, streams
from imu_lib.readers.assemble import scales
from imu_lib.readers.raw import Raw


def with_time(error: InputError, raw: Raw, options) -> InputError:
    """The question for a unit, with that for the rate or the unit of the time where one is due:
    both at once.
    """
    timed = {"time", "date", "clock"} & set(raw.columns)
    if timed and (streams.separate(raw) or "time" not in timed):
        return error
    try:
        stamps.settle(raw, options["rate"], time_unit=options["time_unit"], lenient=True)
    except InputError as other:
        said = str(other).removeprefix(raw.source).strip(" ,")
        if "--rate" in said or "--time-unit" in said:
            return InputError(f"{str(error).rstrip('.')}; and {said}")
    return error


def with_units(error: InputError, raw: Raw, units) -> InputError:
    """The question which of several sensors is meant, with that for their units where they
    state none.
    """
    try:
        scales(raw, units.get("gyro"), units.get("accel"))
    except InputError as other:
        said = str(other).removeprefix(raw.source).strip(" ,")
        return InputError(f"{str(error).rstrip('.')}; and it {said}")
    return error
