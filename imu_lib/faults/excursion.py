"""Handling too slow to shake: the level leaves that of both sides and comes back."""

from __future__ import annotations

import numpy as np

from imu_lib.faults.hits import ALONE, Hit
from imu_lib.faults.levels import sides, tail_threshold, windows

#: s of the windows of level.
LEVEL = (0.5, 2.0, 8.0)
#: Scatters by which a level must stand out.
LEVEL_STANDS = 7.0
#: Blocks of level on each side that tell what is usual, and those next to it left out.
LEVEL_REACH, GUARD = 15, 1
#: rad that a turn about one axis alone must reach, beyond its own noise.
TURN = 4e-3


def excursions(x: np.ndarray, bad: np.ndarray, length: int, rate: float, names) -> list[Hit]:
    """Windows whose mean is off those of both sides, on two channels, or one gyro by an angle.

    Windows in which samples are bridged are not judged, where these are few.
    """
    hits = []
    for offset in (0, length // 2):
        bridged = windows(bad, length, offset).any(axis=1)
        if bridged.mean() > 0.3:
            bridged[:] = False
        means = np.stack([windows(v, length, offset).mean(axis=1) for v in x])
        off, scale = zip(*(_excursion(m) for m in means))
        score = np.array(off) / np.array(scale)
        stands = score > LEVEL_STANDS
        mask = stands.sum(axis=0) >= 2
        alone = np.zeros_like(mask)
        for c, name in enumerate(names):
            if name.startswith("gyro"):
                value = np.log(np.maximum(score[c], 1e-3))
                limit = max(tail_threshold(value, ALONE), np.log(2 * LEVEL_STANDS))
                alone |= (value > limit) & (off[c] * length / rate > TURN)
        mask = (mask | alone) & ~bridged
        mask[: GUARD + 4] = mask[-GUARD - 4 :] = False  # there is no side to hold it against
        hits += [
            Hit(
                offset + int(j) * length,
                offset + (int(j) + 1) * length,
                frozenset(np.flatnonzero(stands[:, j]).tolist()),
                float(score[:, j].max()),
                True,
            )
            for j in np.flatnonzero(mask)
        ]
    return hits


def _excursion(mean: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By how much each mean is off both sides, and the scatter of such means around it."""
    before, after = sides(mean, LEVEL_REACH, GUARD)
    up = np.minimum(mean - before, mean - after)
    down = np.minimum(before - mean, after - mean)
    off = np.maximum(np.maximum(up, down), 0.0)
    near = np.abs(mean - 0.5 * (before + after))
    left, right = sides(near, LEVEL_REACH, GUARD)
    # half the difference of the sides is drift, not scatter
    scale = 1.4826 * np.maximum(np.maximum(left, right), np.median(near))
    return off, np.maximum(scale, 1e-300)
