"""Somebody walks by: a row of small knocks in a rhythm. Each is too faint to be found alone; what
they add to the energy of all channels comes and goes as steps do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import gammainccinv

from imu_lib.faults import faint_shake, ranks
from imu_lib.faults.finding import Finding
from imu_lib.faults.levels import Prepared, windows

#: s of the blocks of energy, and blocks a second from which on they show steps.
BLOCK, LEAST_RATE = 0.08, 8.0
#: Steps a second, and how fine they are told apart.
SLOWEST, FASTEST, FINE = 1.2, 2.8, 0.03
#: Multiples of the rhythm in the row of short knocks.
MULTIPLES = 3
#: s that a walk is heard, and between two beginnings that are tried.
LENGTHS, APART = (4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 28.0), 1.0
#: Chance alarms in a record; walks in it at the most.
ALARMS, MOST = 1e-5, 5
#: Largest contribution of a channel to the energy of a block: what one shows alone is no step.
CUT = 7.0
#: Standard deviations that a block counts for at the most: one knock has no rhythm.
HIGHEST = 4.0
#: s about a knock in which the moving mean has it.
ABOUT = 0.6
#: Share of the other stretches of a record with that rhythm from which on it is no walk but
#: something that runs, and the power, over chance, that they have by then.
RUNS, POWER = 0.25, 10.0
#: Share of blocks within a walk in which a channel that felt it is louder than usual, over chance.
FELT = 3.0


def find(
    channels: dict[str, Prepared], touched: Sequence[Finding], time: np.ndarray, rate: float
) -> list[Finding]:
    """Walks that are too faint for their single steps to be found.

    Parameters
    ----------
    channels : dict
        Name -> channel made ready.
    touched : sequence of Finding
        Disturbances that are known: what is about them counts as usual.
    time : ndarray, shape (n,), s
    rate : float, Hz
    """
    size = max(1, round(BLOCK * rate))
    per_second = rate / size
    if per_second < LEAST_RATE or len(channels) < ranks.LEAST:
        return []
    odds = _odds(channels, touched, size)
    if odds is None:
        return []
    total = odds.sum(axis=0)
    found: list[Finding] = []
    while len(found) < MOST:
        best = _best(total, per_second)
        if best is None:
            break
        low, high, rhythm = best
        found.append(_finding(channels, odds, (low, high), rhythm, size, time))
        total[max(0, low - size) : high + size] = np.median(total)
    return found


def _odds(
    channels: dict[str, Prepared], touched: Sequence[Finding], size: int
) -> np.ndarray | None:
    """How rare the energy of each block is on the channels that are witnesses of their own, shape
    (channels, blocks); None where they are too few.
    """
    power = np.stack([(windows(c.fast, size, 0) ** 2).mean(axis=1) for c in channels.values()])
    quiet = np.ones(power.shape[1], bool)
    for item in touched:
        if len(item.rows):
            about = round(ABOUT / BLOCK)
            quiet[max(0, item.rows[0] // size - about) : item.rows[-1] // size + about + 1] = False
    if quiet.sum() < ranks.FEWEST:
        return None
    own = ranks.apart(power[:, quiet])
    if len(own) < ranks.LEAST:
        return None
    odds = np.stack([np.minimum(ranks.rarity(p, quiet), CUT) for p in power])
    odds[:, ~quiet] = np.median(odds)
    odds[[c for c in range(len(power)) if c not in own]] = 0.0
    return odds


def _best(total: np.ndarray, per_second: float) -> tuple[int, int, float] | None:
    """(first block, one behind the last, steps a second) of the clearest walk, or None."""
    y = np.minimum((total - total.mean()) / max(float(total.std()), 1e-300), HIGHEST)
    k, step = len(y), max(1, round(APART * per_second))
    rhythms = np.arange(SLOWEST, FASTEST, FINE)
    lengths = [round(s * per_second / step) for s in LENGTHS]
    count = k // step
    if count < 3 * lengths[0]:
        return None
    at = np.arange(k) / per_second
    best, out, trials = 0.0, None, 0
    power = {}
    for rhythm in rhythms:
        sums = np.stack([_sums(y, at, m * rhythm, step) for m in range(1, MULTIPLES + 1)])
        for length in lengths:
            if 3 * length > count:
                continue
            part = np.abs(sums[:, length:] - sums[:, :-length]) ** 2 / (length * step)
            power[rhythm, length] = both = part.sum(axis=0)
            trials += len(both)
            i = int(np.argmax(both))
            if both[i] > best:
                best, out = float(both[i]), (i, length, rhythm)
    if out is None or best < gammainccinv(MULTIPLES, ALARMS / trials):
        return None
    i, length, rhythm = out
    same = power[rhythm, lengths[0]]
    other = np.r_[same[: max(0, i - lengths[0])], same[i + length :]]
    if len(other) and np.mean(other > POWER) > RUNS:
        return None
    return i * step, (i + length) * step, float(rhythm)


def _sums(y: np.ndarray, at: np.ndarray, frequency: float, step: int) -> np.ndarray:
    """Running sums of `y` against an oscillation, every `step` blocks, one more than there are."""
    turned = np.cumsum(y * np.exp(-2j * np.pi * frequency * at))
    return np.r_[0.0, turned[step - 1 :: step]]


def _finding(
    channels: dict[str, Prepared],
    odds: np.ndarray,
    span: tuple[int, int],
    rhythm: float,
    size: int,
    time: np.ndarray,
) -> Finding:
    low, high = span
    names = list(channels)
    inside = odds[:, low:high]
    # sums of exponentials, one of mean and variance one a block
    felt = (inside.mean(axis=1) - 1.0) * np.sqrt(high - low)
    members = tuple(c for c, f in zip(names, felt) if f > FELT)
    if not members:
        members = (names[int(np.argmax(felt))],)
    part = slice(low * size, min(high * size, len(time)))
    span_s = float(time[part.start]), float(time[part.stop - 1])
    looks = "heavy tails or a noise level that wanders"
    return faint_shake.finding(members, channels, part, span_s, {"rhythm": rhythm}, looks)
