"""Shocks: times at which the filter loses its motion at once, so that it begins anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation.side_by_side import each

from . import across, base_model, levels, prune
from .state import State

MOST = 3  # restarts
PRICE = prune.PRICE_OF_SHOCK  # nats
BLOCK = 5.0  # s in which innovations stand out
STANDS_OUT = 3.0  # times the usual size: from here on a shock is tried
QUIETER = 5.0  # times
TIMES = 24  # tried where a noise may hide it


def gain(state: State, when: float) -> float:
    """Nats that a restart at a time gains on the path as it is; minus infinity where there is one,
    or no more motion.
    """
    kept = state.problem.arrays
    node = int(np.searchsorted(kept["node_time"], when))
    begins = kept["begins"].copy()
    if node >= begins.size or begins[node]:
        return -np.inf
    begins[node] = True
    problem = replace(state.problem, arrays={**kept, "begins": begins}, _brief=None, _held=None)
    trial = replace(state, problem=problem)
    return trial.evaluate(state.noise).log_likelihood - state.result.log_likelihood


def step(state: State) -> tuple[float, float] | None:
    """(gain, time) of a restart of the filter where the innovations stand out at one place."""
    if len(state.restarts) >= MOST:
        return None
    e = np.where(state.use, state.result.e, 0.0)
    nis = np.nansum(e**2, axis=1)
    freedom = np.maximum(state.use.sum(axis=1), 1)
    time = state.problem.time
    block = ((time - time[0]) / BLOCK).astype(int)
    total = np.bincount(block, nis) / np.maximum(np.bincount(block, freedom), 1)
    usual = np.median(total)
    worst = int(np.argmax(total))
    if total[worst] < STANDS_OUT * max(usual, 1.0):
        return None
    inside = np.flatnonzero((block >= worst - 1) & (block <= worst))
    level = nis[inside] / freedom[inside]
    out = inside[np.argmax(level > 0.3 * level.max())]
    when = float(time[max(out - 1, 0)] + 1e-3)
    more = gain(state, when) - PRICE
    return (more, when) if more > 0.0 else None


def _best(state: State, times: Array) -> tuple[float, float]:
    """(time, gain) of the restart that gains most."""
    gains = np.array(each(lambda t: gain(state, float(t)), times))
    k = int(np.argmax(gains))
    return float(times[k]), float(gains[k])


def hidden(state: State, say: Callable[[str], object]) -> bool:
    """Hold a shock that a noise fitted to the drive has made small: where a restart gains anything,
    its time is that at which it gains most under a quieter noise, and the noise is fitted again.
    Whether one was held.
    """
    if len(state.restarts) >= MOST:
        return False
    node_time = state.problem.arrays["node_time"]
    times = np.linspace(node_time[0], node_time[-1], TIMES + 2)[1:-1]
    best, most = _best(state, times)
    if not most > 0.0:
        return False
    quiet = state.copy()
    quiet.noise = levels.entered(state.noise, levels.of(state.noise, ()) - np.log(QUIETER), ())
    width = float(times[1] - times[0])
    for wide in (width, width / 8.0):
        best, _ = _best(quiet, best + wide * np.linspace(-1.0, 1.0, 17))
    trial = state.copy()
    trial.restarts = (*state.restarts, best)
    trial.rebuild()
    base_model.hold(trial, base_model.fit(trial))
    trial.weigh()
    base_model.settle(trial)
    temper = state.reg.temper
    if across.worth(trial, temper) + PRICE > across.worth(state, temper) - across.BETTER:
        return False
    say(f"a shock at {trial.restarts[-1]:.1f} s, which the noise had hidden")
    state.take(trial)
    state.restarts = trial.restarts
    state.noise, state.base, state.changes = trial.noise, trial.base, trial.changes
    return True
