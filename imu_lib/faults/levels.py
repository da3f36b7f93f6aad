"""The channels made ready for the detectors of disturbances: bad rows bridged, the slow part taken
off, what is left divided by the noise of its surroundings; and window statistics on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import median_filter, uniform_filter1d

#: s of the blocks in which the noise level is taken, and blocks on each side that tell it.
BLOCK, REACH = 8.0, 5
#: Samples of such a block at the least and s over which the slow part is averaged.
LEAST_BLOCK, SLOW = 64, 1.0
#: s of the windows in which a knock rings down, and share of the record's windows that are as quiet
#: as what follows it.
WINDOW, USUAL = 0.1, 0.97
#: Windows in a part of the record of which the tail is taken, at the least, and parts at the most.
PART, MOST_PARTS = 200, 25


@dataclass(frozen=True)
class Prepared:
    """A channel for the detectors.

    x : ndarray, shape (n,), bad rows bridged. fast : its part above about 1 Hz over `sigma`,
    shape (n,). sigma : noise level of the surroundings, shape (n,), the signal's unit. bad : rows
    that were bridged, shape (n,), bool. window : samples in which a knock rings down.
    """

    x: np.ndarray
    fast: np.ndarray
    sigma: np.ndarray
    bad: np.ndarray
    window: int

    @cached_property
    def usual(self) -> float:
        """Mean square of `fast` that nearly all windows of the record stay below."""
        return float(np.quantile((windows(self.fast, self.window, 0) ** 2).mean(axis=1), USUAL))


def prepared(x: np.ndarray, bad: np.ndarray, rate: float, grid: float) -> Prepared:
    """One channel, shape (n,). `grid` is the step of its output, 0 where there is none."""
    given, x = x, bridged(x, bad)
    n = len(x)
    width = int(min(max(16, round(SLOW * rate)), max(4, n // 8)))
    # reflected: a single wild sample at an end must not be repeated beyond it
    residual = x - uniform_filter1d(x, width, mode="reflect")
    block = int(min(max(LEAST_BLOCK, round(BLOCK * rate)), max(8, n // 6)))
    k = max(1, n // block)
    size = np.abs(residual[: k * block]).reshape(k, block)
    # the mean size, not the median one: on a coarse grid most samples are alike
    good = ~(bad[: k * block] | np.isnan(given[: k * block])).reshape(k, block)
    count = good.sum(axis=1)
    level = np.sqrt(np.pi / 2) * (size * good).sum(axis=1) / np.maximum(count, 1)
    full = count >= 0.25 * block
    if full.any():  # what is bridged tells no noise
        level = np.interp(np.arange(k), np.flatnonzero(full), level[full])
    before, after = sides(level, REACH)
    wide = np.maximum(before, after)
    # the grid hides a scatter below it
    wide = np.maximum(wide, 0.3 * grid)
    floor = float(np.median(wide))
    wide = np.maximum(wide, 0.05 * floor if floor > 0 else 1e-300)
    sigma = np.repeat(wide, block)
    sigma = np.r_[sigma, np.full(n - len(sigma), wide[-1])]
    return Prepared(x, residual / sigma, sigma, bad, max(4, round(WINDOW * rate)))


def bridged(x: np.ndarray, bad: np.ndarray) -> np.ndarray:
    """Bad samples replaced by straight lines between their neighbours."""
    bad = bad | np.isnan(x)
    if not bad.any():
        return x
    good = np.flatnonzero(~bad)
    if not len(good):
        return np.zeros(len(x))
    out = x.copy()
    out[bad] = np.interp(np.flatnonzero(bad), good, x[good])
    return out


def sides(values: np.ndarray, reach: int, guard: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Medians of the `reach` values before each, and of those after; of as many as there are near
    an end, and the other side's at it.

    `guard` values next to each are left out.
    """
    n = len(values)
    reach = max(1, min(reach, (n - 1) // 2))
    if n < 3:
        whole = np.full(n, np.median(values))
        return whole, whole
    middle = median_filter(values, size=reach, mode="nearest")
    # entry i of `middle` is the median of i - reach//2 .. i - reach//2 + reach - 1
    first = np.arange(n) - reach - guard  # first value of the side before
    before = middle[np.clip(first + reach // 2, 0, n - 1)]
    last = np.arange(n) + 1 + guard
    after = middle[np.clip(last + reach // 2, 0, n - 1)]
    for j in range(min(reach + guard, n)):  # as many as there are
        before[j] = np.median(values[: j - guard]) if j > guard else np.nan
        i = n - 1 - j
        after[i] = np.median(values[i + 1 + guard :]) if i + 1 + guard < n else np.nan
    return np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)


def windows(y: np.ndarray, length: int, offset: int) -> np.ndarray:
    """The whole windows of `length` samples from `offset` on, shape (windows, length)."""
    k = (len(y) - offset) // length
    return y[offset : offset + k * length].reshape(k, length)


def tail_threshold(values: np.ndarray, alarms: float) -> float:
    """The value that noise like the bulk exceeds `alarms` times in all of `values`, in their order.

    The tail between the 97 and 99.5 % quantiles, taken as exponential: it is heavier than that of
    any normal noise, and as heavy as the noise's own where that is. Of parts of the record the
    usual one tells: disturbances come together in a few.
    """
    if len(values) < 20:
        return np.inf
    parts = int(np.clip(len(values) // PART, 1, MOST_PARTS))
    k = len(values) // parts
    low, high = np.quantile(values[: parts * k].reshape(parts, k), (0.97, 0.995), axis=1)
    slope = max(float(np.median(high - low)) / np.log(0.03 / 0.005), 1e-3)
    return float(np.median(high)) + slope * np.log(0.005 * len(values) / alarms)
