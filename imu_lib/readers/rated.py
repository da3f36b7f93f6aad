"""Rising stamps, in seconds, into a rate and the time of each row: repeats spread, the clock's
grain taken out, packets of rows laid out evenly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib import timing
from imu_lib.errors import InputError
from imu_lib.readers.grain import coarser, lattice_rate, ticking, without_grain


@dataclass(frozen=True)
class Timing:
    """time: s from the first sample, None where even. rate: Hz. keep: rows kept."""

    time: np.ndarray | None
    rate: float
    keep: np.ndarray


def rated(raw, time, keep, tick, given, rate, lenient, whole=False) -> Timing:
    """Repeats spread, rate measured and held against the stated one, the clock's grain taken out;
    stamps that are `whole` numbers have no decimals to lose.
    """
    n = len(time)
    late = tick if whole else coarser(time, tick)
    packed = _packets(raw, time) if ticking(time, late) is None else None
    if packed is not None:
        raw.tick = (
            1.5 * int(np.bincount(np.unique(time, return_counts=True)[1]).argmax()) / packed[1]
        )
        _agree(raw, packed[1], rate)
        return Timing(*even(*packed), keep)
    printed = tick
    tick = raw.tick = late
    if tick > printed:
        raw.notes += (
            f"The stamps lose decimals as they grow: they are printed to {tick:.3g} s at the end.",
        )
        by_first = _by_the_fine_ones(time, tick)
        if by_first is not None:
            _agree(raw, by_first[1], rate)
            return Timing(*even(*by_first), keep)
    tick = raw.tick = ticking(time, tick) or tick
    same = np.flatnonzero(np.diff(time) == 0) + 1
    # a clock coarser than the sampling repeats as often as its tick holds more than one sample
    ticks = tick * (n - 1) / max(time[-1] - time[0], 1e-12)
    coarse = ticks > 1.02 and abs(same.size / n - (1.0 - 1.0 / ticks)) < 0.05
    scattered = same.size < 0.2 * n and len(np.unique(np.diff(same))) > 1 or same.size == 1
    if same.size and scattered and not coarse:
        time, kept = _single_repeats(raw, time, same, keep, lenient)
        keep = keep[kept]
        same = same[:0]
    if same.size:
        time, repeats = timing.spread_repeats(time)
        raw.notes += (
            f"{repeats:,} of {n:,} time stamps repeat the one before (the clock is coarser than "
            "the sampling); each group was spread evenly up to the next stamp.",
        )
    if len(time) < 2:
        raise InputError(f"{raw.source} has only {len(time)} sample; at least two are needed.")
    measured = timing.measured_rate(time)
    step = np.diff(time)
    steady = np.abs(step * measured - 1.0) < 0.02
    if tick * measured > 0.2 and (steady.mean() < 0.97 or _slips(step, tick)):
        time, measured = without_grain(raw, time, tick, measured)
    elif steady.mean() < 0.97:
        measured = lattice_rate(step) or measured
    _agree(raw, measured, rate)
    return Timing(*even(time, measured), keep)


def _slips(step, tick) -> bool:
    """Whether a clock whose tick is no decimal part of a second slips evenly against the sampling:
    each of its long steps is two ticks, and they come at even intervals.
    """
    long = np.flatnonzero(step > 1.5 * np.median(step))
    if len(long) < 5 or abs(np.log10(tick) - round(np.log10(tick))) < 0.01:
        return False
    apart = np.diff(long)
    return bool(apart.std() < 0.25 * apart.mean() and step.max() < 2.5 * np.median(step))


def _agree(raw, measured, rate) -> None:
    """InputError where the rate of the stamps is not the one that the call or the file states."""
    if rate is not None and not 0.95 < rate / measured < 1.05:
        raise InputError(
            f"{raw.source}: its time stamps tell {measured:.6g} Hz, --rate {rate:g} Hz does not "
            "fit; correct it, or leave the stamps out with --time-unit none --rate HZ."
        )
    if raw.rate is None or 0.95 < raw.rate / measured < 1.05:
        return
    if rate is None:
        raise InputError(
            f"{raw.source}: its time stamps tell {measured:.6g} Hz, the file states {raw.rate:g} "
            f"Hz; give --rate {measured:.6g} if the stamps are right, "
            "or leave them out with --time-unit none --rate HZ."
        )
    raw.notes += (
        f"The file states {raw.rate:g} Hz; --rate {rate:g}, which its stamps tell too, was taken.",
    )


def _by_the_fine_ones(time, tick):
    """Time and rate by the stamps before they lose decimals, where the others are nothing else
    within what is left of them; None where those are few, or the others tell of gaps.
    """
    coarse = np.abs(time / tick - np.rint(time / tick)) < 1e-3
    fine = time[: int(np.flatnonzero(~coarse)[-1]) + 1] if not coarse.all() else time[:0]
    if len(fine) < 50 or (np.diff(fine) <= 0).any():
        return None
    rate = timing.measured_rate(fine)
    slot = timing.slots(fine, rate)
    slot = np.r_[slot, slot[-1] + np.arange(1, len(time) - len(fine) + 1)]
    grid = slot / rate
    late = time - time[0] - grid
    if np.abs(late - np.median(late[: len(fine)])).max() > 1.1 * tick:
        return None
    return grid, rate


def _packets(raw, time):
    """Time and rate where the rows come in packets of one size that share the stamp of an uneven
    arrival; None where they do not.
    """
    first = np.flatnonzero(np.r_[True, np.diff(time) > 0])
    size = np.diff(np.r_[first, len(time)])
    if len(size) < 20:
        return None
    usual = int(np.median(size))
    stamp = time[first]
    low, middle, high = np.quantile(np.diff(stamp), (0.1, 0.5, 0.9))
    if usual < 2 or (size[1:-1] == usual).mean() < 0.9 or high - low < 0.03 * middle:
        return None
    rate = timing.measured_rate(stamp)
    slot = timing.slots(stamp, rate)
    late = stamp * rate - slot
    late = late - np.polyval(np.polyfit(slot, late, 1), slot)
    if np.ptp(late) > 1.5 or (size > usual).any():
        return None
    rate = 1.0 / float(np.polyfit(slot - slot.mean(), stamp, 1)[0])
    near = round(usual * rate)
    if near and abs(usual * rate - near) * (stamp[-1] - stamp[0]) < 0.5 * usual:
        rate = near / usual
    inside = np.arange(len(time)) - np.repeat(first, size)
    inside[: size[0]] += usual - size[0]
    place = np.repeat(slot, size) * usual + inside
    raw.notes += (
        f"The rows come {usual} to a stamp, which is that of a packet's arrival; they were laid "
        f"out evenly, at {usual * rate:.6g} Hz.",
    )
    return (place - place[0]) / (usual * rate), usual * rate


def _single_repeats(raw, time, same, keep, lenient):
    data = [
        np.asarray(x)[keep]
        for c, x in raw.columns.items()
        if c not in ("time", "date", "clock", "counter", "time_accel")
    ]
    twice = np.ones(len(same), dtype=bool)
    for x in data:
        twice &= (x[same] == x[same - 1]) | ((x[same] != x[same]) & (x[same - 1] != x[same - 1]))
    if not twice.all() and not lenient:
        row = int(keep[same[~twice][0]])
        raise InputError(
            f"{raw.source}, {raw.line(row)}: the time repeats that of the row before, with other "
            f"values ({int((~twice).sum())} such rows); "
            "remove one of the two, or leave the stamps out with --time-unit none --rate HZ."
        )
    drop = same[twice]
    kept = np.delete(np.arange(len(time)), drop)
    if drop.size:
        raw.notes += (f"{drop.size:,} rows logged twice (same time, same values) were left out.",)
    time = time[kept].copy()
    still = np.flatnonzero(np.diff(time) == 0) + 1
    if still.size:
        raw.notes += (f"{still.size:,} time stamps repeat the one before with other values.",)
        time = timing.spread_repeats(time)[0]
    return time, kept


def even(time, rate):
    """No stamps where they say no more than the rate: an even grid to a hundredth of a sample."""
    if np.abs(time * rate - np.arange(len(time))).max() < 1e-2:
        return None, rate
    return time, rate
