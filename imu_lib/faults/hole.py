"""It was turned while nothing was recorded."""

from __future__ import annotations

import numpy as np

from imu_lib.faults.finding import Finding, seconds
from imu_lib.faults.tilt import MEANS, angle_in_words
from imu_lib.faults.turn import CHANGED, rotation

#: s on each side of a hole that tell the attitude, and rad of a change told at the least.
ASIDE, LEAST_IN_HOLE = 60.0, 3e-3


def turned(x: dict[str, np.ndarray], time: np.ndarray, at: int) -> Finding | None:
    """Whether the attitude changed between the rows `at` and `at` + 1, before and after a hole."""
    accels = [f"accel_{a}" for a in "xyz"]
    if any(c not in x for c in accels):
        return None
    first = int(np.searchsorted(time, time[at] - ASIDE))
    last = int(np.searchsorted(time, time[at + 1] + ASIDE, side="right"))
    first, last = min(first, max(0, at - 9)), max(last, min(len(time), at + 11))
    left = np.stack([x[c][first : at + 1] for c in accels])
    right = np.stack([x[c][at + 1 : last] for c in accels])
    if min(left.shape[1], right.shape[1]) < 4:
        return None
    before, after = np.median(left, axis=1), np.median(right, axis=1)
    turn = rotation(before, after)
    angle = float(np.linalg.norm(turn))
    error = np.sqrt(left.var(axis=1) / left.shape[1] + right.var(axis=1) / right.shape[1])
    size = float(np.linalg.norm(before))
    if not size > 5.0:
        return None
    sure = angle * size / max(float(np.median(error)), 1e-300)
    if angle < LEAST_IN_HOLE or sure < 2 * CHANGED:
        return None
    start, stop = float(time[at]), float(time[at + 1])
    return Finding(
        "tilt",
        tuple(accels),
        start,
        stop,
        {"time": 0.5 * (start + stop), "angles": [float(a) for a in turn]},
        {"change_over_noise": sure, "change": [float(c) for c in after - before]},
        f"Within the hole from {seconds(start)} to {seconds(stop)} s the attitude changed by "
        f"{angle_in_words(angle)}.",
        MEANS,
    )
