"""The grain of a clock, and the even grid that stamps lie on within it or with losses."""

from __future__ import annotations

import numpy as np

from imu_lib import timing


def grain(stamp: np.ndarray, factor: float) -> float:
    """Step of the clock itself, s: what the whole numbers or the decimals of the stamps allow."""
    some = stamp[:5000]
    if stamp.dtype.kind == "i":
        step = np.diff(some)
        common = int(np.gcd.reduce(step[step != 0])) if (step != 0).any() else 1
        tick = 1  # a decimal part: a common step of 2532500 ns is the sampling, not the clock
        while common % (10 * tick) == 0:
            tick *= 10
        return tick * factor
    for decimals in range(0, 9):
        scaled = some * 10.0**decimals
        if np.abs(scaled - np.rint(scaled)).max() < 1e-4:
            return 10.0**-decimals * factor
    return 0.0


def lattice_rate(step: np.ndarray) -> float | None:
    """Rate of samples of which many were lost: every step is a whole number of the shortest ones.
    None where they are no such steps.
    """
    base = float(np.quantile(step, 0.1))
    if base <= 0:
        return None
    times = np.rint(step / base)
    single = step[times == 1]
    if len(single) < 0.2 * len(step) or single.std() > 0.05 * base:
        return None
    base = float(single.mean())
    times = np.rint(step / base)
    if not (times >= 1).all() or (np.abs(step / base - times) < 0.12).mean() < 0.98:
        return None
    return float(times.sum() / step.sum())


def without_grain(raw, time, tick, rate):
    """Stamps of a clock about as coarse as the sampling: an even grid with the gaps that they show,
    where they are nothing else within the clock's grain.
    """
    n = len(time)
    lag = max(1, min(n // 3, int(np.ceil(200 * tick * rate)) + 20))
    for _ in range(3):
        rate = lag / float(np.median(time[lag:] - time[:-lag]))
        slot = _grain_slots(time, rate, tick)
        trend = np.polyfit(slot - slot.mean(), time, 1) if n > 2 else np.array([1 / rate, 0.0])
        rate = 1.0 / float(trend[0])
    late = time * rate - slot
    late = late - np.polyval(np.polyfit(slot, late, 1), slot)
    if np.ptp(late) > 1.05 * tick * rate + 0.35:
        return time, timing.measured_rate(time)
    nearest = round(rate)
    off = abs(rate / nearest - 1) if nearest else 1.0
    if off < 2e-3 and off * (time[-1] - time[0]) < 0.25 * tick:
        rate = float(nearest)
    raw.notes += (
        f"The clock has a grain of {tick:.3g} s; within it the samples are even, at {rate:.6g} Hz.",
    )
    return slot / rate, rate


def _grain_slots(time, rate, tick) -> np.ndarray:
    """Number of each sample on the even grid: a lost sample is a step of the lateness that stays,
    by more than the clock's grain explains.
    """
    n = len(time)
    late = time * rate - np.arange(n)
    span = int(np.clip(np.ceil(8 * max(1.0, 1.0 / max(tick * rate, 0.05))), 24, 400))
    total = np.r_[0.0, np.cumsum(late)]
    at = np.arange(1, n)
    low, high = np.maximum(at - span, 0), np.minimum(at + span, n)
    rise = (total[high] - total[at]) / (high - at) - (total[at] - total[low]) / (at - low)
    short = np.minimum(at - low, high - at)
    jump = np.diff(late)
    # near the ends the mean of few samples is worth as much as the grain allows
    least = 0.6 + np.where(short < span, tick * rate / np.sqrt(np.maximum(short, 1)), 0.0)
    extra = np.zeros(n, dtype=np.int64)
    candidates = np.flatnonzero((rise > least) & (jump > 0.4))
    while candidates.size:
        best = candidates[np.argmax(rise[candidates] + 1e-3 * jump[candidates])]
        size = max(1, int(round(rise[best])))
        extra[best + 1] += size
        candidates = candidates[np.abs(candidates - best) > span]
    return np.arange(n) + np.cumsum(extra)
