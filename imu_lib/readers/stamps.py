"""Time stamps as they come (numbers of any unit, epochs, dates, wall clocks) into seconds from the
first sample.
"""

from __future__ import annotations

import numpy as np

from imu_lib import timing
from imu_lib.errors import InputError
from imu_lib.readers import names
from imu_lib.readers.raw import Raw

SLOWEST = 5.0  # s between samples: no IMU is slower, but milliseconds taken for seconds are


def numeric(raw: Raw, rate: float | None) -> tuple[np.ndarray, float | None]:
    """Seconds from the first sample and the absolute time of the first (None where the stamps are
    relative).
    """
    stamp = raw.columns["time"]
    where = f"{raw.source}, `{raw.headings['time']}`"
    if stamp.dtype.kind not in "fiu":
        raise InputError(f"{where}: time stamps are numbers or dates, not {stamp.dtype}.")
    if stamp.dtype.kind == "f" and not np.isfinite(stamp).all():
        row = int(np.flatnonzero(~np.isfinite(stamp))[0])
        raise InputError(
            f"{where}, {raw.line(row)}: the time is not a number; remove the row, or leave the time column out and give --rate."
        )
    if stamp.dtype.kind == "u":
        stamp = stamp.astype(np.int64)
    falls = np.flatnonzero(np.diff(stamp) < 0)
    if falls.size:
        row = int(falls[0]) + 1
        raise InputError(
            f"{where}, {raw.line(row)}: the time falls from {stamp[row - 1]:.15g} to {stamp[row]:.15g}; sort the rows by time, "
            f"or leave the column "
            "out and give --rate."
        )
    first = float(stamp[0])
    relative = (stamp - stamp[0]).astype(
        np.float64
    )  # integers are subtracted exactly, before they become floats
    if relative[-1] <= 0:
        raise InputError(
            f"{where}: all {len(stamp):,} time stamps are {first:.15g}; leave the column out and give --rate."
        )
    step = relative[-1] / (len(relative) - 1)
    if raw.contract and step > SLOWEST and not rate:
        likely = next(
            (u for u in ("ms", "us", "ns") if 1.0 <= 1.0 / (step * names.TIME_UNITS[u]) <= 20_000),
            None,
        )
        raise InputError(
            f"{where} steps by {step:.6g} s; time is in seconds in such a file"
            + (
                f", these look like {likely}: convert them."
                if likely
                else ": convert it, or give --rate."
            )
        )
    unit = raw.unit("time") or ("s" if raw.contract else _unit(relative, first, rate, where))
    factor = names.TIME_UNITS[unit]
    start = first * factor
    return relative * factor, start if start > 1e8 else None


def _unit(relative, first, rate, where) -> str:
    """The unit of stamps that state none: told by an epoch's size, by the rate given, or by the
    one rate that an IMU can have.
    """
    for unit, low in (("ns", 1e17), ("us", 1e14), ("ms", 1e11), ("s", 1e8)):
        if low * 3 < first < low * 5e2:
            return unit
    step = relative[-1] / (len(relative) - 1)
    fits = {u: 1.0 / (step * names.TIME_UNITS[u]) for u in ("s", "ms", "us", "ns")}
    if rate:
        near = [u for u, r in fits.items() if 0.7 < r / rate < 1.4]
        if near:
            return near[0]
    if 0.9 <= fits["s"] <= 20_000 and not np.array_equal(relative, np.arange(len(relative))):
        return "s"
    likely = next(
        (f"in {u} it would be {r:.4g} Hz" for u, r in fits.items() if 1 <= r <= 20_000),
        "no usual unit gives a rate between 1 and 20000 Hz",
    )
    raise InputError(
        f"{where} does not state the unit of its time, which steps by {step:.6g} ({likely}); name it in the header or with --columns "
        "as time[s], time[ms], time[us] or time[ns], or give --rate."
    )


def calendar(raw: Raw) -> tuple[np.ndarray, float | None]:
    """Seconds from the first sample from columns of dates and wall clocks, and the first moment as
    an epoch (None without a date).
    """
    import pandas as pd

    date, clock = raw.columns.get("date"), raw.columns.get("clock")
    text = (
        date
        if clock is None
        else clock
        if date is None
        else np.char.add(np.char.add(date.astype(str), "T"), clock.astype(str))
    )
    heading = " and ".join(f"`{raw.headings[c]}`" for c in ("date", "clock") if c in raw.columns)
    if date is None:
        text = np.char.add("2000-01-01T", clock.astype(str))
    moments, which = (
        np.unique(np.asarray(text, dtype=str), return_inverse=True)
        if len(text) > 1
        else (np.asarray(text, dtype=str), np.zeros(1, int))
    )
    try:
        parsed = pd.to_datetime(
            pd.Series(
                [
                    m.replace("/", "-").replace(",", ".").replace(".", "-", 2)
                    if "." in m[:8]
                    else m.replace("/", "-").replace(",", ".")
                    for m in moments
                ]
            ),
            format="ISO8601",
            utc=True,
        )
    except ValueError:
        try:
            parsed = pd.to_datetime(pd.Series(moments), format="mixed", dayfirst=True, utc=True)
        except ValueError as error:
            raise InputError(
                f"{raw.source}, {heading}: dates or clocks are not readable ({str(error).splitlines()[0][:90]}); write them as 2018-04-25T15:10:13.25."
            ) from None
    ns = parsed.to_numpy(dtype="datetime64[ns]").astype(np.int64)[which]
    if date is None:  # past midnight the clock begins anew
        ns = ns + np.cumsum(np.r_[0, np.diff(ns) < -43_200_000_000_000]) * 86_400_000_000_000
    falls = np.flatnonzero(np.diff(ns) < 0)
    if falls.size:
        raise InputError(
            f"{raw.source}, {heading}, {raw.line(int(falls[0]) + 1)}: the time falls back; sort the rows by time, or leave the columns out and give --rate."
        )
    if ns[-1] == ns[0]:
        raise InputError(
            f"{raw.source}, {heading}: all {len(ns):,} stamps are the same; leave the columns out and give --rate."
        )
    return (ns - ns[0]) * 1e-9, None if date is None else ns[0] * 1e-9


def settle(
    raw: Raw, rate: float | None, *, lenient: bool = False
) -> tuple[np.ndarray | None, float, np.ndarray]:
    """(time or None, rate, rows kept) of a raw file. `rate` is what the call gave.

    Repeats of a clock coarser than the sampling are spread; rows logged twice are dropped; both
    end up in `raw.notes`. With `lenient`
    single repeats that differ are kept apart by a thousandth of a sample instead of refused.
    """
    for value, name in ((rate, "--rate"), (raw.rate, f"{raw.source}: the stated rate")):
        if value is not None and not (np.isfinite(value) and 0 < value < 1e7):
            raise InputError(f"{name} must be a positive number of Hz, not {value!r}.")
    n = len(next(iter(raw.columns.values())))
    keep = np.arange(n)
    if "time" in raw.columns:
        time, raw.epoch = numeric(raw, rate or raw.rate)
    elif "date" in raw.columns or "clock" in raw.columns:
        time, raw.epoch = calendar(raw)
    else:
        rate = rate or raw.rate
        if rate is None:
            raise InputError(f"{raw.source} has no time column and states no rate; give --rate HZ.")
        return None, float(rate), keep
    same = np.flatnonzero(np.diff(time) == 0) + 1
    raw.repeats = len(same)
    if same.size and same.size < 0.2 * n and len(np.unique(np.diff(same))) > 1 or same.size == 1:
        time, keep = _single_repeats(raw, time, same, lenient)
    else:
        time, repeats = timing.spread_repeats(time)
        if repeats:
            raw.notes += (
                f"{repeats:,} of {n:,} time stamps repeat the one before (the clock is coarser than the sampling); "
                "each group was spread evenly up to the next stamp.",
            )
    if len(time) < 2:
        raise InputError(f"{raw.source} has only {len(time)} sample; at least two are needed.")
    measured = timing.measured_rate(time)
    for value, name in ((rate, "--rate"), (raw.rate, "the rate the file states,")):
        if value is not None and not 0.95 < value / measured < 1.05:
            raise InputError(
                f"{raw.source}: its time stamps tell {measured:.6g} Hz, {name} {value:g} Hz does not fit; correct it or leave the time column out."
            )
    time, measured = _even(raw, time, measured)
    return time, measured, keep


def _single_repeats(raw, time, same, lenient):
    data = [
        np.asarray(x) for c, x in raw.columns.items() if c not in ("time", "date", "clock", "index")
    ]
    twice = np.ones(len(same), dtype=bool)
    for x in data:
        twice &= (x[same] == x[same - 1]) | ((x[same] != x[same]) & (x[same - 1] != x[same - 1]))
    if not twice.all() and not lenient:
        row = int(same[~twice][0])
        raise InputError(
            f"{raw.source}, {raw.line(row)}: the time repeats that of the row before, with other values ({int((~twice).sum())} such rows); "
            "remove one of the two, or leave the time column out and give --rate."
        )
    drop = same[twice]
    keep = np.delete(np.arange(len(time)), drop)
    if drop.size:
        raw.notes += (f"{drop.size:,} rows logged twice (same time, same values) were left out.",)
    time = time[keep].copy()
    still = np.flatnonzero(np.diff(time) == 0) + 1
    if still.size:
        raw.notes += (f"{still.size:,} time stamps repeat the one before with other values.",)
        time = timing.spread_repeats(time)[0]
    return time, keep


def _even(raw, time, rate):
    """No stamps where they say no more than the rate: an even grid to a hundredth of a sample."""
    if np.abs(time * rate - np.arange(len(time))).max() < 1e-2:
        return None, rate
    return time, rate
