"""Samples that repeat a frozen value."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import poisson

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.processes import Stuck as Stage

from .base import Effect, Finding


def runs(x: Array) -> tuple[np.ndarray, np.ndarray]:
    """Start and number of repeats of every run of equal neighbours."""
    start, stop = timing.runs(np.diff(x) == 0)
    return start, stop - start


def by_chance(x: Array) -> float:
    """How often two neighbours agree by chance: as often as samples further apart, more often as
    neighbours are correlated. `x` has shape (n,).
    """
    x = x - np.mean(x)
    lags = range(11, 11 + LAGS)
    far = sum(np.count_nonzero(x[k:] == x[:-k]) for k in lags) + 0.5
    near = np.median(np.abs(np.diff(x))) + 1e-300
    apart = np.median(np.abs(x[LAGS:] - x[:-LAGS]))
    return float(min(far / (LAGS * len(x)) * max(apart / near, 1.0), 0.5))


def _least(length: Array, chance: Array | None, n: int, rate: float) -> tuple[float, float]:
    """The length from which on most runs are frozen samples, given the runs of a simulation that
    only rounds, or the `rate` at which neighbours of a finer grid agree by chance, and how many
    repeats chance makes in runs of that length or more.

    The longest chance runs are geometric. There have to be so many more that chance makes them
    once in a hundred thousand records, and it has to account for three in ten at the most;
    infinite where no length is like that.
    """
    if chance is None or len(chance) == 0:
        more = rate / (1 - rate)
        at = np.arange(1, int(length.max(initial=0)) + 2)
        want = n * rate * rate ** (at - 1.0)
    else:
        far = float(np.quantile(chance, 0.99))
        more = max(float(np.mean(chance[chance >= far] - far)), 0.2)
        at = np.arange(int(far) + 1, max(int(length.max(initial=0)), int(far)) + 2)
        want = np.count_nonzero(chance >= far) * (more / (1 + more)) ** (at - far)
    got = len(length) - np.searchsorted(np.sort(length), at)
    sure = (want < 0.3 * got) & (poisson.sf(got - 1, want) < 1e-5)
    i = int(np.argmax(sure))
    return (at[i], float(want[i] * (at[i] + more))) if sure.any() else (np.inf, 0.0)


#: Distances at which samples are compared to learn how often they agree by chance.
LAGS = 30


class Stuck(Effect):
    name = "stuck"
    alters = True
    cause = (
        "The read-out returns an old value again: a bus that is too slow, a register that is "
        "not refreshed."
    )
    domain = "distribution"

    def of_differences(self, parameters: dict[str, Any]) -> bool:
        return True

    def detect(
        self, x: Array, clipped: Array, twin: Array | None, held: Stage | None
    ) -> Finding | None:
        """`clipped` marks samples at the ends of the range, `twin` is a rounded simulation of the
        noise (None where the grid is too fine to matter, and neighbours agree by chance as often as
        others do), `held` what the given model has of it: then the finding says so, since its
        samples tell nothing all the same.
        """
        start, length = runs(x)
        keep = ~clipped[start]
        start, length = start[keep], length[keep]
        seen = None if twin is None else runs(twin)[1]
        least, chance = _least(length, seen, len(x), by_chance(x))
        hit = length >= least
        start, length = start[hit], length[hit]
        repeats = int(length.sum())
        if repeats < 2 or len(start) < 1:
            return None
        typical = int(np.median(length))
        mask = np.zeros(len(x), bool)
        for s, k in zip(start, length):
            mask[s + 1 : s + 1 + k] = True
        fraction = max(repeats - chance, 1.0) / len(x)
        spread = 1.96 / np.sqrt(len(start))
        return Finding(
            self,
            Stage(fraction=fraction, length=typical),
            None,
            f"distribution of the samples: {len(start)} runs of equal values, the longest "
            f"{int(length.max()) + 1} samples",
            {
                "fraction": [fraction * max(0.0, 1 - spread), fraction * (1 + spread)],
                "length": [float(np.quantile(length, 0.025)), float(np.quantile(length, 0.975))],
            },
            mask=mask,
            held=held is not None and abs(repeats / len(x) / held.fraction - 1) < 0.5,
        )


EFFECTS = (Stuck(),)
