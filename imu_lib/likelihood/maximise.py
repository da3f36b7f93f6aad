"""Maximum of the likelihood: Fisher scoring with damping, from several starts."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import combinations

import numpy as np

from imu_lib.arrays import Array

from .problem import Problem
from .slot import FILTER

STARTS = 8


def climb(
    problem: Problem,
    theta: Array,
    *,
    held: Collection[int] = (),
    floor: Array | None = None,
    steps: int = 80,
    tolerance: float = 1e-7,
) -> tuple[Array, float, Array]:
    """Fisher scoring (Levenberg-Marquardt damped) from theta; unknowns in `held` stay.

    Returns (theta, log-likelihood, information).
    """
    move = np.array([k not in held for k in range(len(theta))])
    low = problem.floors(theta) if floor is None else floor
    theta = np.clip(theta, low, problem.high)
    value, gradient, information = problem.score(theta)
    damping = 1e-3
    for _ in range(steps):
        if not move.any():
            break
        # at a bound and pushed outwards: held for this step
        active = (
            move
            & ~((theta <= low + 1e-12) & (gradient <= 0))
            & ~((theta >= problem.high - 1e-12) & (gradient >= 0))
        )
        if not active.any():
            break
        part = information[np.ix_(active, active)]
        diagonal = np.diag(part)
        better = False
        for _ in range(12):
            matrix = part + np.diag(damping * diagonal + 1e-9 * (1 + diagonal.max()))
            step = np.zeros(len(theta))
            step[active] = np.clip(np.linalg.solve(matrix, gradient[active]), -2, 2)
            trial = np.clip(theta + step, low, problem.high)
            # nine of ten trials are taken: their slopes are asked for at once
            there = problem.score(trial)
            if there[0] >= value - 1e-12:
                better = True
                break
            damping = max(damping * 8, 1e-3)
        if not better:
            break
        gain = there[0] - value
        theta = trial
        value, gradient, information = there
        damping = max(damping / 5, 1e-7)
        if gain < tolerance:
            break
    return theta, value, information


def amplitudes(problem: Problem, theta: Array, rounds: int = 40) -> Array:
    """Best non-negative amplitudes for given times: the multiplicative (EM) update of a sum of
    known shapes.
    """
    theta = np.array(theta, float)
    ks = [k for k, u in enumerate(problem.free) if u.amplitude]
    if not ks:
        return theta
    theta[ks] = 0.0
    rows, rest = problem.parts(theta)
    moving = [problem.free[k].index for k in ks]
    shapes = np.array([rows[i] for i in moving])
    fixed = sum((row for i, row in rows.items() if i not in moving), rest)
    level = problem.scale / np.maximum(shapes.max(axis=1), 1e-300)
    m, power = problem.stats.count, problem.stats.power
    # start each where it explains all of the band in which it is largest against the data
    mean = np.maximum(power / m, 1e-300)
    a = np.minimum(1.0 / np.maximum(np.quantile(shapes / mean, 0.98, axis=1), 1e-300), level * 1e12)
    for _ in range(rounds):
        expected = fixed + a @ shapes
        a = a * np.sqrt((shapes @ (power / expected**2)) / (shapes @ (m / expected)))
    theta[ks] = 0.5 * np.log(np.maximum(a, 1e-300))
    return theta


def starts(problem: Problem, count: int = STARTS) -> list[Array]:
    """Start vectors: every unknown time or frequency over its range in `count` places, amplitudes
    solved for.
    """
    free = problem.free
    shape = [k for k, u in enumerate(free) if not u.amplitude]
    base = np.zeros(len(free))
    if not shape:
        return [amplitudes(problem, base)]
    grids = {}
    for k in shape:
        u = free[k]
        margin = 0.15 * (u.high - u.low)
        if u.index == FILTER:
            grids[k] = np.linspace(u.high - np.log(12), u.high - 0.1, 4)
        else:
            grids[k] = np.linspace(u.low + margin / 2, u.high - margin, count)
    # equal processes in ascending order of their times only
    groups: dict[tuple[type, str], list[int]] = {}
    for k in shape:
        groups.setdefault((type(problem.process(free[k].index)), free[k].name), []).append(k)
    choices = [np.zeros((1, 0))]
    columns = []
    for ks in groups.values():
        grid = grids[ks[0]]
        picks = [[grid[i] for i in pick] for pick in combinations(range(len(grid)), len(ks))]
        columns += ks
        choices = [np.array([[*a, *b] for a in choices[0] for b in picks])]
    out = []
    for row in choices[0]:
        theta = base.copy()
        theta[columns] = row
        out.append(amplitudes(problem, theta))
    return out


def maximise(
    problem: Problem, given: Iterable[Array] = (), *, grid: bool = True, refine: int = 3
) -> tuple[Array, float, Array]:
    """The best of several climbs: from `given` vectors and from the best `refine` of the grid."""
    if not problem.free:
        return np.zeros(0), problem.loglike(np.zeros(0)), np.zeros((0, 0))
    candidates = list(given)
    if grid:
        candidates += sorted(starts(problem), key=problem.loglike, reverse=True)[:refine]
    rough = [climb(problem, theta, steps=40, tolerance=1e-3) for theta in candidates]
    theta, value, _ = max(rough, key=lambda result: result[1])
    return climb(problem, theta)  # to the end, with bounds that follow the new level
