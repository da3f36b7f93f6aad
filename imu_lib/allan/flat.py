"""The flat part of a model's Allan deviation: where it is, and how high.

A flicker noise has a floor; a Gauss-Markov process has a bump instead, whose top is what a reader
of the curve takes for the floor. With a walk behind it the bump is followed by a trough, as flat
as the top: the top is meant. Where other noises cover the top, the least steep place near it
stands for it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import optimize

from imu_lib.arrays import Array
from imu_lib.processes import GaussMarkov, GaussMarkov2, Sum


def flat_time(model: Sum, shortest: float, longest: float, *, beside: float | None = None) -> float:
    """Averaging time, s, at which a sum's Allan deviation is flat.

    Parameters
    ----------
    model : Sum
        Complete. Where it has a Gauss-Markov process, the place is sought from one to six
        correlation times.
    shortest, longest : float
        Range of averaging times, s.
    beside : float, optional
        A place, s, near which to look instead: it follows one flat part while the parameters
        change a little, where top and trough would else take turns.
    """

    def slope(u: float, step: float = 1e-3) -> float:
        ends = model.avar(np.exp(np.array([u - step, u + step])))
        return np.log(ends[1] / ends[0]) / (2 * step)

    log = (
        np.linspace(np.log(shortest), np.log(longest), 400)
        if beside is None
        else np.log(beside) + np.linspace(-0.25, 0.25, 26)
    )
    rough = np.gradient(np.log(model.avar(np.exp(log))), log)
    near = np.full(log.size, beside is not None)
    if beside is None:
        for time in (
            p.correlation_time
            for p in model.terms
            if isinstance(p, GaussMarkov | GaussMarkov2) and p.sigma
        ):
            near |= (log >= np.log(time)) & (log <= np.log(6 * time))
        tops = np.flatnonzero(near[:-1] & near[1:] & (rough[:-1] > 0) & (rough[1:] <= 0))
        if tops.size:
            low, high = log[max(tops[0] - 1, 0)], log[min(tops[0] + 2, log.size - 1)]
            if slope(low) > 0 > slope(high):
                return float(np.exp(optimize.brentq(slope, low, high, xtol=1e-9)))
    k = int(np.argmin(np.where(near if near.any() else True, np.abs(rough), np.inf)))
    bounds = log[max(k - 1, 0)], log[min(k + 1, log.size - 1)]
    found = optimize.minimize_scalar(
        lambda u: slope(u) ** 2, bounds=bounds, method="bounded", options={"xatol": 1e-7}
    )
    return float(np.exp(found.x))


def flat_gradient(
    model_of: Callable[[Array], Sum], log: Array, place: float, step: float = 0.01
) -> Array:
    """Derivative of the logarithm of the flat level by the logarithms of parameters, the place
    moving along, (p,).

    Taken in continuous time: what a filter folds down changes the level by a few per cent of the
    white noise's share, its derivative by less, and costs most of the time.

    Parameters
    ----------
    model_of : callable
        The complete sum for log parameters (p,).
    place : float
        Where the deviation is flat at `log`, s.
    """

    def log_variance(moved: Array) -> float:
        model = model_of(moved)
        return np.log(model.avar(np.array([flat_time(model, place, place, beside=place)])))[0]

    return np.array(
        [
            (log_variance(log + one) - log_variance(log - one)) / (4 * step)
            for one in step * np.eye(log.size)
        ]
    )
