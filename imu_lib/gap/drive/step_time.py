"""When the biases step, if they do: the time at which a step of all six explains most."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from imu_lib.arrays import Array

from . import columns, regression, select
from .state import State

SETTLED = 60.0  # s in which a path learns its biases
TIMES = 16  # tried at once
LEAST = 10.0  # nats, from which on a step is looked for more closely
CHANCE = 5.0  # nats that the best of so many times gains more than one of them
BETTER = 3.0  # nats over the time that was assumed
BIASES = [*columns.of("gyro_bias"), *columns.of("accel_bias")]


def look(state: State, say: Callable[[str], object]) -> None:
    """Ask for a step of the biases where it explains most, if that is clearly not where it was
    asked for before.
    """
    if columns.STEP in state.kept:
        return
    begin, end = float(state.problem.time[0]) + SETTLED, float(state.problem.time[-1]) - SETTLED
    if end - begin < SETTLED:
        return
    spacing = (end - begin) / (TIMES + 1)
    times = np.append(begin + spacing * np.arange(1, TIMES + 1), state.stepped)
    gains = _gains(state, times)
    best = int(np.argmax(gains))
    if gains[best] < LEAST:
        return
    closer = np.clip(times[best] + spacing * np.linspace(-1.0, 1.0, TIMES), begin, end)
    near = _gains(state, closer)
    price = select.PER_EFFECT + select.PER_PARAMETER * len(BIASES) + CHANCE
    if near.max() > max(gains[-1] + BETTER, price):
        state.step_at = float(closer[int(np.argmax(near))])
        say(f"biases may step at {state.step_at:.0f} s, {near.max():.0f} nats")
        state.rebuild()


def _gains(state: State, times: Array) -> Array:
    """Nats that a step of the biases at each time gains, (k,)."""
    arrays = state.problem.arrays
    after = arrays["node_time"][1:, None] > times  # (k-1, times)
    force = arrays["force"][:, BIASES]
    asked = (after[:, :, None, None] * force[:, None]).reshape(len(force), -1, force.shape[-1])
    result = state.problem.evaluate(state.noise, use=state.use, held=state.other, asked=asked)
    return regression.gains(state, result, columns.PRIOR[columns.of(columns.STEP)])[0]
