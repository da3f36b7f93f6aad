"""It was touched: knocks and handling, found as bursts of energy, or excursions of the level, that
stand out of the noise on both sides of them.

One sample thrown off on one channel is the electronics' (a spike), a change that stays is a step or
a tilt, a vibration that goes on is the environment's: none of them is found here.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import poisson

from imu_lib.faults import ranks
from imu_lib.faults.excursion import LEVEL, excursions
from imu_lib.faults.finding import Finding, named, seconds
from imu_lib.faults.hits import ALONE, Hit, merged
from imu_lib.faults.levels import Prepared, tail_threshold, windows
from imu_lib.faults.ranks import TOGETHER

#: s of the windows of energy; one sample long, too, where several channels agree.
ENERGY = (0.02, 0.08, 0.32, 1.28)
#: The same of one channel alone, in each of some sixty searches (windows, offsets, channels).
APART = TOGETHER / 60
#: Noise levels by which a sample must stand out on each of several channels.
STANDS = 5.5
#: Noise levels from which on a sample is large.
LARGE = 4.0
#: Ratio of energies, without the few largest samples', that one channel alone must reach.
LOUD = 6.0
#: Ratio that no stationary noise reaches with that many samples at once, whatever its tails.
PLAIN, CROWD = 120.0, 16
#: s of the means that tell where an excursion of the level begins and ends.
FINE = 0.25
#: s between two findings that are one.
JOINED = 0.6
#: s in which a knock rings down, at the most.
RINGS = 8.0
#: s up to which it is a knock.
KNOCK = 1.0


def find(channels: dict[str, Prepared], time: np.ndarray, rate: float) -> list[Finding]:
    """Disturbances of a record, in the order of time."""
    names = list(channels)
    fast = np.stack([channels[c].fast for c in names])
    n = fast.shape[1]
    hits: list[Hit] = []
    for length in sorted({1, *(max(4, round(s * rate)) for s in ENERGY)}):
        if n // length >= 40 and (length <= 4 or length <= 2.5 * rate):
            hits += _energy(fast, length)
    x = np.stack([channels[c].x for c in names])
    bad = np.any([channels[c].bad for c in names], axis=0)
    for length in sorted({max(2, round(s * rate)) for s in LEVEL}):
        if n // length >= 24:
            hits += excursions(x, bad, length, rate, names)
    found = []
    for hit in merged(hits, max(2, round(JOINED * rate))):
        left = _no_steps(hit, channels, names, rate)
        if left is not None and not _spike(left, channels, names):
            found.append(_finding(left, channels, names, time, rate))
    return found


def _spike(hit: Hit, channels, names) -> bool:
    """Whether it is one sample of one channel: with the moving mean taken out, a large one leaves
    its shadow on its neighbours.
    """
    if hit.slow or len(hit.channels) != 1:
        return False
    (c,) = hit.channels
    ready, near = channels[names[c]], 50
    low, high = max(0, hit.low - near), min(len(ready.x), hit.high + near)
    level = np.median(ready.x[low:high])
    off = np.abs(ready.x[hit.low : hit.high] - level)
    return np.count_nonzero(off > LARGE * ready.sigma[hit.low]) <= 1


def _no_steps(hit: Hit, channels, names, rate: float) -> Hit | None:
    """The hit without the channels on which the level only changes, None where no other is left.

    A step leaves a burst in what is above 1 Hz; with it taken out nothing stands out.
    """
    if hit.slow:
        return hit
    left = []
    for c in hit.channels:
        ready = channels[names[c]]
        reach = max(8, int(rate))
        low, high = max(0, hit.low - reach), min(len(ready.x), hit.high + reach)
        y = ready.x[low:high] / ready.sigma[min((hit.low + hit.high) // 2, len(ready.x) - 1)]
        k = np.arange(4, len(y) - 4)
        if not len(k):
            left.append(c)
            continue
        total, n = np.cumsum(y), len(y)
        before, after = total[k - 1] / k, (total[-1] - total[k - 1]) / (n - k)
        gain = (before - after) ** 2 * k * (n - k) / n
        at = int(np.argmax(gain))
        rest = y - np.where(np.arange(n) < k[at], before[at], after[at])
        if gain[at] < 20 or np.sort(np.abs(rest))[-2] > STANDS:
            left.append(c)
    return Hit(hit.low, hit.high, frozenset(left), hit.score) if left else None


def _energy(fast: np.ndarray, length: int) -> list[Hit]:
    """Windows of `length` samples whose energy stands out, on a grid and on one half a window
    off.
    """
    hits = []
    for offset in (0, length // 2) if length > 1 else (0,):
        power, rest, peak, rare = [], [], [], []
        for y in fast:
            w = windows(y, length, offset)
            square = w * w
            total = square.sum(axis=1)
            power.append(total / length)
            peak.append(np.sqrt(square.max(axis=1)))
            rest.append(_without_spikes(square, total))
            rare.append(_more_than_spikes(square))
        data = (np.array(a) for a in (power, rest, peak, rare))
        hits += _judged(*data, length, offset)
    return hits


def _without_spikes(square: np.ndarray, total: np.ndarray) -> np.ndarray:
    """Mean square of each window without its largest sample, or sixteenth; of the louder windows
    alone, the others keep theirs.
    """
    length = square.shape[1]
    out = total / length
    if length == 1:
        return out
    drop = max(1, length // 16)
    loud = total > np.quantile(total, 0.9)
    largest = np.partition(square[loud], length - drop, axis=1)[:, length - drop :]
    out[loud] = (total[loud] - largest.sum(axis=1)) / (length - drop)
    return out


def _more_than_spikes(square: np.ndarray) -> np.ndarray:
    """Windows with more large samples than the record's, thrown in at random, would make."""
    large = (square > LARGE**2).sum(axis=1)
    share = large.sum() / square.size
    p = poisson.sf(np.arange(large.max() + 1) - 1, share * square.shape[1])
    return p[large] * len(square) < APART


def _judged(power, rest, peak, rare, length, offset) -> list[Hit]:
    k, count = power.shape
    stands = peak > STANDS
    mask = np.zeros(count, bool)
    member = np.zeros((k, count), bool)
    if length > 1:
        for c in range(k):
            value = np.log(np.maximum(rest[c], 1e-12))
            usual = np.log(max(np.median(rest[c]), 1e-12))
            limit = max(tail_threshold(value, ALONE), usual + np.log(LOUD))
            if length >= CROWD:  # in a short record knocks are the tail themselves
                limit = min(limit, usual + np.log(PLAIN))
            own = (value > limit) & stands[c] & rare[c]
            member[c] |= own
            mask |= own
    if k > 1:
        both = ranks.together(power, stands, ~mask)
        member |= stands & both
        mask |= both
        weak = ranks.with_others(power, stands, ~mask)
        member |= weak
        mask |= weak.any(axis=0)
        if length > 1:
            weak = ranks.faint(power, ~mask)
            member |= weak
            mask |= weak.any(axis=0)
    return [
        Hit(
            offset + int(j) * length,
            offset + (int(j) + 1) * length,
            frozenset(np.flatnonzero(member[:, j]).tolist()),
            float(peak[:, j].max()),
        )
        for j in np.flatnonzero(mask)
    ]


def _finding(hit: Hit, channels, names, time, rate) -> Finding:
    low, high = _edges(hit, channels, names, rate)
    members = tuple(names[c] for c in sorted(hit.channels)) or tuple(names)
    n = len(time)
    peaks = []
    for c in members:
        x = channels[c].x
        near = np.r_[x[max(0, low - 50) : low], x[high : high + 50]]
        usual = float(np.median(near)) if len(near) else float(np.median(x))
        part = x[low:high] - usual
        peaks.append(float(part[np.argmax(np.abs(part))]))
    start, stop = float(time[low]), float(time[min(high, n - 1)])
    duration = stop - start
    what = "A knock" if duration < KNOCK else "Handling or a shake"
    return Finding(
        "disturbance",
        members,
        start,
        stop,
        {"start": start, "duration": duration, "peak": peaks, "channels": list(members)},
        {"peak_over_noise": hit.score},
        f"{what} at {seconds(start)} s, {duration:.2g} s long, on {named(members)}, up to "
        f"{hit.score:.3g} times the noise.",
        "It is no error of the sensor; left in, it looks like spikes, heavy tails or a louder "
        "noise. It is masked.",
        np.arange(low, high),
    )


def _edges(hit: Hit, channels, names, rate) -> tuple[int, int]:
    """First row and the one after the last in which the fast part stands out, a margin added."""
    n = len(channels[names[0]].x)
    reach = max(4, int(0.3 * rate))
    low, high = max(0, hit.low - reach), min(n, hit.high + reach)
    loud = np.zeros(high - low, int)
    for c in hit.channels:
        # against the level of both sides: a moving mean has the knock in it
        ready, near = channels[names[c]], max(20, reach)
        sides = [ready.x[max(0, low - near) : low], ready.x[high : high + near]]
        level = [float(np.median(part)) for part in sides if len(part) >= 4]
        if level:
            line = np.linspace(level[0], level[-1], high - low)
            loud += np.abs(ready.x[low:high] - line) > LARGE * ready.sigma[low]
    if not loud.any():
        return _slow_edges(hit, channels, names, rate)
    first, last = _without_chance(loud, max(2, round(JOINED * rate)))
    margin = max(1, int(0.05 * rate))
    stop = _rung_down(hit, channels, names, rate, min(n, low + int(last) + 1))
    fast = max(0, low + int(first) - margin), min(n, stop + margin)
    if hit.slow:  # means over short blocks are blunt: only what is longer by more is theirs
        slow = _slow_edges(hit, channels, names, rate)
        if slow[1] - slow[0] > fast[1] - fast[0] + 1.5 * rate + 4:
            return slow
    return fast


def _rung_down(hit: Hit, channels, names, rate: float, stop: int) -> int:
    """The row up to which what follows a knock is louder than nearly all of the record: it rings
    below the level at which single samples stand out.
    """
    end = min(len(channels[names[0]].x), stop + int(RINGS * rate))
    out = stop
    for c in hit.channels:
        ready, at = channels[names[c]], stop
        y, size = ready.fast, ready.window
        while at + size <= end and np.mean(y[at : at + size] ** 2) > ready.usual:
            at += size
        out = max(out, at)
    return out


def _without_chance(loud: np.ndarray, reach: int) -> tuple[int, int]:
    """First and last row of which `loud` counts large samples, without the single ones that lie
    apart by more than `reach` rows: noise makes such in a long window.
    """
    rows = np.flatnonzero(loud)
    groups = np.split(rows, np.flatnonzero(np.diff(rows) > reach) + 1)
    crowd = [g for g in groups if loud[g].sum() > 1] or groups
    return int(crowd[0][0]), int(crowd[-1][-1])


def _slow_edges(hit: Hit, channels, names, rate) -> tuple[int, int]:
    """Rows from which to which short means are off the levels of both sides."""
    n = len(channels[names[0]].x)
    block = max(1, round(FINE * rate))
    low, high = max(0, hit.low - 2 * block), min(n, hit.high + 2 * block)
    k = (high - low) // block
    if k < 2:
        return hit.low, min(hit.high, n)
    off = np.zeros(k, bool)
    for c in hit.channels:
        x = channels[names[c]].x
        sides = [x[max(0, low - 40 * block) : low], x[high : high + 40 * block]]
        sides = [s[: len(s) // block * block].reshape(-1, block).mean(axis=1) for s in sides]
        sides = [s for s in sides if len(s) >= 4]
        if not sides:
            return hit.low, min(hit.high, n)
        scatter = max(1.4826 * np.median(np.abs(s - np.median(s))) for s in sides)
        mean = x[low : low + k * block].reshape(k, block).mean(axis=1)
        apart = np.min([np.abs(mean - np.median(s)) for s in sides], axis=0)
        off |= apart > STANDS * max(scatter, 1e-300)
    if not off.any():
        return hit.low, min(hit.high, n)
    first, last = np.flatnonzero(off)[[0, -1]]
    return max(0, low + (int(first) - 1) * block), min(n, low + (int(last) + 2) * block)
