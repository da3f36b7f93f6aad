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
from imu_lib.drive import Drive
from imu_lib.model import Model
from imu_lib.navigation.tuning import vehicle_model

from . import random_effects, worth
from .select import PER_EFFECT, PER_PARAMETER

if TYPE_CHECKING:
    from .problem import Noise
    from .state import State

START = (1e-3, 0.03, 3e-5, 1e-3)  # a low-cost unit in a car: gyro N, accel N, gyro K, accel K
TRIES = 70


def guess(drive: Drive) -> Model:
    """The model to start with."""
    return vehicle_model(*START, name="fitted in motion")


def fit(state: State, say: Callable[[str], object] = lambda text: None) -> Noise:
    """The noise of a state with its four levels and the fixes' two ratios fitted."""
    use, problem, noise = state.use, state.problem.brief(), state.noise

    of = [
        name
        for k, name in ((0, "position"), (3, "velocity"))
        if use[:, k].any() and getattr(problem.drive, f"gnss_{name}_sd") is None
    ]  # nothing is stated there that could be wrong

    def enter(x: Array) -> Noise:
        levels = np.exp(np.clip(x, -25.0, 3.0))
        gyro_n, accel_n, gyro_k, accel_k = levels[:4]
        ratios = {name: float(levels[4 + k]) for k, name in enumerate(of)}
        model = vehicle_model(gyro_n, accel_n, gyro_k, accel_k, name="fitted in motion")
        return noise.with_(model=model, **ratios)

    def loss(x: Array) -> float:
        value = problem.evaluate(enter(x), use=use).log_likelihood
        pull = 0.5 * float(np.sum(((x[:4] - np.log(START)) / np.log(30.0)) ** 2))
        return -value + pull if np.isfinite(value) else 1e12

    start = np.log((*START, *[0.5] * len(of)))
    simplex = np.vstack([start, start + np.eye(start.size)])
    found = minimize(
        loss, start, method="Nelder-Mead",
        options={
            "initial_simplex": simplex, "maxfev": TRIES + 30 * len(of), "xatol": 0.05, "fatol": 0.5,
        },
    )  # fmt: skip
    say("noise of the sensors fitted")
    return enter(found.x)


def anew(state: State, say: Callable[[str], object] = lambda text: None) -> bool:
    """Fit the noise again where effects were found, and hold it if that is worth its price and
    outages do not say otherwise: what was fitted before held their errors too, and hides whatever
    is smaller than they were. Whether it was held.
    """
    under = (frozenset(state.kept), *(c.change.key for c in state.changes))
    if not state.kept or under in state.fitted_under:
        return False
    state.fitted_under = (*state.fitted_under, under)
    found = fit(state, say)
    gain = state.evaluate(found).log_likelihood - state.result.log_likelihood
    if not gain > PER_PARAMETER * len(START) + PER_EFFECT:
        return False
    before = state.copy()
    changed = {c.change.key for c in state.changes}
    fitted = {
        of: getattr(found, of)
        for of in ("position", "velocity")
        if ("gnss_noise", of) not in changed
    }
    told = {c.key: c.describe for c in random_effects.changes(state.problem, found, False)}
    for change in state.changes:
        change.before = change.before.with_(model=found.model)
        # a vibration tells the density that it is added to
        key = change.change.key
        change.change = replace(change.change, describe=told.get(key, change.change.describe))
    state.noise, state.base = found, state.base.with_(model=found.model, **fitted)
    if not worth.no_worse(before, state):
        say("the noise fitted again does not help in outages: taken back")
        state.noise, state.base, state.changes = before.noise, before.base, before.changes
    state.weigh()
    return state.noise is found
