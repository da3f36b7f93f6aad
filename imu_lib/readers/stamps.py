"""Time stamps as they come (numbers of any unit, epochs, dates, wall clocks, counters) into seconds
from the first sample.
"""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import calendar, clock, names, numerals, odds, other_rows
from imu_lib.readers.grain import grain
from imu_lib.readers.rated import Timing, even, rated
from imu_lib.readers.raw import Raw
from imu_lib.readers.rising import counted, newest_first, rising

LOWEST, HIGHEST = 0.5, 10_100.0  # Hz, of the output of inertial sensors
BURSTS = 0.1  # of the steps


def _stamps(raw: Raw) -> tuple[np.ndarray, str]:
    """The stamps as numbers, unsigned ones as signed; InputError where they are none."""
    stamp = raw.columns["time"]
    where = f"{raw.source}, `{raw.headings['time']}`"
    if stamp.dtype.kind not in "fiu":
        raise InputError(f"{where}: time stamps are numbers or dates, not {stamp.dtype}.")
    if stamp.dtype.kind == "f" and not np.isfinite(stamp).all():
        row = int(np.flatnonzero(~np.isfinite(stamp))[0])
        raise InputError(
            f"{where}, {raw.line(row)}: the time is not a number; remove the row, or leave the "
            "stamps out with --time-unit none --rate HZ."
        )
    written = numerals.seconds(stamp, raw.units["time"])
    if written is not None:
        stamp, raw.units["time"] = written.stamp, written.unit
        raw.notes += (f"`{raw.headings['time']}` holds {written.what}.",)
    return (stamp.astype(np.int64) if stamp.dtype.kind == "u" else stamp), where


def settle(
    raw: Raw,
    rate: float | None,
    *,
    time_unit: str | None = None,
    lenient: bool = False,
    trust: bool = False,
) -> Timing:
    """The time of a raw file's rows.

    Rows logged twice are dropped, repeats of a clock coarser than the sampling are spread; both end
    up in `raw.notes`. With `lenient` single repeats that differ are kept apart by a thousandth of a
    sample instead of refused. `rate` and `time_unit` are what the call gave. InputError where the
    unit is open, or the stamps are no time.
    """
    for value, name in ((rate, "--rate"), (raw.rate, f"{raw.source}: the stated rate")):
        if value is not None and not (np.isfinite(value) and 0 < value < 1e7):
            raise InputError(f"{name} must be a positive number of Hz, not {value!r}.")
    n = raw.rows()
    given = rate or raw.rate
    if "time" in raw.columns:
        found = _numeric(raw, given, time_unit, lenient, trust, rate)
    elif "date" in raw.columns or "clock" in raw.columns:
        found = _calendar(raw, given, rate, lenient)
    else:
        found = _untimed(raw, given, n)
    if not raw.simulated:
        _doubt(raw, found)
    return found


def _doubt(raw: Raw, found: Timing) -> None:
    """A word on a rate that no inertial sensor has, and on rows that come in bursts."""
    if not LOWEST <= found.rate <= HIGHEST and not any("unusual" in n for n in raw.notes):
        raw.notes += (
            f"The rate is {found.rate:.6g} Hz, unusual for an inertial sensor; --time-unit or "
            "--rate says otherwise where that is wrong.",
        )
    if raw.contract or found.time is None or len(found.time) < 20:
        return
    step = np.diff(found.time)
    bursts = float((step > 5.0 * np.median(step)).mean())
    if bursts > BURSTS:
        raw.notes += (
            f"The rows come in bursts: {100 * bursts:.0f} % of the steps are more than five times "
            "the usual one. Either the stamps are those of arrival, or the rows are of several "
            "sensors; keep the rows of one.",
        )


def _still(raw: Raw, rate) -> Timing:
    """The time by the rate where all stamps are one."""
    raw.notes += ("All time stamps are the same; the rate alone tells the time.",)
    return _untimed(raw, rate, raw.rows())


def _untimed(raw: Raw, rate, n) -> Timing:
    keep = np.arange(n)
    count = "counter" in raw.columns
    if rate is None:
        beside = f" (`{raw.headings['counter']}` counts the samples)" if count else ""
        unread = [
            c.name
            for c in raw.described
            if c.evidence == "it holds text"
            and names.meaning(c.name).quantity in ("time", "date", "clock")
        ]
        if unread and not count:
            beside = f" that is readable (`{unread[0]}` holds text)"
        if raw.unnamed_time:
            raise InputError(
                f"{raw.source} has no column that is named a time and states no rate; "
                f"{raw.unnamed_time}; or give --rate HZ."
            )
        raise InputError(
            f"{raw.source} has no time column{beside} and states no rate; give --rate HZ."
        )
    rate = float(rate)
    if count and (np.diff(np.asarray(raw.columns["counter"], dtype=float)) == 0).mean() > 0.3:
        raw.drop("counter", "it counts frames of several samples each")
        count = False
    if count:
        time = counted(raw, "counter", rate)
        raw.told("counter", None, f"counts the samples: {rate:g} Hz by --rate")
        return _twice_counted(raw, time, rate, keep)
    return Timing(None, rate, keep)


def _twice_counted(raw, time, rate, keep) -> Timing:
    same = np.diff(time) == 0
    if same.any():
        keep = np.flatnonzero(np.r_[True, ~same])
        raw.notes += (f"{int(same.sum()):,} rows with the number of the row before were left out.",)
        time = time[keep]
    return Timing(*even(time, rate), keep)


def _numeric(raw, given, time_unit, lenient, trust, rate) -> Timing:
    stamp, where = _stamps(raw)
    stamp, order = rising(raw, stamp, where)
    first = float(stamp[0])
    relative = (stamp - stamp[0]).astype(np.float64)  # integers are subtracted exactly
    if relative[-1] <= 0 and rate:
        return _still(raw, rate)
    if relative[-1] <= 0:
        raise InputError(
            f"{where}: all {len(stamp):,} time stamps are {first:.15g}; leave the stamps out with "
            "--time-unit none --rate HZ."
        )
    if not (order == np.arange(len(order))).all():
        for c in list(raw.columns):
            raw.columns[c] = raw.columns[c][order]
        once = other_rows.once(raw, relative)  # what came twice stands side by side now
        relative = relative[once]
    keep = np.arange(len(relative))
    raw.repeats = int((np.diff(relative) == 0).sum())
    unit = raw.units["time"] if time_unit else raw.unit("time")  # what the call says wins
    if raw.contract and time_unit is None:
        unit = "s"
        if not rate:
            _slow_contract(raw, relative, first, where)
    told = clock.read(
        relative,
        first,
        where=where,
        unit=unit,
        flag=time_unit,
        rate=given,
        insisted=trust or raw.contract,
        heading=raw.headings["time"],
        rate_given=rate is not None,
    )
    if told.factor is None:
        raw.told("time", None, told.why)
        raw.notes += (f"`{raw.headings['time']}` counts the samples; the rate is that of --rate.",)
        return Timing(*even(relative / given, float(given)), keep)
    raw.told("time", told.unit, f"{_evidence(raw, 'time')}; {told.why}")
    fast = odds.mean_step(relative) < 1.0 / 300.0  # in minutes it would be a usual rate, too
    if not told.stated and (told.unit != "s" or stamp.dtype.kind != "f" or fast):
        raw.notes += (
            f"`{raw.headings['time']}` has {told.why}; --time-unit says otherwise where that is "
            "wrong.",
        )
    if told.stated and not time_unit and not raw.contract:
        raw.notes += clock.doubt(relative, first, told, raw.headings["time"])
    raw.start = first * told.factor
    raw.epoch = raw.start if raw.start > 1e8 else None
    for i, fall in raw.set_back:
        raw.notes += (
            f"The clock falls back by {-fall * told.factor:.6g} s at {raw.line(i)} (it was set, or "
            "the logger began anew); the stamps go on from there by one interval, what was lost in "
            "between is not known.",
        )
    tick, whole = grain(stamp, told.factor), stamp.dtype.kind == "i"
    return rated(raw, relative * told.factor, keep, tick, given, rate, lenient, whole)


def _slow_contract(raw: Raw, relative: np.ndarray, first: float, where: str) -> None:
    """A word on stamps of a file of the contract, which are in seconds, that are unusually slow;
    refused where they are hours apart and look like another unit.
    """
    step = odds.mean_step(relative)
    if step <= 5.0:
        return
    likely = clock.likely_unit(relative, first)
    if step > 3600.0 and likely not in (None, "s"):
        raise InputError(
            f"{where} steps by {step:.6g} s; time is in seconds in such a file, these look like "
            f"{likely}; give --time-unit {likely}, or --time-unit s if it is right."
        )
    usual = f" (in {likely} it would be usual: --time-unit {likely})" if likely else ""
    raw.notes += (
        f"`time` steps by {step:.6g} s, unusually slow for such a sensor; the time of such a file "
        f"is in seconds{usual}.",
    )


def _evidence(raw, canonical) -> str:
    return next((c.evidence for c in raw.described if c.read_as == canonical), "")


def _calendar(raw, given, rate, lenient) -> Timing:
    time, raw.epoch, minutes_only = calendar.seconds(raw)
    heading = " and ".join(f"`{raw.headings[c]}`" for c in ("date", "clock") if c in raw.columns)
    raw.start = raw.epoch
    if (np.diff(time) <= 0).all() and time[-1] < time[0]:
        newest_first(raw)
        time = time[::-1]
        for c in list(raw.columns):
            raw.columns[c] = raw.columns[c][::-1]
        if raw.epoch is not None:
            raw.epoch += float(time[0])
        raw.start = raw.epoch
        time = time - time[0]
    falls = np.flatnonzero(np.diff(time) < 0)
    if falls.size:
        raise InputError(
            f"{raw.source}, {heading}, {raw.line(int(falls[0]) + 1)}: the time falls back; "
            "sort the rows by time, or leave the stamps out with --time-unit none --rate HZ."
        )
    if time[-1] == time[0] and given:
        return _still(raw, given)
    if time[-1] == time[0]:
        raise InputError(
            f"{raw.source}, {heading}: all {len(time):,} stamps are the same; leave the stamps "
            "out with --time-unit none --rate HZ."
        )
    keep = np.arange(len(time))
    raw.repeats = int((np.diff(time) == 0).sum())
    repeated = float((np.diff(time) == 0).mean())
    if minutes_only and repeated > 0.3 and given is None:
        raise InputError(
            f"{raw.source}, {heading}: minutes and seconds are all that a spreadsheet left of the "
            f"stamps, and {100 * repeated:.0f} % of the "
            "rows repeat the stamp before; give --rate HZ."
        )
    return rated(raw, time, keep, grain(time, 1.0), given, rate, lenient)
