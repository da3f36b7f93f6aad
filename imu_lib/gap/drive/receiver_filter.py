"""The filter that a receiver has for its velocities, as weights of time constants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.arrays import Array

from . import columns

COLUMNS = columns.of("other: receiver's velocity is smoothed")
_TAU2 = np.square(columns.SMOOTHED)  # s^2
SHORTEST = columns.SMOOTHED[0] / 2.0  # s, of a filter that slow motion shows


def none(index: Sequence[int] | Array, x: Array) -> np.ndarray:
    """Mask of the weights x (k,) of columns `index` that are of no filter: their sum takes nothing
    from slow motion, as a filter does by the square of its time constant. Of fast motion it may
    take or give, where the readings hold noise that the vehicle did not move with.
    """
    out = np.zeros(len(x), bool)
    place = {int(i): k for k, i in enumerate(index)}
    if not place.keys() >= set(COLUMNS):
        return out
    part = [place[i] for i in COLUMNS]
    out[part] = _TAU2 @ x[part] < SHORTEST**2 * np.abs(x[part]).sum()
    return out
