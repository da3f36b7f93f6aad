"""Intervals of a change of what is random: its likelihood over a grid of its parameters.

The curvature at the maximum is too narrow where a level meets a correlation time that the drive
hardly outlasts: the likelihood is skewed, and its tail counts.
"""

import numpy as np
from scipy.interpolate import RectBivariateSpline, make_interp_spline

from . import random_effects
from .side_by_side import each

STEPS = {1: np.linspace(-3.0, 3.0, 9), 2: np.linspace(-2.5, 3.5, 7)}  # standard deviations
FINE = 121
CLIMBS = 8  # grids until the likelihood's maximum lies within one
LEVELS = (0.025, 0.975)


def intervals(state, found):
    """95 % intervals of the parameters of an accepted change, {name: [low, high]}; its values become
    the medians where they were fitted to a part of the drive, or on a path that has moved since.
    """
    centre, moved = np.log(found.values), False

    def at(x):
        noise = found.change.enter(state.noise, np.exp(x))
        pull = 0.5 * np.sum(((x - np.log(found.change.start)) / random_effects.PRIOR) ** 2)
        value = state.evaluate(noise).log_likelihood - pull
        return value if np.isfinite(value) else -1e12

    steps = STEPS[min(centre.size, 2)]
    for _ in range(CLIMBS):
        axes, points, grid = _grid(at, centre, steps)
        best = np.array(np.unravel_index(grid.argmax(), grid.shape))
        if np.all((best > 0) & (best < steps.size - 1)):
            break
        # the path has moved since the values were fitted: the likelihood lies elsewhere
        centre, moved = points[grid.argmax()], True
    fine = np.linspace(steps[0], steps[-1], FINE)
    if centre.size == 1:
        dense = make_interp_spline(steps, grid)(fine)
    else:
        dense = RectBivariateSpline(steps, steps, grid)(fine, fine)
    weight = np.exp(np.clip(dense - grid.max(), -60.0, 5.0))
    mesh = np.stack(np.meshgrid(*[fine] * centre.size, indexing="ij"), -1).reshape(-1, centre.size)
    values = centre + mesh @ axes.T
    bounds = np.array([_quantiles(v, weight.ravel()) for v in values.T])
    if moved or state.problem.brief() is not state.problem:
        found.values = np.exp([_quantiles(v, weight.ravel(), (0.5,))[0] for v in values.T])
    low, high = (found.change.describe(np.exp(b)) for b in bounds.T)
    return {k: [low[k], high[k]] for k in low if isinstance(low[k], float) and low[k] != high[k]}


def _grid(at, centre, steps):
    """Principal axes about a centre, the points of the grid along them, and the likelihood there."""
    axes, shape = _axes(at, centre), [steps.size] * centre.size
    points = [centre + axes @ steps[list(p)] for p in np.ndindex(*shape)]
    return axes, points, np.array(each(at, points)).reshape(shape)


def _quantiles(values, weight, levels=LEVELS):
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return np.interp(np.array(levels) * total[-1], total, values[order])


def _axes(at, x):
    """Columns: principal axes of the likelihood about x, one standard deviation long."""
    h, k = 0.1, x.size
    unit, pairs = np.eye(k) * h, [(i, j) for i in range(k) for j in range(i)]
    points = [x] + [x + s * a for a in unit for s in (1, -1)]
    points += [x + s * unit[i] + t * unit[j] for i, j in pairs for s in (1, -1) for t in (1, -1)]
    values = np.array(each(at, points))
    hessian = np.diag(values[1 : 2 * k + 1].reshape(k, 2).sum(axis=1) - 2 * values[0]) / h**2
    for (i, j), four in zip(pairs, values[2 * k + 1 :].reshape(-1, 4)):
        hessian[i, j] = hessian[j, i] = (four[0] - four[1] - four[2] + four[3]) / (4 * h**2)
    size, turn = np.linalg.eigh(-hessian)
    axes = turn / np.sqrt(np.maximum(size, 1.0 / random_effects.PRIOR**2))
    # the skewed side is the larger value's
    return axes * np.where(axes.sum(axis=0) < 0.0, -1.0, 1.0)
