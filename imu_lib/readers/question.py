"""What is asked where the columns of a file name no sensor."""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import by_rows, clock, instances, lexicon, looks, names
from imu_lib.readers.asking import STAMPS, Unnamed, example
from imu_lib.readers.names import SIGNALS
from imu_lib.readers.raw import Raw

UNITS = " with --gyro-unit and --accel-unit"
WIDE = 60  # columns; no logger of one sensor writes as many without names
_VOLTS = re.compile(r"[\[(]\s*m?v(?:olts?)?\s*[\])]", re.IGNORECASE)
_TAU = re.compile(r"(?:tau|averaging|cluster)(?:s|_?times?)?(?:_?s)?", re.IGNORECASE)


def refuse_deviations(raw: Raw, headings, load) -> None:
    """InputError where the rows are those of an Allan deviation: a time of averaging that grows by
    a factor from row to row.
    """
    there = [i for i, h in enumerate(headings) if _TAU.fullmatch(names.stem(h.name)[0].strip())]
    if len(there) != 1 or headings[there[0]].kind != "number":
        return
    tau = np.asarray(load(there)[there[0]], dtype=float)
    if len(tau) > 5 and (np.diff(tau) > 0).all() and tau[0] > 0 and tau[-1] > 50 * tau[0]:
        if np.diff(tau)[-1] > 5 * np.diff(tau)[0]:
            raise InputError(
                f"{raw.source}: `{headings[there[0]].name}` holds averaging times, and the rows "
                "deviations at them: the result of an Allan analysis, no samples; give the record."
            )


def clock_of(raw: Raw, headings, named: bool, load) -> str:
    """The question for the unit of the one column of stamps that such a file has; empty where it
    has none, or its unit is told.
    """
    numbers = [i for i, h in enumerate(headings) if h.kind == "number"]
    if any(h.kind in STAMPS for h in headings) or raw.rate:
        return ""
    try:
        if named:
            told = {i: names.meaning(headings[i].name) for i in numbers}
            times = [i for i, m in told.items() if m.quantity == "time"]
            if len(times) != 1 or told[times[0]].unit or headings[times[0]].unit:
                return ""
            values = load(times)
        else:
            values = load(numbers)
            times = [i for i in numbers if looks.rises(values[i])]
        x = np.asarray(values[times[0]]) if times else np.empty(0)
        if len(x) < 3 or not looks.rises(x) or (np.diff(x) < 0).any():
            return ""
        where = f"its `{headings[times[0]].name}`"
        since = (x - x[0]).astype(float)
        clock.read(since, float(x[0]), where=where, unit=None, flag=None, rate=None)
    except InputError as error:
        return str(error) if "--time-unit" in str(error) else ""
    return ""


def unnamed(raw: Raw, told, headings, signal, named, load) -> Unnamed:
    """The error that asks for the names of columns that name no sensor."""
    damage = ""
    try:
        values = load([i for i, h in enumerate(headings) if h.kind == "number"])
    except InputError as error:
        values, damage = None, f" ({str(error).removeprefix(str(raw.source)).strip(' ,:.')})"
    several = _of_several(raw, told, headings, named, load, values)
    if several:
        return Unnamed(f"{raw.source}: {several}.")
    batch = [h.name for h in headings if re.fullmatch(r"[xX]\[?\d+\]?", h.name.strip())]
    if len(batch) > 3:
        return Unnamed(
            f"{raw.source}: each of its rows holds {len(batch)} samples of one axis (`{batch[0]}` "
            f"to `{batch[-1]}`), as a sensor's buffer does; "
            "write a table with a row a sample."
        )
    width = len(headings)
    if width > WIDE and not named:
        return Unnamed(
            f"{raw.source} has {width} columns and no header of {width} names: no table of one "
            "sensor's samples, as features of windows are none; give the file with the readings, "
            "or name every column by position with --columns (gyro_x .. accel_z, - skips)."
        )
    many = f"{width} column{'s' * (width > 1)}"
    header = (
        f"its header ({', '.join(h.name for h in headings)[:80]}) names no gyro or accelerometer"
        if named
        else f"no header of {width} name{'s' * (width > 1)} right above "
        f"{'them' if width > 1 else 'it'}"
    )
    if named and (angles := _angles_alone(told, headings)):
        return Unnamed(
            f"{raw.source} holds angles ({', '.join(angles)}) and no rates or accelerations, which "
            "angles do not give back; give the file with the sensor's own readings."
        )
    named_so = example(told, headings, values)
    if not any(f"{s}_" in named_so for s in SIGNALS):
        return Unnamed(
            f"{raw.source} has {many} and {header}, and none of them holds numbers that could be "
            "one; give the file with the readings."
        )
    free = [
        i
        for i, h in enumerate(headings)
        if h.kind in ("number", "empty") and told[i].quantity is None
    ]
    one = (
        " (--gyro FILE or --accel FILE where it holds x, y, z of one sensor)"
        if len(free) in (3, 4) and not signal
        else ""
    )
    if one and "gyro_" in named_so and "accel_" not in named_so:
        other = named_so.replace("gyro_", "accel_")
        one = f", or {other} with --accel-unit where they are accelerations{one}"
    stamps = {n.partition("[")[0] for n in named_so.split(",")} & {"time", "date", "clock"}
    timed = stamps or any(m.quantity in ("time", "date", "clock") for m in told)
    rate = "" if timed or raw.rate else " and the rate with --rate HZ"
    one += _volts(headings)
    return Unnamed(
        f"{raw.source} has {many} and {header}{_commas(headings, values)}{damage}; name them by "
        f"position with --columns, as in {named_so}{units_open(named_so)}{rate}{one}."
    )


def _angles_alone(told, headings) -> list[str]:
    """Headings of the angles of an attitude, where too few unknown columns stand beside them to be
    a sensor; empty where they are fewer than two, or the rest may be one.
    """
    angles = [
        h.name
        for m, h in zip(told, headings)
        if m.why in ("an attitude", "an angle") and not re.match(r"o?q|orient", h.name, re.I)
    ]
    unknown = [
        h.name
        for m, h in zip(told, headings)
        if h.kind == "number"
        and m.quantity is None
        and m.why not in lexicon.NOT.values()
        and m.why not in ("an angle", "a velocity")
    ]
    return angles[:6] if len(angles) > 1 and len(unknown) < 3 else []


def _volts(headings) -> str:
    """A word on columns in volts; empty where there are none."""
    volts = [h.name for h in headings if _VOLTS.search(f"{h.name} [{h.unit or ''}]")]
    if not volts:
        return ""
    return (
        f"; `{volts[0]}` is in volts, of which counts:C:ZERO takes C volts per g or deg/s and ZERO "
        "volts at rest, from the data sheet"
    )


def units_open(named_so: str) -> str:
    """A word on the units that the example leaves open."""
    plain = [n for n in named_so.split(",") if "[" not in n]
    kinds = [k for k in ("gyro", "accel") if any(n.startswith(f"{k}_") for n in plain)]
    return " with " + " and ".join(f"--{k}-unit" for k in kinds) if kinds else ""


def _of_several(raw: Raw, told, headings, named, load, values) -> str | None:
    """A sentence on rows of several sensors that a column tells apart, with what reads them; None
    where there is no such column.
    """
    if named:
        found = instances.bare(told, headings, load)
        if found is None:
            return None
        some = ", ".join(found.values)
        return (
            f"its rows are of several sensors that `{found.heading}` tells apart ({some}), and "
            "nothing says what each is; read them one at a time, as in "
            f"--gyro '{raw.source}' --topic '{found.heading}={found.values[-1]}' or --accel "
            f"'{raw.source}' --topic '{found.heading}={found.values[0]}'"
        )
    if how := by_rows.example(headings, load):
        return (
            f"its rows are of several sensors that are named in them; give --columns '{how}'{UNITS}"
        )
    if turns := instances.numbered(headings, values):
        return (
            f"{turns}, as the number of a sensor does: its rows are of several sensors; write "
            "those of each into a file of its own and give --gyro FILE --accel FILE"
        )
    return None


def _commas(headings, values) -> str:
    """A word on whole numbers of which every other column, or nearly, has no sign: a decimal comma
    may be cut.
    """
    whole = [np.asarray(x) for x in (values or {}).values() if np.asarray(x).dtype.kind in "iu"]
    positive = sum(bool((x >= 0).all() and np.ptp(x) > 9) for x in whole)
    if len(whole) < 7 or len(whole) < len(headings) or positive < len(whole) // 2:
        return ""
    return (
        " (if its commas are decimal marks too, write the file with points, or with semicolons "
        "between the fields)"
    )
