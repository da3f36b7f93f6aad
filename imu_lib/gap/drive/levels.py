"""The levels of a noise that is fitted to the drive itself: white noise and walks alike on the
three axes, and the size of the fixes' errors where the file states none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.model import Model
from imu_lib.navigation.tuning import vehicle_model

if TYPE_CHECKING:
    from .problem import Noise
    from .state import State

START = (1e-3, 0.03, 3e-5, 1e-3)  # a low-cost unit in a car: gyro N, accel N, gyro K, accel K
NAME = "fitted in motion"
PRIOR = np.log(30.0)  # of the logarithm of a level
RATIO = 0.5  # of the fixes' errors to the usual ones, to start with
BOUNDS = (-25.0, 3.0)  # of the logarithms


def guess() -> Model:
    """The model to start with."""
    return vehicle_model(*START, name=NAME)


def unstated(state: State) -> list[str]:
    """Of which of the fixes' errors the file states no size, so that it is a level too; not those
    whose size was found to change.
    """
    changed = {c.change.key for c in state.changes}
    return [
        of
        for k, of in ((0, "position"), (3, "velocity"))
        if state.use[:, k].any()
        and getattr(state.problem.drive, f"gnss_{of}_sd") is None
        and ("gnss_noise", of) not in changed
    ]


def of(noise: Noise, ratios: Sequence[str]) -> Array:
    """Logarithms of the levels, (4 + r,)."""
    white, walk = zip(*(noise.model[c].terms for c in ("gyro_x", "accel_x")))
    four = [*(p.N for p in white), *(p.K for p in walk)]
    return np.log(np.maximum([*four, *(getattr(noise, name) for name in ratios)], 1e-11))


def entered(noise: Noise, x: Array, ratios: Sequence[str]) -> Noise:
    """A noise with levels of those logarithms."""
    levels = np.exp(np.clip(x, *BOUNDS))
    gyro_n, accel_n, gyro_k, accel_k = (float(v) for v in levels[:4])
    model = vehicle_model(gyro_n, accel_n, gyro_k, accel_k, name=NAME)
    return noise.with_(model=model, **dict(zip(ratios, levels[4:].tolist())))


def start(ratios: Sequence[str]) -> Array:
    """Logarithms that are usual, (4 + r,)."""
    return np.log((*START, *[RATIO] * len(ratios)))
