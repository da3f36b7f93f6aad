"""Intervals of a change of what is random, from its likelihood over its parameters.

The logarithms of the parameters climb to the maximum on the whole drive (they may have been fitted
to a part of it, or on a path that has moved since). Where the likelihood is that of a normal
variable out to two standard deviations, its quantiles are the normal ones; where a level meets a
correlation time that the drive hardly outlasts it is skewed, its tail counts, and a grid is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import RectBivariateSpline, make_interp_spline

from imu_lib.arrays import Array

from . import joint, random_effects
from .side_by_side import each

if TYPE_CHECKING:
    from .state import Change, State

Likelihood = Callable[[Array], float]  # of the logarithms of the parameters, nats

STEPS = {1: np.linspace(-3.0, 3.0, 9), 2: np.linspace(-2.5, 3.5, 7)}  # standard deviations
FINE = 121
CLIMBS = 8  # steps until the maximum lies within what is looked at
CLOSE = 0.05  # nats that a further step would gain
FIRST = 0.1  # of the logarithms: differences before the curvature is known
LONGEST = 1.5  # of the logarithms, in one step
NORMAL = 0.25  # nats by which the likelihood at two standard deviations may lack of a normal one's
LEVELS = (0.025, 0.975)


def intervals(state: State, found: Change) -> dict[str, list[float]]:
    """95 % intervals of the parameters of an accepted change, {name: [low, high]}; its values
    become the medians. Levels and other changes that are fitted to the same fixes follow the
    likelihood's ridge.
    """
    start = np.log(found.values)
    together = joint.Joint.of(state)
    along = together.follow(together.parts[state.changes.index(found)])

    def at(x: Array) -> float:
        return together.value(together.start + along @ (x - start))

    centre, axes = _maximum(at, start)
    if _normal(at, centre, axes):
        sd = np.sqrt(np.sum(axes**2, axis=1))
        bounds, medians = np.stack([centre - 1.96 * sd, centre + 1.96 * sd], axis=1), centre
    else:
        bounds, medians = _of_grid(at, centre, axes)
    found.values = np.exp(medians)  # of a skewed likelihood the maximum is too small
    low, high = (found.change.describe(np.exp(b)) for b in bounds.T)
    return {k: [low[k], high[k]] for k in low if isinstance(low[k], float) and low[k] != high[k]}


def refitted(state: State, found: Change) -> Array:
    """Values of an accepted change at the maximum near those that it has, (k,)."""
    start = np.log(found.values)

    def at(x: Array) -> float:
        noise = found.change.enter(state.noise, np.exp(x))
        pull = 0.5 * float(np.sum(((x - start) / random_effects.PRIOR) ** 2))
        value = state.evaluate(noise).log_likelihood - pull
        return value if np.isfinite(value) else -1e12

    return np.exp(_maximum(at, start)[0])


def _maximum(at: Likelihood, x: Array) -> tuple[Array, Array]:
    """The maximum, and as columns its principal axes, one standard deviation long."""
    axes = FIRST * np.eye(x.size)
    seen: list[tuple[float, Array]] = []
    for _ in range(CLIMBS):
        slope, turned, tried = _curvature(at, x, axes)
        seen += tried
        step = turned @ (turned.T @ slope)
        axes = turned
        if 0.5 * float(slope @ step) < CLOSE:
            break
        step *= min(1.0, LONGEST / np.abs(step).max())
        seen.append((at(x + step), x + step))
        x = max(seen, key=lambda s: s[0])[1]
    # the skewed side is the larger value's
    return x, axes * np.where(axes.sum(axis=0) < 0.0, -1.0, 1.0)


def _curvature(
    at: Likelihood, x: Array, axes: Array
) -> tuple[Array, Array, list[tuple[float, Array]]]:
    """(slope, principal axes one standard deviation long, [(value, point)]) about x, by differences
    along axes.
    """
    k = x.size
    pairs = [(i, j) for i in range(k) for j in range(i)]
    points = [x] + [x + s * a for a in axes.T for s in (1, -1)]
    points += [
        x + s * axes[:, i] + t * axes[:, j] for i, j in pairs for s in (1, -1) for t in (1, -1)
    ]
    values = np.array(each(at, points))
    both = values[1 : 2 * k + 1].reshape(k, 2)
    slope = np.linalg.solve(axes.T, 0.5 * (both[:, 0] - both[:, 1]))
    hessian = np.diag(both.sum(axis=1) - 2 * values[0])
    for (i, j), four in zip(pairs, values[2 * k + 1 :].reshape(-1, 4)):
        hessian[i, j] = hessian[j, i] = (four[0] - four[1] - four[2] + four[3]) / 4
    inverse = np.linalg.inv(axes)
    size, turn = np.linalg.eigh(-inverse.T @ hessian @ inverse)
    turned = turn / np.sqrt(np.maximum(size, 1.0 / random_effects.PRIOR**2))
    return slope, turned, list(zip(values, points))


def _normal(at: Likelihood, centre: Array, axes: Array) -> bool:
    """Whether the likelihood is a normal variable's out to two standard deviations along each
    axis.
    """
    points = [centre] + [centre + s * a for a in axes.T for s in (2.0, -2.0)]
    values = np.array(each(at, points))
    return bool(np.all(np.abs(values[1:] - values[0] + 2.0) < NORMAL))


def _of_grid(at: Likelihood, centre: Array, axes: Array) -> tuple[Array, Array]:
    """(bounds (k, 2), medians (k,)) of the logarithms from the likelihood over a grid."""
    steps = STEPS[min(centre.size, 2)]
    shape = [steps.size] * centre.size
    points = [centre + axes @ steps[list(p)] for p in np.ndindex(*shape)]
    grid = np.array(each(at, points)).reshape(shape)
    fine = np.linspace(steps[0], steps[-1], FINE)
    if centre.size == 1:
        dense = make_interp_spline(steps, grid)(fine)
    else:
        dense = RectBivariateSpline(steps, steps, grid)(fine, fine)
    weight = np.exp(np.clip(dense - grid.max(), -60.0, 5.0)).ravel()
    mesh = np.stack(np.meshgrid(*[fine] * centre.size, indexing="ij"), -1).reshape(-1, centre.size)
    values = centre + mesh @ axes.T
    bounds = np.array([_quantiles(v, weight) for v in values.T])
    return bounds, np.array([_quantiles(v, weight, (0.5,))[0] for v in values.T])


def _quantiles(values: Array, weight: Array, levels: Sequence[float] = LEVELS) -> Array:
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return np.interp(np.array(levels) * total[-1], total, values[order])
