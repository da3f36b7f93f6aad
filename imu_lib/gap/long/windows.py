"""Which windows of a long record are like the others, and which are to be looked at in full."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.long.scan import SEGMENT, Scan

#: Log-likelihood beyond the logarithm of the number of places at which a window is not like the
#: others.
UNLIKE = 7.0
#: Bands of the spectrum, and its first ordinate that counts: what is slower belongs to the means.
BANDS, FIRST = 24, 4
#: Share of the typical density below which a difference counts for nothing.
DEEP = 1e-2
#: Median of half a chi-square of one degree of freedom.
MEDIAN = 0.2275


@dataclass(frozen=True)
class Stretch:
    """Windows `first` ... `last` that are unlike the others on `channels`; `worst` shows it best,
    in `what`.
    """

    first: int
    last: int
    worst: int
    gain: float
    channels: tuple[str, ...]
    what: str


def excess(scan: Scan) -> tuple[np.ndarray, list[str]]:
    """How unlike the others each window of a channel is, in log-likelihood, shape (windows,), and
    in what.
    """
    segments = scan.window // SEGMENT
    typical = np.maximum(np.median(scan.density, axis=0), 1e-300)[FIRST:]
    floor = DEEP * np.median(typical)  # in a filter's stop band whatever is left stands out
    ratio = (scan.density[:, FIRST:] + floor) / (typical + floor)
    ordinate = np.where(ratio > 1, segments * (ratio - 1 - np.log(ratio)), 0.0)
    edge = np.unique(np.round(np.geomspace(1, ratio.shape[1], BANDS)).astype(int) - 1)
    wide = np.diff(np.append(edge, ratio.shape[1]))
    band = np.add.reduceat(ratio, edge, axis=1) / wide
    band = segments * wide * (band - 1 - np.log(band))
    # a level that moves a little all the time is no reason to look at every window
    lively = max(float(np.median(band)) / MEDIAN, 1.0)
    gains = np.column_stack(
        [ordinate.max(axis=1), band.max(axis=1) / lively, _counts(scan.alone), _counts(scan.same)]
    )
    named = ("a line", "the level of the spectrum", "single samples", "repeated samples")
    at = gains.argmax(axis=1)
    return gains.max(axis=1), [named[i] for i in at]


def _counts(n: Array) -> Array:
    """Log-likelihood by which counts exceed their median, with the scatter that they have."""
    usual = max(float(np.median(n)), 0.5)
    spread = 1.4826 * float(np.median(np.abs(n - np.median(n)))) ** 2
    lively = max(spread / usual, 1.0)
    return np.where(n > usual, n * np.log(np.maximum(n, 1e-9) / usual) - (n - usual), 0.0) / lively


def limit(scans: list[Scan]) -> float:
    """Log-likelihood from which on a window is unlike the others: chance reaches it in one record
    of a thousand.
    """
    return UNLIKE + float(np.log(sum(s.density.size for s in scans)))


def typical_run(scores: Array, count: int) -> int:
    """First of the `count` neighbouring windows that are most like the rest.

    scores : ndarray, shape (channels, windows)
    """
    total = np.minimum(scores, 1e6).sum(axis=0)
    sums = np.convolve(total, np.ones(count), "valid")
    return int(np.argmin(sums))


def stretches(scans: list[Scan]) -> tuple[list[Stretch], np.ndarray]:
    """Stretches of windows that are unlike the others, the worst first, and the scores of all,
    shape (channels, windows).
    """
    scores, what = zip(*(excess(s) for s in scans))
    scores = np.array(scores)
    left = np.where(scores > limit(scans), scores, 0.0)
    out = []
    while left.any():
        channel, worst = np.unravel_index(int(left.argmax()), left.shape)
        a, b = worst, worst + 1
        while a > 0 and left[channel, a - 1] > 0:
            a -= 1
        while b < left.shape[1] and left[channel, b] > 0:
            b += 1
        on = np.flatnonzero((left[:, a:b] > 0).mean(axis=1) >= 0.5)
        named = tuple(scans[i].name for i in on)
        gain, seen = float(left[channel, worst]), what[channel][worst]
        out.append(Stretch(int(a), int(b) - 1, int(worst), gain, named, seen))
        left[on, a:b] = 0.0
    return out, scores
