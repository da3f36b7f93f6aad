"""Questions that are put together, so that one answer is enough."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import stamps, streams
from imu_lib.readers.asking import Asked
from imu_lib.readers.assemble import UnitAsked, ask
from imu_lib.readers.instances import Several
from imu_lib.readers.raw import Raw


def with_time(error: InputError, raw: Raw, options) -> UnitAsked:
    """The question for a unit, with that for the rate or the unit of the time where one is due."""
    unit = options["time_unit"]
    if (unit or "").strip().lower() == "none":
        return UnitAsked(str(error))
    parts = streams.separate(raw)
    one = next(iter(parts.values())) if parts else raw
    try:
        stamps.settle(one, options["rate"], time_unit=unit, lenient=True, trust=options["trust"])
    except InputError as other:
        if "--rate" in str(other) or "--time-unit" in str(other):
            return _joined(error, other, raw)
    return UnitAsked(str(error))


def of_several(error: Several, units: Mapping[str, str | None], options) -> InputError:
    """The question which of several sensors is meant, with those for their units and their time."""
    raw = error.raw
    found = raw.instances
    streams.without(raw, np.flatnonzero(found.labels == found.values[0]))
    said: InputError = error
    try:
        ask(raw, units)
    except InputError as other:
        said = _joined(error, other, raw)
    return with_time(said, raw, options)


def of_columns(error: Asked, options) -> InputError:
    """The question what the columns are, with that for the unit of the time where one is due."""
    answered = options["rate"] or options["time_unit"] or "--columns" not in str(error)
    return error if answered or not error.clock else _joined(error, error.clock, None)


def _joined(first, second, raw: Raw | None) -> UnitAsked:
    said = str(second)
    if raw is not None and said.startswith(raw.source):
        said = said.removeprefix(raw.source)
        said = said[1:].strip() if said[:1] in (",", ":") else f"it{said}"
    return UnitAsked(f"{str(first).rstrip('.')}; and {said}")
