"""The flat level of the Allan deviation that a likelihood fit implies."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from imu_lib import allan
from imu_lib.arrays import Array
from imu_lib.estimate import Z95, Estimate

from .intervals import reach
from .problem import Problem

if TYPE_CHECKING:
    from .fit import Fit


def flat_level(fit: Fit) -> Estimate:
    """Allan deviation of the fitted model where it is flat (0.664 B of a flicker): Estimate,
    interval by profile.

    The standard error of a flat level grows with the level, so that an interval from the fit's
    covariance would be too short upwards. The profile holds the level and lets all parameters go
    along with it; drifts stay as they were fitted.
    """
    stats, theta, noise = fit.statistics, fit.theta, fit.template.noise
    problem = Problem.of(replace(stats, power=fit.power), noise)
    span = 1 / stats.rate, stats.duration / 3
    low, best = problem.floors(theta), problem.loglike(theta)

    def look(values: Array, beside: float | None = None) -> tuple[float, float]:
        """Where the deviation is flat, s, and the logarithm of the level there (in continuous
        time).
        """
        model = problem.model(values)
        place = allan.flat_time(model, *span, beside=beside)
        return place, 0.5 * np.log(model.avar(np.array([place]))[0])

    def drop(level: float, near: Array) -> tuple[Array, float]:
        """Most likely parameters with that level (and the place), and the root of twice the
        log-likelihood they lose.
        """
        values, place = near[:-1], near[-1]
        slope = allan.flat_gradient(problem.model, values, place)
        for _ in range(15):
            _, score, information = problem.score(values)
            inverse = np.linalg.pinv(information, rcond=1e-12, hermitian=True)
            pull = (level - look(values, place)[1] - slope @ inverse @ score) / (
                slope @ inverse @ slope
            )
            step = np.clip(inverse @ (score + pull * slope), -0.2, 0.2)  # the place stays in sight
            values = np.clip(values + step, low, problem.high)
            place = look(values, place)[0]
            if step @ information @ step < 1e-4:  # a hundredth of a standard error
                break
        return np.append(values, place), np.sqrt(max(0.0, 2 * (best - problem.loglike(values))))

    place, top = look(theta)
    slope = allan.flat_gradient(problem.model, theta, place)
    sd = np.sqrt(max(slope @ fit.covariance @ slope, 1e-12))
    ends = [reach(drop, top, np.append(theta, place), sign * sd, Z95)[0] for sign in (-1, 1)]
    value = np.sqrt(problem.model(theta).avar(np.array([place]), stats.rate)[0])
    return Estimate(*(float(value * np.exp(shift)) for shift in (0, ends[0] - top, ends[1] - top)))
