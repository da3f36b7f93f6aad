"""What each channel shows: its level, its scatter, its grid, its ends, its noise."""

from __future__ import annotations

import numpy as np

from imu_lib.faults import Finding
from imu_lib.faults.grid import resolution
from imu_lib.faults.standing import stands
from imu_lib.health.result import Channel
from imu_lib.readers import plausibility

#: Levels of a grid from which its ends can be told from the tails of the noise.
LEAST_LEVELS = 10


def of_channel(name: str, x: np.ndarray, rate: float, faults: tuple[Finding, ...]) -> Channel:
    """One channel, samples that the faults name left out of its figures."""
    nan = int(np.isnan(x).sum())
    clean = x.copy()
    frozen = longest = 0
    for f in faults:
        if name in f.channels and f.kind in ("dropout", "stuck"):
            clean[f.rows] = np.nan
        if name in f.channels and (f.kind == "stuck" or stands(f)):
            frozen += len(f.rows)
            longest = max(longest, int(f.evidence["longest"]) + 1)
        if name in f.channels and f.kind == "constant":
            frozen = longest = len(x)
    good = clean[~np.isnan(clean)]
    if not good.size:
        good = x[~np.isnan(x)]
    return Channel(
        float(good.mean()),
        float(good.std()),
        float(good.min()),
        float(good.max()),
        nan,
        resolution(good),
        _saturated(good),
        frozen,
        longest,
        plausibility._noise_density(good[:, None], rate) if len(good) > 10 else 0.0,
    )


def _saturated(good: np.ndarray) -> int:
    """Samples at an end of the range where they pile up: noise thins out towards its extremes."""
    low, high = float(good.min()), float(good.max())
    saturated = 0
    if high > low:
        tiny = 1e-9 * max(abs(low), abs(high))
        for end, inner in ((high, good[good < high - tiny]), (low, good[good > low + tiny])):
            count = int((np.abs(good - end) <= tiny).sum())
            level, times = np.unique(inner, return_counts=True)
            if len(level) < LEAST_LEVELS:
                continue
            # on a grid the neighbours tell what the tail holds, to its own scatter
            beside = 2 * int((times[-3:] if end == high else times[:3]).max())
            if count >= 5 and count > beside + 4 * np.sqrt(beside):
                saturated += count
    return saturated
