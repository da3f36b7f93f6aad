"""Intervals of a change of what is random, from its likelihood over its parameters.

The logarithms of the parameters climb to the maximum on the whole drive (they may have been fitted
to a part of it, or on a path that has moved since); from there each has its own profile.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation.side_by_side import each

from . import joint, profile, random_effects

if TYPE_CHECKING:
    from .state import Change, State

Likelihood = Callable[[Array], float]  # of the logarithms of the parameters, nats

CLIMBS = 8  # steps until the maximum lies within what is looked at
CLOSE = 0.05  # nats that a further step would gain
FIRST = 0.1  # of the logarithms: differences before the curvature is known
LONGEST = 1.5  # of the logarithms, in one step


def intervals(state: State, found: Change) -> dict[str, list[float]]:
    """95 % intervals of the parameters of an accepted change, {name: [low, high]}; its values
    become the medians, all else that is fitted to the same fixes at its best for each value.
    """
    start = np.log(found.values)
    together = joint.Joint.of(state)
    part = together.parts[state.changes.index(found)]
    along = together.follow(part)

    def at(x: Array) -> float:
        return together.value(together.start + along @ (x - start))

    centre, axes = _maximum(at, start)
    top = together.start + along @ (centre - start)
    sd = np.sqrt(np.sum(axes**2, axis=1))
    bounds = profile.quantiles(together, top, part, sd)
    found.values = np.exp(bounds[:, 1])  # of a skewed likelihood the maximum is too small
    low, _, high = (found.change.describe(np.exp(b)) for b in bounds.T)
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
    return x, axes


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
