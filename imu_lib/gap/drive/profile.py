"""The likelihood of one of several parameters, all others at their best for each of its values.

A level of the sensors' noise and a correlation time of the fixes' errors may stand for each other
over decades: the others then do not move along a line, and along the line that they leave the
likelihood falls off much sooner than it does (Venzon and Moolgavkar 1988).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.stats import norm

from imu_lib.arrays import Array

from .side_by_side import each

if TYPE_CHECKING:
    from .joint import Joint

QUANTILES = np.array([0.025, 0.5, 0.975])
NORMAL = 0.3  # nats by which the likelihood at two standard deviations may lack of a normal one's
FAR = 4.0  # nats below the top, where nothing is looked at any more
STEPS = 10  # to a side
FLAT = 0.7  # nats: after a step that loses less the next is twice as long
LONGEST = 1.5  # of the logarithm, in one step
CLOSE = 0.1  # nats that a further refit would gain
REFITS = 3
SHARES = (1.0, 0.4, 0.1)  # of a step of the others that are tried
FINE = 1001


def quantiles(joint: Joint, top: Array, k: int, sd: float) -> Array:
    """QUANTILES of the k-th logarithm by its profile; sd: of it at the top, as for a normal
    variable, which is taken where the profile is that of one.
    """
    value = joint.value(top)
    way = _way(joint.slope(top)[1], k)
    curve = {float(top[k]): value}
    ends = []
    for sign in (-1.0, 1.0):
        x = _refitted(joint, top + 2.0 * sign * sd * way, k)
        curve[float(x[0][k])] = x[1]
        ends.append(x[1] - value + 2.0)
    if np.all(np.abs(ends) < NORMAL):
        return top[k] + sd * norm.ppf(QUANTILES)
    for sign in (-1.0, 1.0):
        curve |= _side(joint, (top, value, way), k, sign * sd)
    return of_curve(np.array(sorted(curve)), np.array([curve[u] for u in sorted(curve)]))


def of_curve(x: Array, value: Array) -> Array:
    """QUANTILES of a variable whose log density, but for a constant, is known at x (n,)."""
    fine = np.linspace(x[0], x[-1], FINE)
    dense = PchipInterpolator(x, value)(fine)
    total = cumulative_trapezoid(np.exp(dense - dense.max()), initial=0.0)
    return np.interp(QUANTILES * total[-1], total, fine)


def _side(
    joint: Joint, start: tuple[Array, float, Array], k: int, step: float
) -> dict[float, float]:
    """The profile to one side, {logarithm: nats}; start: where, its value, and the way on."""
    x, last, way = start
    top, out = last, {}
    for _ in range(STEPS):
        x, value, way = _refitted(joint, x + step * way, k)
        out[float(x[k])] = value
        top = max(top, value)
        if value < top - FAR:
            break
        if abs(value - last) < FLAT:
            step = float(np.clip(2.0 * step, -LONGEST, LONGEST))
        last = value
    return out


def _way(information: Array, k: int) -> Array:
    """How all logarithms move with the k-th one."""
    rest = np.diag(information) > 0.0
    rest[k] = False
    out = np.zeros(len(information))
    out[k] = 1.0
    out[rest] = -np.linalg.solve(information[np.ix_(rest, rest)], information[rest, k])
    return out


def _refitted(joint: Joint, x: Array, k: int) -> tuple[Array, float, Array]:
    """(x, its value, way on) with all but the k-th logarithm led to their best."""
    value = joint.value(x)
    for _ in range(REFITS):
        slope, information = joint.slope(x)
        rest = np.diag(information) > 0.0
        rest[k] = False
        step = np.zeros(x.size)
        step[rest] = np.linalg.solve(information[np.ix_(rest, rest)], slope[rest])
        if 0.5 * float(slope @ step) < CLOSE:
            break
        step *= min(1.0, LONGEST / np.abs(step).max())
        tried = [x + share * step for share in SHARES]
        values = each(joint.value, tried)
        best = int(np.argmax(values))
        if values[best] <= value:
            break
        x, gained, value = tried[best], values[best] - value, values[best]
        if gained < CLOSE:
            break
    return x, value, _way(information, k)
