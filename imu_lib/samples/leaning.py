"""Tails that are longer to one side than to the other: which, and by how much."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from imu_lib.arrays import Array
from imu_lib.processes import HeavyTails

#: Skewness in standard deviations of normal samples from which on it is looked for.
UNEVEN = 4.0
#: Width of a class of samples, in standard deviations, within which one value stands for all.
CLASS = 0.05
#: Freedom at the least beyond which the skewness of the samples is that of the distribution.
LEAST = 4.2
#: Lean at the most: a distribution that is bent as a whole has twenty times as much.
MOST = 1.0
#: Classes of the tails whose counts the fit has to foresee, in standard deviations, and twice the
#: log-likelihood that it may lose against their own means, for each: of three recorded
#: accelerometers it is 2 to 3, of clicks of one height 10 to 20.
EDGES = np.array([-6, -5, -4.5, -4, -3.5, -3, -2.5, 2.5, 3, 3.5, 4, 4.5, 5, 6, 7, 8, 10], float)
WORST = 4.0


def leaning(y: Array, freedom: float) -> tuple[float, HeavyTails, float] | None:
    """(gain over tails that do not lean, the tails that do, standard deviation of their lean) that
    are likeliest for samples `y` (n,), from Student's `freedom` on; None where they are even, or
    no such tails.
    """
    u = (y - np.mean(y)) / np.std(y)
    skew = float(np.mean(u**3))
    if abs(skew) < UNEVEN * np.sqrt(6.0 / len(u)) or freedom < LEAST:
        return None
    value, count = np.unique(np.rint(u / CLASS), return_counts=True)
    value = value * CLASS

    def loss(v: Array) -> float:
        tails = HeavyTails(LEAST + np.exp(v[0]), float(v[1]))
        scaled = value / np.exp(v[2])
        return float(count.sum() * v[2] - count @ tails.log_density(scaled))

    start = np.array([np.log(max(freedom - LEAST, 0.5)), 0.0, 0.0])
    options = {"xatol": 1e-3, "fatol": 1e-2, "maxiter": 300}
    fits = [
        minimize(lambda v: loss(np.array([v[0], 0.0, v[1]])), start[[0, 2]], **_simplex(options)),
        minimize(loss, start + [0.0, 0.1 * np.sign(skew), 0.0], **_simplex(options)),
    ]
    best = fits[1].x
    h = 0.02
    curve = (loss(best + [0, h, 0]) - 2 * fits[1].fun + loss(best - [0, h, 0])) / h**2
    tails = HeavyTails(float(LEAST + np.exp(best[0])), float(best[1]))
    if abs(best[1]) > MOST or _missed(u, tails) > WORST * (len(EDGES) + 1):
        return None
    return float(fits[0].fun - fits[1].fun), tails, float(1.0 / np.sqrt(max(curve, 1e-9)))


def _missed(u: Array, tails: HeavyTails) -> float:
    """Twice the log-likelihood that the counts of samples `u` (n,) by class lose to `tails`."""
    count = np.bincount(np.searchsorted(EDGES, u), minlength=len(EDGES) + 1)
    share = np.diff(np.r_[0.0, tails.below(EDGES), 1.0])
    expected = np.maximum(len(u) * share, 1e-9)
    own = np.where(count > 0, count * np.log(np.maximum(count, 1) / expected), 0.0)
    return float(2.0 * np.sum(own - (count - expected)))


def _simplex(options: dict[str, float]) -> dict[str, object]:
    return {"method": "Nelder-Mead", "options": options}
