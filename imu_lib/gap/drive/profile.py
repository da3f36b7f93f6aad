"""The likelihood of one of several parameters, all others at their best for each of its values.

A level of the sensors' noise and a correlation time of the fixes' errors may stand for each other
over decades: the others then do not move along a line, and along the line that they leave the
likelihood falls off much sooner than it does (Venzon and Moolgavkar 1988).
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.stats import norm

from imu_lib.arrays import Array

from .joint import Effort, Joint, ascent, following

QUANTILES = np.array([0.025, 0.5, 0.975])
NORMAL = 0.3  # nats by which the likelihood at two standard deviations may lack of a normal one's
FAR = 4.0  # nats below the top, where nothing is looked at any more
STEPS = 10  # to a side
FLAT = 0.7  # nats: after a step that loses less the next is twice as long
LONGEST = 1.5  # of the logarithm, in one step
OTHERS = Effort(steps=3, longest=LONGEST, shares=(1.0, 0.4, 0.1), close=0.1)
FINE = 1001


def quantiles(joint: Joint, top: Array, part: slice, sd: Array) -> Array:
    """QUANTILES (p, 3) of the logarithms of a part by their profiles; sd (p,): of them at the top,
    as for normal variables, which are taken where a profile is that of one.
    """
    value, information = joint.value(top), joint.slope(top)[1]
    numbers = np.arange(top.size)
    return np.array(
        [
            _quantiles(joint, (top, value, following(information, numbers == k)[:, 0]), k, s)
            for k, s in zip(numbers[part], sd)
        ]
    )


def _quantiles(joint: Joint, start: tuple[Array, float, Array], k: int, sd: float) -> Array:
    """QUANTILES of the k-th logarithm; start: the top, its value, and the way from it."""
    top, value, way = start
    curve = {float(top[k]): value}
    ends = []
    for sign in (-1.0, 1.0):
        x, there, _ = _refitted(joint, top + 2.0 * sign * sd * way, k)
        curve[float(x[k])] = there
        ends.append(there - value + 2.0)
    if np.all(np.abs(ends) < NORMAL):
        return top[k] + sd * norm.ppf(QUANTILES)
    for sign in (-1.0, 1.0):
        curve |= _side(joint, start, k, sign * sd)
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


def _refitted(joint: Joint, x: Array, k: int) -> tuple[Array, float, Array]:
    """(x, its value, way on) with all but the k-th logarithm led to their best."""
    mine = np.arange(x.size) == k
    x, value, information = ascent(joint, x, ~mine, OTHERS)
    return x, value, following(information, mine)[:, 0]
