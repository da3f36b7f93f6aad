"""Time stamps: the rate they tell, the samples they miss, the stamps that repeat; and where
sampling shows a frequency.
"""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from scipy.ndimage import median_filter, minimum_filter1d

Frequency = TypeVar("Frequency", float, np.ndarray)

WINDOW = 64  # samples over which late stamps may be made up for by the early ones after them
BURST_WINDOW = 512  # the same where a host read the sensor in bursts
#: Output data rates that makers of such sensors offer, Hz.
USUAL_RATES = (
    *(1.0, 4.0, 5.0, 10.0, 12.5, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 75.0, 80.0, 100.0, 104.0),
    *(119.0, 120.0, 125.0, 128.0, 150.0, 160.0, 200.0, 204.8, 208.0, 238.0, 240.0, 250.0, 256.0),
    *(300.0, 320.0, 400.0, 416.0, 476.0, 480.0, 500.0, 512.0, 600.0, 640.0, 800.0, 819.2, 833.0),
    *(952.0, 960.0, 1000.0, 1024.0, 1125.0, 1600.0, 1666.0, 1920.0, 2000.0, 3200.0, 4000.0),
    *(6660.0, 6667.0, 8000.0),
)


class Gap(NamedTuple):
    """A gap: `start` (s, last sample before it), `duration` (s to the next sample), `missing`
    samples.
    """

    start: float
    duration: float
    missing: int


class Bursts(NamedTuple):
    """Samples that the sensor gave in bursts: `size` rows at `rate` Hz each `period` s."""

    size: int
    rate: float
    period: float


def folded(frequency: Frequency, fs: float) -> Frequency:
    """Where samples at `fs` Hz show lines of `frequency` Hz."""
    return np.abs(frequency - fs * np.rint(np.divide(frequency, fs)))


def bursts(time: np.ndarray) -> Bursts | None:
    """Regular bursts in rising stamps: as many rows each time, evenly spaced within, and the
    bursts evenly spaced themselves; None where the stamps are anything else.

    A host that was busy empties its queue in bursts of any length: these are none.
    """
    step = np.diff(np.asarray(time, dtype=np.float64))
    if len(step) < 40:
        return None
    order = np.sort(step)
    ratio = order[1:] / np.maximum(order[:-1], 1e-12)
    low, high = len(order) // 4, len(order) - max(2, len(order) // 40)
    if high - low < 2:
        return None
    cut = low + int(np.argmax(ratio[low:high]))
    if ratio[cut] < 2.0:  # no two kinds of step
        return None
    between = np.flatnonzero(step > 0.5 * (order[cut] + order[cut + 1]))
    size = np.diff(between)
    if len(size) < 8:
        return None
    usual = int(np.median(size))
    if usual < 2 or np.mean(size == usual) < 0.8:
        return None
    inner = order[: cut + 1]
    period = step[between]
    apart = np.add.reduceat(step, between)[:-1][size == usual]
    for x in (inner, apart, period):
        lower, middle, upper = np.quantile(x, (0.25, 0.5, 0.75))
        if upper - lower > 0.3 * middle:
            return None
    rate = 1.0 / float(np.mean(inner[np.abs(inner - np.median(inner)) < 0.5 * np.median(inner)]))
    near = min(USUAL_RATES, key=lambda r: abs(r / rate - 1))
    return Bursts(usual, near if abs(near / rate - 1) < 0.03 else rate, float(np.median(apart)))


def in_bursts(time: np.ndarray) -> bool:
    """Whether a busy host stamped the samples: steps of very different length, some over three
    times the mean one.
    """
    if bursts(time) is not None:
        return False
    step = np.diff(time)
    low, middle, high, long = np.quantile(step, (0.25, 0.5, 0.75, 0.98))
    return bool(high - low > 0.4 * middle and long > 3.0 * step.mean())


def slots(time: np.ndarray, rate: float) -> np.ndarray:
    """Number of each sample on an even grid, shape (n,), int, rising by at least one.

    A stamp that is late because the host was busy is followed by samples in quick succession: only
    what the next stamps do not make up for counts as missing samples. Where the stamps came in
    bursts, a loss shorter than the stamps' own wandering (six times its robust scatter) cannot be
    told from it and is not counted.
    """
    time = np.asarray(time, dtype=np.float64)
    step = np.ones(len(time), dtype=np.int64)
    step[0] = 0
    late = (time - time[0]) * rate - np.arange(len(time))  # samples by which a stamp is late
    wide = np.flatnonzero(np.diff(late) > 0.5) + 1
    if wide.size and bursts(time) is not None:
        count = np.arange(len(time))
        nearest = np.rint((time - time[0]) * rate).astype(np.int64)
        return np.maximum.accumulate(nearest - count) + count
    if wide.size and in_bursts(time):
        wide = wide[(wide > BURST_WINDOW // 8) & (wide < len(time) - BURST_WINDOW // 8)]
        total = np.r_[
            0.0, np.cumsum(late)
        ]  # mean lateness of the window before against the one after
        low, high = np.maximum(wide - BURST_WINDOW, 0), np.minimum(wide + BURST_WINDOW, len(time))
        rise = (total[high] - total[wide]) / (high - wide) - (total[wide] - total[low]) / (
            wide - low
        )
        least = (
            max(0.5, 6.0 * 1.4826 * float(np.median(np.abs(rise - np.median(rise)))))
            if wide.size
            else 0.0
        )
        own = np.rint((time[wide] - time[wide - 1]) * rate) - 1
        lost = np.where((rise > least) & (own >= least), np.minimum(np.rint(rise), own), 0)
        step[wide] += lost.astype(np.int64)
    elif wide.size:
        # what the stamps from here on never fall below, against what those before had come down to
        after = minimum_filter1d(
            late, WINDOW, origin=-(WINDOW // 2), mode="nearest"
        )  # i .. i+WINDOW-1
        before = minimum_filter1d(
            late, WINDOW, origin=WINDOW // 2 - 1, mode="nearest"
        )  # i-WINDOW+1 .. i
        last = 0
        for i in wide[after[wide] - before[wide - 1] > 0.5]:
            own = (
                round((time[i] - time[i - 1]) * rate) - 1
            )  # no gap has lost more than its own length
            floor = late[max(last, i - WINDOW) : i].min()  # nor is an earlier gap counted again
            lost = min(round(after[i] - floor), own)
            if lost > 0:
                step[i] += lost
                last = i
    return np.cumsum(step)


def gaps(time: np.ndarray, slot: np.ndarray, rate: float) -> tuple[Gap, ...]:
    at = np.flatnonzero(np.diff(slot) > 1)
    return tuple(
        Gap(float(time[i]), float(time[i + 1] - time[i]), int(slot[i + 1] - slot[i] - 1))
        for i in at
    )


def measured_rate(time: np.ndarray) -> float:
    """Samples per second from rising stamps, gaps left out, Hz."""
    time = np.asarray(time, dtype=np.float64)
    regular = bursts(time)
    if regular is not None:
        return regular.rate
    step = np.diff(time)
    low, middle, high = np.quantile(step, (0.25, 0.5, 0.75))
    if (
        high - low < 0.4 * middle
    ):  # steady stamps: the usual step, averaged because stamps may be written coarsely
        usual = step[np.abs(step - middle) < 0.5 * middle]
        rate = 1.0 / float(usual.mean())
    else:  # bursts and jitter: over many samples they average out, and gaps only lengthen
        hosts = in_bursts(time)
        lag = max(1, min(1000 if hosts else 100, len(time) // 4))
        rate = lag / float(np.quantile(time[lag:] - time[:-lag], 0.5 if hosts else 0.25))
    for _ in range(8):
        new = float(slots(time, rate)[-1]) / float(time[-1] - time[0])
        if abs(new / rate - 1.0) < 1e-9:
            break
        rate = new
    nearest = round(rate)
    # stamps tell the rate to about a millisecond in their whole span: 100.0000003 Hz over an hour
    # is 100 Hz
    return (
        float(nearest)
        if nearest
        and abs(rate - nearest) * (time[-1] - time[0]) < max(1e-3 * rate, 0.5)
        and abs(rate / nearest - 1) < 1e-4
        else rate
    )


def spread_repeats(time: np.ndarray) -> tuple[np.ndarray, int]:
    """Never-falling stamps with repeats (a clock coarser than the sampling), each group spread
    evenly up to the next stamp.

    Returns the rising stamps and how many repeats there were.
    """
    time = np.asarray(time, dtype=np.float64)
    new = np.r_[True, np.diff(time) > 0]
    repeats = int(len(time) - new.sum())
    if repeats == 0:
        return time, 0
    first = np.flatnonzero(new)
    size = np.diff(np.r_[first, len(time)])
    stamp = time[first]
    tick = np.diff(stamp)
    # of the ticks nearby: stamps that are printed to so many digits grow coarser
    usual = median_filter(tick, 9, mode="nearest") if tick.size else np.ones(0)
    last = float(usual[-1]) if tick.size else 1.0
    # a group never spreads further than the clock's usual tick: what follows is a gap and stays
    # one
    width = np.r_[np.minimum(tick, usual), last]
    interval = width / size
    inner = interval[1:-1] if len(interval) > 2 else interval
    sampling = float(np.median(inner))
    inside = np.arange(len(time)) - np.repeat(first, size)
    out = np.repeat(stamp, size) + inside * np.repeat(interval, size)
    if len(size) > 2:
        # the record began and ended within a tick: those groups are not whole
        if size[0] < usual[0] / sampling and tick[0] < 1.5 * usual[0]:
            out[: size[0]] = stamp[1] - (size[0] - np.arange(size[0])) * sampling
        if size[-1] < last / sampling:
            out[first[-1] :] = stamp[-1] + np.arange(size[-1]) * sampling
    return out, repeats


def runs(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where each run of True in `mask` (n,) begins, and where the next False stands."""
    edges = np.diff(np.r_[False, mask, False].astype(np.int8))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)


def longest_run(good: np.ndarray, breaks: np.ndarray) -> tuple[int, int]:
    """Bounds (low, high) of the longest run of True in `good` that holds none of the `breaks`
    (indices that begin anew).
    """
    bad = np.flatnonzero(~good)
    starts = np.unique(np.r_[0, breaks, bad + 1, bad])
    starts = starts[starts < len(good)]
    stops = np.r_[starts[1:], len(good)]
    length = np.where(good[starts], stops - starts, 0)
    best = int(np.argmax(length))
    return int(starts[best]), int(starts[best] + length[best])


def fill(x: np.ndarray, limit: int) -> tuple[np.ndarray, int]:
    """NaN runs of up to `limit` samples inside `x` replaced by straight lines; returns the new
    array and the count.
    """
    gap = np.isnan(x)
    if not gap.any():
        return x, 0
    low, high = runs(gap)
    keep = (high - low <= limit) & (low > 0) & (high < len(x))
    mask = np.zeros(len(x) + 1, dtype=np.int64)
    np.add.at(mask, low[keep], 1)
    np.add.at(mask, high[keep], -1)
    mask = np.cumsum(mask[:-1]).astype(bool)
    out = x.copy()
    out[mask] = np.interp(np.flatnonzero(mask), np.flatnonzero(~gap), x[~gap])
    return out, int(mask.sum())
