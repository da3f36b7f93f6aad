"""An axis that is another axis again: the logger wrote one measurement into two columns."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from imu_lib.faults.finding import Finding

#: Share of the changes from sample to sample that are alike, and samples of them that are looked
#: at.
ALIKE, SAMPLES = 0.98, 50_000
#: Deviation over the size of the changes up to which two are alike: digits that were cut off.
DIGITS = 1e-6


def find(channels: dict[str, np.ndarray], time: np.ndarray) -> list[Finding]:
    """Channels that repeat an earlier one, sample by sample, perhaps with the other sign."""
    found, copies = [], set()
    for first, second in combinations(channels, 2):
        if first in copies or second in copies:
            continue
        sign = _sign(channels[first][:SAMPLES], channels[second][:SAMPLES])
        if sign:
            copies.add(second)
            found.append(_finding(first, second, sign, time))
    return found


def _sign(a, b) -> int:
    """1 or -1 where the changes of `b` are those of `a`, or those with the other sign; else 0."""
    a, b = np.diff(a), np.diff(b)
    moves = np.isfinite(a) & np.isfinite(b) & ((a != 0) | (b != 0))
    if moves.sum() < 100:
        return 0
    a, b = a[moves], b[moves]
    size = DIGITS * float(np.median(np.abs(a)) + np.median(np.abs(b)))
    for sign in (1, -1):
        if np.mean(np.abs(b - sign * a) <= size) > ALIKE:
            return sign
    return 0


def _finding(first: str, second: str, sign: int, time) -> Finding:
    text = "repeats" if sign > 0 else "is the negative of"
    return Finding(
        "copied",
        (second,),
        float(time[0]),
        float(time[-1]),
        {"of": first, "sign": sign},
        {"share": ALIKE},
        f"{second} {text} {first} sample by sample: one measurement in two columns.",
        "One of the two was not measured; their noise is in common by the logger's making. The "
        "later one is left out.",
    )
