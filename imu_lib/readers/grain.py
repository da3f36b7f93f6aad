"""The grain of a clock, and the even grid that stamps lie on within it or with losses."""

from __future__ import annotations

import numpy as np

from imu_lib import timing

SYSTEM = 1 / 64  # s, the tick of many a computer's clock, whatever the decimals of its stamps


def grain(stamp: np.ndarray, factor: float) -> float:
    """Step of the clock itself, s: what the whole numbers or the decimals of the stamps allow."""
    return max(_grain(stamp[:5000], factor), _single(stamp[-5000:]) * factor)


def _single(some: np.ndarray) -> float:
    """Step of numbers of single precision at the size of the stamps; 0 where they are of double."""
    if some.dtype.kind != "f" or len(some) < 20:
        return 0.0
    short = some.astype(np.float32)
    step = float(np.spacing(np.abs(short).max()))
    exact = np.abs(some.astype(float) - short.astype(float)).max() <= 0.02 * step
    return step if exact and (some != np.rint(some)).any() else 0.0


def coarser(time: np.ndarray, tick: float) -> float:
    """Grain of the last stamps, s, where they were printed with fewer decimals as they grew (six
    digits of 999.99 and of 1000.1); `tick` where they were not. `time` begins at 0, which takes the
    decimals of the first stamp from all of them alike.
    """
    some = min(max(100, len(time) // 4), 5000)
    late, early = _grain(time[-some:], 1.0), _grain(time[:some], 1.0)
    lost = late > 5.0 * max(tick, early, 1e-9) and late < 10.0
    if not lost:
        return tick
    parts = time[:some] / late
    # a clock that is off by a millionth of a second now and then has lost nothing
    return late if np.abs(parts - np.rint(parts)).max() > 1e-3 else tick


def ticking(time: np.ndarray, tick: float) -> float | None:
    """Tick, s, of a clock that is coarser than its stamps are printed: all steps are whole numbers
    of it, and rows share a stamp or it is that of a computer's clock. None where there is none.
    """
    step = np.diff(time)
    up = step[step > 0]
    if len(up) < 20:
        return None
    low = float(np.quantile(up, 0.05))
    base = float(up[np.abs(up - low) <= max(1.5 * tick, 0.05 * low)].mean())
    for _ in range(2):
        times = np.maximum(np.rint(up / base), 1)
        base = float(up.sum() / times.sum())
    fits = np.abs(up - times * base) <= 1.01 * tick + 0.02 * base
    if base < 3.0 * tick or fits.mean() < 0.98:
        return None
    single = up[times == 1]  # printed, one tick is of two neighbouring lengths at most
    if len(single) and np.ptp(np.quantile(single, (0.01, 0.99))) > 1.1 * tick:
        return None
    shared = float((step <= 0).mean()) > 0.02
    system = abs(base / SYSTEM - 1.0) < 3e-3 and float((times > 1).mean()) > 0.02
    return base if shared or system else None


def _grain(some: np.ndarray, factor: float) -> float:
    if some.dtype.kind == "i":
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
