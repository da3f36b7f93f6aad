"""How often values agree by chance: equal neighbours and single values, from the grid and the noise
of the channel itself, and which agreements of several channels are more than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, poisson

#: log p below which that many coincidences are no chance (six channels, 64 patterns, many records).
IMPROBABLE = -18.0
#: How many times the number expected by chance must be there: most of what is marked is a fault.
MANIFOLD = 5.0
#: Samples over which the frequency of an event is taken as one.
BLOCK = 1000
#: Frequency up to which an event on one channel is rare.
RARE = 0.02


@dataclass(frozen=True)
class Levels:
    """The values that a channel takes.

    values : ndarray, shape (k,), ascending. index : ndarray, shape (n,), int, level of each sample,
    -1 where it is NaN. runs : ndarray, shape (k,), runs of equal neighbours at each level.
    """

    values: np.ndarray
    index: np.ndarray
    runs: np.ndarray

    @classmethod
    def of(cls, x: np.ndarray) -> Levels:
        """Of one channel, shape (n,)."""
        good = ~np.isnan(x)
        index = np.full(len(x), -1, np.int64)
        values, index[good] = np.unique(x[good], return_inverse=True)
        begin = np.r_[True, index[1:] != index[:-1]] & good
        return cls(values, index, np.bincount(index[begin], minlength=len(values)))

    @property
    def coarse(self) -> bool:
        """Whether values come again often enough to tell their grid."""
        return len(self.values) < 0.5 * self.runs.sum()

    def repeat_chance(self) -> float:
        """Probability that a sample equals the one before by chance.

        From how often neighbours differ by one and by two levels: of differences that are normal
        on a grid, p0 = p1 (p1 / p2)^(1/3). Without a grid from the density of small differences.
        """
        step = np.diff(self.index)
        step = np.abs(step[(self.index[1:] >= 0) & (self.index[:-1] >= 0)])
        total = max(len(step), 1)
        if len(self.values) < 3:
            return float(np.mean(step == 0)) if len(step) else 1.0
        moved = step[step > 0]
        if not self.coarse:
            return self._continuous(moved, total)
        one, two = np.count_nonzero(moved == 1) / 2, np.count_nonzero(moved == 2) / 2
        if one + two < 30:
            near = np.sort(moved)[: max(1, len(moved) // 10)]
            one = two = len(near) / (2.0 * max(1, near[-1]))
        p = one * np.cbrt(one / two) if two > 0 else total - 2 * one
        # on the coarsest grids: as often as two samples apart are equal, at the least
        share = np.bincount(self.index[self.index >= 0]) / total
        return float(np.clip(max(p / total, float(share @ share)), 1.0 / total, 1.0))

    def _continuous(self, moved: np.ndarray, total: int) -> float:
        """Of differences in levels: one value in `len(moved)` beside it, hardly ever the same."""
        gap = np.diff(self.values)
        x = self.values[self.index[self.index >= 0]]
        size = np.abs(np.diff(x))
        size = size[size > 0]
        if not len(size):
            return 1.0
        width = float(np.quantile(size, 0.05))
        least = float(gap.min())
        return float(np.clip(0.05 * least / (2.0 * width), 0.01 / total, 1.0))

    def value_chance(self, at: int, width: float) -> float:
        """Probability of the level `at` by the levels within `width` of it, of all samples.

        What half of the mass around it has, not the mean level: under printed digits finer than the
        converter's grid, few levels hold all samples.
        """
        width *= 1.0 + 1e-6  # a level at just that distance counts, on either side
        low, high = np.searchsorted(
            self.values, (self.values[at] - width, self.values[at] + width), side="left"
        )
        near = np.r_[self.runs[low:at], self.runs[at + 1 : high]]
        near = np.sort(near[near > 0])
        usual = 0.5
        if len(near):
            mass = np.cumsum(near)
            usual = float(near[np.searchsorted(mass, 0.5 * mass[-1])])
        return usual / float(max(1, self.runs.sum()))


def coincidences(
    events: np.ndarray, chance: np.ndarray, *, least: int = 1
) -> list[tuple[tuple[int, ...], np.ndarray, float]]:
    """Rows in which several channels show an event together more often than chance makes them.

    Parameters
    ----------
    events : ndarray, shape (channels, n), bool
    chance : ndarray, shape (channels,)
        Probability of the event in a sample, by chance, independent between channels.
    least : int
        Channels that must take part.

    Notes
    -----
    What several channels do by chance is taken from how often each does it on its own around that
    time: where the noise is low, a grid makes more neighbours agree.

    Returns
    -------
    list of (channels, rows, number of rows expected by chance), most rows first.
    """
    k, n = events.shape
    code = np.zeros(n, np.int64)
    for c in range(k):
        code |= events[c].astype(np.int64) << c
    count = np.bincount(code, minlength=1 << k)
    found = []
    size, local = _frequencies(events)
    # what the grid makes likely may be more than is there: others are absent as often as seen
    absent = 1 - np.clip(local, 1e-12, 1 - 1e-12)
    local = np.clip(np.maximum(local, chance[:, None]), 1e-12, 1 - 1e-12)
    for pattern in np.flatnonzero(count):
        bits = (pattern >> np.arange(k)) & 1
        if bits.sum() < least:
            continue
        if bits.sum() == 1:
            expected = n * float(chance[bits.argmax()])
        else:
            expected = float(size @ np.prod(np.where(bits[:, None], local, absent), axis=0))
        if count[pattern] > MANIFOLD * expected and (
            poisson.logsf(count[pattern] - 1, expected) < IMPROBABLE
            or (expected < 1e-6 and bits.sum() > 1)
        ):
            found.append((int(count[pattern]), int(pattern), expected))
    cores: list[list] = []
    for number, pattern, expected in sorted(found, reverse=True):
        home = next((c for c in cores if pattern & c[0] == c[0]), None)
        if home is None and bin(pattern).count("1") > 1:
            # a few that show on fewer channels, where another fault hides the rest
            home = next(
                (c for c in cores if pattern & c[0] == pattern and number < c[3] / 20), None
            )
        if home is None:  # a fault of its own; what chance adds to it is joined to it
            home = [pattern, [], 0.0, number]
            cores.append(home)
        home[1].append(pattern)
        home[2] += expected
    return [
        (
            tuple(np.flatnonzero((core >> np.arange(k)) & 1).tolist()),
            np.flatnonzero(np.isin(code, patterns)),
            expected,
        )
        for core, patterns, expected, _ in cores
    ]


def _frequencies(events: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples in each block, and how often each channel shows the event there (channels, blocks).

    Where that is rare, rows in which several show it are left out: they are what is asked about.
    """
    n = events.shape[1]
    edge = np.arange(0, max(n - BLOCK // 2, 1), BLOCK)
    size = np.diff(np.r_[edge, n])
    whole = np.add.reduceat(events, edge, axis=1, dtype=float) / size
    alone = events & (events.sum(axis=0) == 1)
    single = np.add.reduceat(alone, edge, axis=1, dtype=float) / size
    return size, np.where(events.mean(axis=1, keepdims=True) < RARE, single, whole)


def period_of(starts: np.ndarray) -> int | None:
    """Samples from one of the events at `starts` (sorted) to the next where they come evenly, some
    left out or a sample late; None where they do not.
    """
    if len(starts) < 6:
        return None
    step = np.diff(starts)
    values, count = np.unique(step, return_counts=True)
    for period in values[np.argsort(-count, kind="stable")][:3]:
        if period < 2:
            continue
        slack = 1 if period >= 10 else 0
        multiple = np.rint(step / period)
        fits = (np.abs(step - period * multiple) <= slack) & (multiple >= 1) & (multiple < 8)
        by_chance = min(1.0, (2 * slack + 1) / period)
        if (
            fits.mean() > 0.75
            and binom.logsf(fits.sum() - 1, len(step), by_chance) < IMPROBABLE / 2
        ):
            return int(period)
    return None


def run_starts(rows: np.ndarray) -> np.ndarray:
    """First rows of the runs of consecutive numbers in `rows` (sorted)."""
    return rows[np.r_[True, np.diff(rows) > 1]] if len(rows) else rows
