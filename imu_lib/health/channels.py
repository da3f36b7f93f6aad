"""What each channel shows: its level, its scatter, its grid, its ends, its noise."""

from __future__ import annotations

import numpy as np

from imu_lib.faults import Finding
from imu_lib.health.result import Channel
from imu_lib.readers import plausibility

#: Levels of a grid from which its ends can be told from the tails of the noise.
LEAST_LEVELS = 10


def resolution(x: np.ndarray) -> float | None:
    """Step of the grid that the values of `x` (n,) lie on, None where they lie on none."""
    x = x[:200_000]
    x = x[~np.isnan(x)]
    level, count = np.unique(x, return_counts=True)
    if len(level) < 2 or len(level) > 0.5 * len(x):
        return None
    often = level[count > 2]
    if len(often) > 1 and count[count > 2].sum() > 0.95 * len(x):
        level = often  # a few bridged or spiked samples off the grid are no finer grid
    step = np.diff(level)
    # levels apart by float32 rounding are one
    step = step[step > 2e-6 * max(abs(level[0]), abs(level[-1]), level[-1] - level[0])]
    if not step.size:
        return None
    unit = float(np.quantile(step, 0.02))
    times = np.rint(step / unit)
    if (np.abs(step / unit - times) < 0.1 * np.maximum(1, 0.1 * times)).mean() < 0.95:
        return None
    return float(step.sum() / times.sum())


def of_channel(name: str, x: np.ndarray, rate: float, faults: tuple[Finding, ...]) -> Channel:
    """One channel, samples that the faults name left out of its figures."""
    nan = int(np.isnan(x).sum())
    clean = x.copy()
    frozen = longest = 0
    for f in faults:
        if name in f.channels and f.kind in ("dropout", "stuck"):
            clean[f.rows] = np.nan
        if name in f.channels and f.kind == "stuck":
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
