"""Tails of noise that is rounded to steps about as wide as itself: how often each level is met."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr, stdtr

from imu_lib.arrays import Array
from imu_lib.processes import HeavyTails

#: Of parameters.
Function = Callable[[Array], float]
#: Groups of samples by their slow part, and by the level of the noise where that changes.
GROUPS, SCALES = 10, 4
#: Freedom at the least, without and with a lean, and lean at the most.
LEAST, LEAST_LEANING, MOST = 2.0, 4.2, 1.0


@dataclass(frozen=True)
class LevelTails:
    """Tails of the noise before the rounding.

    Attributes
    ----------
    gain : float
        Log-likelihood over normal noise.
    tails : HeavyTails
    reach, spread : float
        Standard deviations of the logarithm of the freedom, and of the lean.
    sd : float
        Standard deviation of the noise, in steps.
    """

    gain: float
    tails: HeavyTails
    reach: float
    spread: float
    sd: float

    def with_intervals(self) -> tuple[HeavyTails, dict[str, list[float]]]:
        """The tails, and the 95 % intervals of their parameters."""
        tails, reach, wide = self.tails, float(np.exp(1.96 * self.reach)), 1.96 * self.spread
        intervals = {"freedom": [tails.freedom / reach, tails.freedom * reach]}
        if tails.lean:
            intervals["lean"] = [tails.lean - wide, tails.lean + wide]
        return tails, intervals


@dataclass(frozen=True)
class Levels:
    """How often each level is met: `count`, shape (groups, levels), of samples whose slow part is
    `middle`, shape (groups,), in steps from the first level, and whose noise has the `scale`,
    shape (groups,).
    """

    count: Array
    middle: Array
    scale: Array

    @classmethod
    def of(
        cls, x: Array, grid: tuple[float, float], slow: Array, scale: Array | float = 1.0
    ) -> Levels:
        """Of samples `x`, shape (n,), on a `grid` (step, offset), about their `slow` part (n,)."""
        step, offset = grid
        whole = np.rint((x - offset) / step).astype(np.int64)
        first = int(whole.min())
        middle, scale = (slow - offset) / step - first, np.broadcast_to(scale, x.shape)
        group = _quantile(middle, GROUPS) * SCALES + _quantile(scale, SCALES)
        count = np.zeros((GROUPS * SCALES, int(whole.max()) - first + 1))
        np.add.at(count, (group, whole - first), 1.0)
        many = count.sum(axis=1)
        seen = many > 0
        means = [np.bincount(group, v, len(many))[seen] / many[seen] for v in (middle, scale)]
        return cls(count[seen], *means)

    def log_likelihood(self, sd: float, tails: HeavyTails | None, part: float = 1.0) -> float:
        """Of noise of standard deviation `sd`, in steps, a `part` of whose variance has the
        `tails` and whose rest is normal.
        """
        edge = np.arange(self.count.shape[1] - 1) + 0.5
        u = (edge - self.middle[:, None]) / (sd * self.scale[:, None])
        if tails is None:
            below = ndtr(u)
        elif tails.lean or part < 1.0:
            below = tails.below(u.ravel(), part).reshape(u.shape)
        else:
            below = stdtr(tails.freedom, u * np.sqrt(tails.freedom / (tails.freedom - 2.0)))
        ends = np.zeros((len(u), 1))
        share = np.diff(np.hstack([ends, below, ends + 1.0]), axis=1)
        return float(np.sum(self.count * np.log(np.maximum(share, 1e-12))))

    def tails(self, worth: float, part: float = 1.0) -> LevelTails:
        """The likeliest tails of a `part` of the noise; with a lean where that gains more than
        `worth`.
        """
        at = np.arange(self.count.shape[1])
        square = np.sum(self.count * (at - self.middle[:, None]) ** 2 / self.scale[:, None] ** 2)
        start = 0.5 * np.log(max(square / self.count.sum() - 1.0 / 12.0, 0.1))
        normal = _climbed(lambda v: self.log_likelihood(np.exp(v[0]), None), [start])

        def even(v: Array) -> float:
            return self.log_likelihood(np.exp(v[0]), HeavyTails(LEAST + np.exp(v[1])), part)

        def leaning(v: Array) -> float:
            tails = HeavyTails(LEAST_LEANING + np.exp(v[1]), float(np.clip(v[2], -MOST, MOST)))
            return self.log_likelihood(np.exp(v[0]), tails, part)

        best = _climbed(even, [normal[0][0], np.log(6.0)])
        freedom = LEAST + float(np.exp(best[0][1]))
        reach = _spread(even, best, 1) * (freedom - LEAST) / freedom
        tails, spread = HeavyTails(freedom), 0.0
        if freedom > LEAST_LEANING:
            beyond = np.log(max(freedom - LEAST_LEANING, 0.5))
            other = _climbed(leaning, [best[0][0], beyond, 0.1])
            if other[1] > best[1] + worth and abs(other[0][2]) < MOST:
                best = other
                tails = HeavyTails(LEAST_LEANING + np.exp(best[0][1]), float(best[0][2]))
                spread = _spread(leaning, best, 2)
        return LevelTails(
            best[1] - normal[1], tails, float(reach), spread, float(np.exp(best[0][0]))
        )


def _quantile(values: Array, groups: int) -> Array:
    """Number of the quantile that each of `values` (n,) lies in; 0 where they are all alike."""
    if not np.ptp(values) > 0:
        return np.zeros(len(values), int)
    return np.searchsorted(np.quantile(values, np.arange(1, groups) / groups), values)


def _climbed(log_likelihood: Function, start: list[float]) -> tuple[Array, float]:
    """(parameters, log-likelihood) of the maximum from `start` on."""
    found = minimize(
        lambda v: -log_likelihood(v),
        np.asarray(start, float),
        method="Nelder-Mead",
        options={"xatol": 1e-3, "fatol": 1e-2, "maxiter": 400},
    )
    return found.x, -float(found.fun)


def _spread(
    log_likelihood: Callable[[Array], float], best: tuple[Array, float], which: int
) -> float:
    """Standard deviation of a parameter at the maximum, the others held."""
    h = np.zeros(len(best[0]))
    h[which] = 0.05
    curve = 2 * best[1] - log_likelihood(best[0] + h) - log_likelihood(best[0] - h)
    return float(0.05 / np.sqrt(max(curve, 1e-4)))
