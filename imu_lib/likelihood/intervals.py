"""95 % intervals from the profile of the likelihood, and upper limits for what a record does not
show.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from imu_lib.arrays import Array
from imu_lib.estimate import Z95, Estimate

from .maximise import climb
from .problem import Problem

ONE_SIDED = 1.6448536269514722
#: Twice the log-likelihood that a term must gain to count as shown: 5 % on the boundary of the
#: parameter space
#: (half a chi-square of one degree of freedom), and for a term with a time of its own, which
#: exists under the
#: alternative alone, chi-square of two degrees.
SHOWN, SHOWN_WITH_TIME = 2.705543, 5.991465


class _Better(Exception):
    """The profile found a point above the maximum."""


def intervals(
    problem: Problem, theta: Array, value: float, information: Array, attempts: int = 3
) -> tuple[dict[str, Estimate], Array, float, Array]:
    """Estimates of every unknown, with the maximum they belong to.

    Returns
    -------
    estimates : dict of label to Estimate
    theta, value, information
        The maximum; better than what came in where a profile ran into a higher peak.
    """
    for attempt in range(attempts):
        try:
            return (
                _intervals(problem, theta, value, information, attempt < attempts - 1),
                theta,
                value,
                information,
            )
        except _Better as better:
            theta, value, information = climb(problem, better.args[0])
            theta, value, information = climb(problem, theta)
    raise AssertionError("unreachable")


def _intervals(
    problem: Problem, theta: Array, value: float, information: Array, watch: bool
) -> dict[str, Estimate]:
    free, floor = problem.free, problem.floors(theta)
    side = _Side(problem, theta, value, information, floor, watch)
    out, shown = {}, {}
    for k, u in enumerate(free):
        if u.amplitude:
            times = sum(v.index == u.index and not v.amplitude for v in free)
            gain = 2 * (value - _without(problem, theta, k, floor))
            shown[u.index] = gain > (SHOWN_WITH_TIME if times else SHOWN)
    for k, u in enumerate(free):
        if u.amplitude and not shown[u.index]:
            out[u.label] = Estimate.absent(np.exp(side.end(k, +1, ONE_SIDED)[0]))
        elif not shown.get(u.index, True):
            out[u.label] = Estimate.absent()
        else:
            low, open_low = side.end(k, -1, Z95)
            high, open_high = side.end(k, +1, Z95)
            out[u.label] = Estimate(
                float(np.exp(theta[k])),
                0.0 if open_low else float(np.exp(low)),
                np.inf if open_high and not u.amplitude else float(np.exp(high)),
            )
    return out


def _without(problem: Problem, theta: Array, k: int, floor: Array) -> float:
    """Largest log-likelihood with amplitude k at zero."""
    start = theta.copy()
    start[k] = floor[k]
    index = problem.free[k].index
    held = {j for j, u in enumerate(problem.free) if u.index == index}
    first = climb(problem, start, held=held, floor=floor, tolerance=1e-4)[0]
    return climb(problem, first, held=held, tolerance=1e-4)[1]


class _Side:
    """Where the profile of one unknown has fallen by target^2 / 2."""

    def __init__(
        self,
        problem: Problem,
        theta: Array,
        value: float,
        information: Array,
        floor: Array,
        watch: bool,
    ) -> None:
        self.problem, self.theta, self.value, self.floor, self.watch = (
            problem,
            theta,
            value,
            floor,
            watch,
        )
        ridge = 1e-9 * (1 + np.diag(information).max()) * np.eye(len(theta))
        self.covariance = np.linalg.inv(information + ridge)

    def end(self, k: int, sign: int, target: float) -> tuple[float, bool]:
        """(log end, whether the range of the unknown ends first)."""
        theta, problem = self.theta, self.problem
        variance = self.covariance[k, k]
        direction = np.clip(self.covariance[:, k] / variance, -5, 5)
        bound = self.floor[k] if sign < 0 else problem.high[k]

        def drop(t: float, near: Array) -> tuple[Array, float]:
            start = near + direction * (t - near[k])
            start[k] = t
            floor = self.floor.copy()
            floor[k] = min(floor[k], t)
            at, v, _ = climb(problem, start, held={k}, floor=floor, steps=30, tolerance=1e-4)
            if self.watch and v > self.value + 1e-3:
                raise _Better(at)
            return at, np.sqrt(max(0.0, 2 * (self.value - v)))

        return reach(drop, theta[k], theta, sign * np.sqrt(variance), target, bound)


def reach(
    drop: Callable[[float, Array], tuple[Array, float]],
    best: float,
    theta: Array,
    sd: float,
    target: float,
    bound: float | None = None,
) -> tuple[float, bool]:
    """Where, going from `best` by steps of about `sd` (its sign is the direction), a profile has
    fallen enough.

    `drop(t, near)` gives the parameters at t, climbed to from those at a nearer place, and the
    root of twice the fall.

    Returns
    -------
    (t, open) : float, bool
        `open` where the range of the unknown, to `bound`, ends before the profile has fallen to
        `target`.
    """
    near, near_w, near_at = best, 0.0, theta
    far = far_w = None
    t = best + np.sign(sd) * np.clip(target * abs(sd), 1e-6, 1.5)
    for _ in range(25):
        if bound is not None:
            t = max(t, bound) if sd < 0 else min(t, bound)
        at, w = drop(t, near_at)
        if abs(w - target) < 0.01:
            break
        if w < target:
            if t == bound:
                return t, True
            near, near_w, near_at = t, w, at
        else:
            far, far_w = t, w
        if far is None or far_w is None:
            t = best + (near - best) * np.clip(target / max(near_w, 1e-9), 1.1, 3.0)
        else:
            share = np.clip((target - near_w) / (far_w - near_w), 0.05, 0.95)
            t = near + share * (far - near)
            if abs(far - near) < 1e-6:
                break
    return t, False
