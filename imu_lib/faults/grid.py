"""The grid on which a converter puts its values."""

from __future__ import annotations

import numpy as np


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
