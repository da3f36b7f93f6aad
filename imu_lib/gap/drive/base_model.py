"""Where no error model is given: white noise and walks alike on the three axes, as likely as the
innovations allow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize

from imu_lib.arrays import Array

from . import joint, levels, random_effects, worth
from .select import PER_EFFECT, PER_PARAMETER

if TYPE_CHECKING:
    from .problem import Noise
    from .state import State

TRIES = 70
PRICE = PER_PARAMETER * len(levels.START) + PER_EFFECT
LEAST = 0.1  # nats that levels fitted at the end gain


def fit(state: State, say: Callable[[str], object] = lambda text: None) -> Noise:
    """The noise of a state with its four levels and the fixes' two ratios fitted."""
    use, problem, noise = state.use, state.problem.brief(), state.noise
    ratios = levels.unstated(state)

    def loss(x: Array) -> float:
        value = problem.evaluate(levels.entered(noise, x, ratios), use=use).log_likelihood
        pull = 0.5 * float(np.sum(((x[:4] - np.log(levels.START)) / levels.PRIOR) ** 2))
        return -value + pull if np.isfinite(value) else 1e12

    start = levels.start(ratios)
    simplex = np.vstack([start, start + np.eye(start.size)])
    tries = TRIES + 30 * len(ratios)
    found = minimize(
        loss, start, method="Nelder-Mead",
        options={"initial_simplex": simplex, "maxfev": tries, "xatol": 0.05, "fatol": 0.5},
    )  # fmt: skip
    say("noise of the sensors fitted")
    return levels.entered(noise, found.x, ratios)


def anew(state: State, say: Callable[[str], object] = lambda text: None) -> bool:
    """Fit the noise again where something was found, and hold it if that is worth its price and
    outages do not say otherwise: what was fitted before held their errors too, and hides whatever
    is smaller than they were. Whether it was held.
    """
    under = (frozenset(state.kept), state.restarts, *(c.change.key for c in state.changes))
    if not any(under) or under in state.fitted_under:
        return False
    state.fitted_under = (*state.fitted_under, under)
    short = replace(state, problem=state.problem.brief())
    far = replace(short, noise=fit(state, say))
    started = [s.evaluate(s.noise).log_likelihood for s in (short, far)]
    return _taken(state, short if started[0] >= started[1] else far, PRICE, say)


def hold(state: State, noise: Noise) -> None:
    """Hold a noise whose levels were fitted, under the changes too; to be weighed by the caller."""
    fitted = {of: getattr(noise, of) for of in levels.unstated(state)}
    state.noise, state.base = noise, state.base.with_(model=noise.model, **fitted)
    told = {c.key: c.describe for c in random_effects.changes(state.problem, noise, False)}
    for change in state.changes:
        change.before = change.before.with_(model=noise.model)
        # a vibration tells the density that it is added to
        key = change.change.key
        change.change = replace(change.change, describe=told.get(key, change.change.describe))


def settle(state: State, say: Callable[[str], object] = lambda text: None) -> None:
    """All that is random fitted at once, at the end of the search."""
    if state.changes or (state.free and (state.kept or state.restarts)):
        _taken(state, replace(state, problem=state.problem.brief()), LEAST, say)


def _taken(state: State, short: State, least: float, say: Callable[[str], object]) -> bool:
    """Hold levels and the changes' values as they climb from a start, on a part of a long drive, if
    they gain as much and outages do not say otherwise: whether they were held.
    """
    together = joint.Joint.of(short)
    x = joint.climb(together)
    found = together.entered(x)
    if not state.evaluate(found).log_likelihood - state.result.log_likelihood > least:
        return False
    before = state.copy()
    for part, change in zip(together.parts, state.changes):
        change.values = np.exp(x[part])
    state.noise = found
    if state.free:
        hold(state, found)
    if not worth.no_worse(before, state):
        say("the noise fitted again does not help in outages: taken back")
        state.noise, state.base, state.changes = before.noise, before.base, before.changes
    state.weigh()
    return state.noise is found
