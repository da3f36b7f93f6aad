"""A shake that comes and goes within a minute or two and is no line: a train, a lorry, somebody who
walks by. Too faint for single windows to stand out, it is the same stretch of time on several
channels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.faults import faint_shake
from imu_lib.faults.finding import Finding
from imu_lib.faults.levels import Prepared

#: s and samples of a block at the least, and blocks at the most.
BLOCK, SAMPLES, BLOCKS = 1.0, 48, 600
#: s that it lasts at the least and at the most, and share of the record.
SHORT, LONG, SHARE = 4.0, 120.0, 0.3
#: Gain in log-likelihood of all channels and of each of two, for some 10^5 stretches looked at.
GAIN, EACH = 60.0, 12.0
#: Share of the longest stretch, and of the record from its ends, that it may reach to.
FULL, EDGE = 0.9, 0.04
#: Scatter of the level in the rest of the record over that of a steady one, in variances.
STEADY = 3.0
#: Noise levels at which samples are cut down.
LARGE = 4.5
#: Bins of the spectrum, and how many hold half of what is louder: fewer are a line.
BINS, WIDE = 64, 4


def find(
    channels: dict[str, Prepared], touched: Sequence[Finding], time: np.ndarray, rate: float
) -> list[Finding]:
    """At most one a record.

    Parameters
    ----------
    channels : dict
        Name -> channel made ready.
    touched : sequence of Finding
        Disturbances that are known: their rows are left out.
    time : ndarray, shape (n,), s
    rate : float, Hz
    """
    n = len(time)
    size = max(round(BLOCK * rate), SAMPLES, n // BLOCKS)
    k = n // size
    if k < 40 or len(channels) < 2:
        return []
    out = np.zeros(n, bool)
    for item in touched:
        if len(item.rows):
            out[max(0, item.rows[0] - size // 2) : item.rows[-1] + size // 2] = True
    energy, dof = zip(*(_energy(ready, out, size, k) for ready in channels.values()))
    low, high = _stretches(k, size / rate, n / rate)
    if not len(low):
        return []
    gains = np.array([_gains(e, d, low, high) for e, d in zip(energy, dof)])
    best = int(np.argmax(gains.sum(axis=0)))
    inside = np.zeros(k, bool)
    inside[low[best] : high[best]] = True
    felt = [
        i
        for i, (e, d) in enumerate(zip(energy, dof))
        if gains[i, best] > EACH and _steady(e[~inside], d[~inside])
    ]
    near_end = low[best] < EDGE * k or high[best] > (1.0 - EDGE) * k
    if near_end or (high - low)[best] > FULL * (high - low).max():
        return []  # it would be longer, or was there before the record: it does not come and go
    part = slice(low[best] * size, high[best] * size)
    # about a knock that several felt one channel is enough
    least = 1 if out[part].any() else 2
    if len(felt) < least or gains[felt, best].sum() < GAIN:
        return []
    names = list(channels)
    loudest = names[max(felt, key=lambda i: gains[i, best])]
    if not _wide(channels[loudest].fast, part):
        return []
    members = tuple(names[i] for i in felt)
    span = float(time[part.start]), float(time[min(part.stop, n - 1)])
    evidence = {"gain": float(gains[felt, best].sum())}
    looks = "a noise level that wanders"
    return [faint_shake.finding(members, channels, part, span, evidence, looks)]


def _energy(ready: Prepared, out: np.ndarray, size: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean square in blocks over that of the record, and independent samples in each."""
    good = ~(ready.bad | out)[: k * size].reshape(k, size)
    # the level of the record, not of the surroundings: these have it in them
    y = ready.fast * ready.sigma
    # single large samples are not what passes
    square = np.minimum(y[: k * size].reshape(k, size) ** 2, LARGE**2 * np.median(ready.sigma) ** 2)
    count = good.sum(axis=1)
    e = np.where(good, square, 0.0).sum(axis=1) / np.maximum(count, 1)
    usual = np.median(e[count > 0]) if (count > 0).any() else 1.0
    near = e[(count > 0.5 * size)] / max(usual, 1e-300)
    # what neighbouring samples have in common, and their tails, in the scatter of quiet blocks
    spread = 1.4826 * np.median(np.abs(near - np.median(near))) if len(near) else 1.0
    free = min(size / 2.0, 1.0 / max(spread, 1e-6) ** 2)
    return e / max(usual, 1e-300), free * count / size


def _stretches(k: int, block: float, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """First and one behind the last block of the stretches looked at, within the record."""
    low, high = np.triu_indices(k + 1, 1)
    length = (high - low) * block
    keep = (length >= SHORT) & (length <= min(LONG, SHARE * duration)) & (low > 1) & (high < k - 1)
    return low[keep], high[keep]


def _gains(e: np.ndarray, dof: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Gain of each stretch in which the level is another one and higher."""
    total = np.r_[0.0, np.cumsum(e * dof)]
    count = np.r_[0.0, np.cumsum(dof)]
    inside, seen = total[high] - total[low], count[high] - count[low]
    on = inside / np.maximum(seen, 1e-9)
    off = (total[-1] - inside) / np.maximum(count[-1] - seen, 1e-9)
    mean = total[-1] / count[-1]
    gain = 0.5 * (
        count[-1] * np.log(mean)
        - seen * np.log(np.maximum(on, 1e-12))
        - (count[-1] - seen) * np.log(np.maximum(off, 1e-12))
    )
    return np.where(on > off, gain, 0.0)


def _steady(e: np.ndarray, dof: np.ndarray) -> bool:
    """Whether a channel keeps its level in the rest of the record."""
    part = e[dof > 0]
    if len(part) < 20:
        return False
    mean = float(part.mean())
    if not 0.0 < mean < np.inf:  # nothing but one value, of which no noise was left to judge by
        return False
    few = np.array([p.mean() / mean for p in np.array_split(part, 20)])
    chance = 1.0 / max(float(np.mean(dof[dof > 0])) * len(part) / 20.0, 1e-9)
    return bool(np.var(few) < STEADY * chance)


def _wide(y: np.ndarray, part: slice) -> bool:
    """Whether what is louder fills more of the spectrum than a line does."""
    inside, outside = (_spectrum(x) for x in (y[part], np.r_[y[: part.start], y[part.stop :]]))
    more = np.sort(np.maximum(inside - outside, 0.0))[::-1]
    if not more.sum() > 0:
        return False
    return bool(np.searchsorted(np.cumsum(more) / more.sum(), 0.5) + 1 >= WIDE)


def _spectrum(x: np.ndarray) -> np.ndarray:
    """Mean power in the bins of short segments."""
    m = 2 * BINS
    window = np.sin(np.pi * (np.arange(m) + 0.5) / m)
    parts = x[: len(x) // m * m].reshape(-1, m)
    return np.mean(np.abs(np.fft.rfft(parts * window, axis=1)) ** 2, axis=0)[1:]
