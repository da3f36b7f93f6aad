"""The sensor began anew: levels of several channels, gyros among them, change at once and stay,
which no tilt does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.faults.blocks import Blocks, peaks, sudden
from imu_lib.faults.finding import Finding, named, seconds

#: Blocks on each side, and those left out next to the change.
WIDTH, GUARD = 40, 2
#: Standard deviations by which each of the levels must change.
CHANGED = 8.0
#: Share of a sample's own noise that it must reach, too.
VISIBLE = 0.5
#: Gyros, or channels, that must change at once.
GYROS, CHANNELS = 2, 4


#: The same where five channels change at once, for the fifth of them.
FIVE = 5.0


def find(
    x: dict[str, np.ndarray],
    time: np.ndarray,
    rate: float,
    turns: list[tuple[float, float]],
    handled: Sequence[tuple[float, float]] = (),
) -> list[Finding]:
    """Restarts within one stretch. `turns` are spans (s) known as tilts, `handled` those of
    handling, which leaves the gyros' levels as they were.
    """
    names = list(x)
    blocks = Blocks(np.stack([x[c] for c in names]), rate)
    if blocks.k < 3 * WIDTH:
        return []
    off, scale = sudden(blocks.change(WIDTH, GUARD), 2 * (WIDTH + GUARD))
    fast = np.array([np.mean(np.abs(np.diff(v[: blocks.k * blocks.size]))) for v in x.values()])
    score = np.where(np.abs(off) > VISIBLE * fast[:, None], np.abs(off) / scale, 0.0)
    is_gyro = np.array([c.startswith("gyro") for c in names])
    # the second largest of the gyros, the fourth of all: as many levels change at once
    joint = np.zeros(score.shape[1])
    for rows, least in ((is_gyro, GYROS), (np.ones(len(names), bool), CHANNELS)):
        if rows.sum() >= least:
            joint = np.maximum(joint, np.sort(score[rows], axis=0)[-least])
    if len(names) > 4:
        joint = np.maximum(joint, CHANGED / FIVE * np.sort(score, axis=0)[-5])
    found = []
    for at in peaks(joint, CHANGED, 3 * (WIDTH + GUARD)):
        members = score[:, at] > FIVE
        if members.sum() < 5:
            members = score[:, at] > CHANGED
        if not members[is_gyro].any():
            continue
        row = min(at * blocks.size, len(time) - 1)
        t = float(time[row])
        reach = (WIDTH + 2 * GUARD) * blocks.dt  # a turn shifts the means for as long
        if any(low - reach <= t <= high + reach for low, high in turns):
            continue
        near = [(low, high) for low, high in handled if low - reach <= t <= high + reach]
        if near and not _stays(blocks.means[is_gyro], near, blocks.dt, members[is_gyro], time[0]):
            continue
        t = next((0.5 * (low + high) for low, high in near), t)
        channels = tuple(c for c, m in zip(names, members) if m)
        found.append(
            Finding(
                "restart",
                channels,
                t,
                max(t, float(time[min(row + 1, len(time) - 1)])),
                {"time": t, "channels": list(channels)},
                {"change_over_noise": float(joint[at])},
                f"The levels of {named(channels)} change at once at {seconds(t)} s and stay: the "
                "sensor was restarted, or calibrated its zeros anew.",
                "Biases before and after are two turn-on biases; in one record they are steps.",
            )
        )
    return found


def _stays(
    gyros: np.ndarray,
    spans: Sequence[tuple[float, float]],
    dt: float,
    members: np.ndarray,
    begin: float,
) -> bool:
    """Whether the levels of two gyros are others after being handled than before, and go on
    being so.
    """
    low = int((min(s[0] for s in spans) - begin) / dt) - GUARD
    high = int((max(s[1] for s in spans) - begin) / dt) + 1 + GUARD
    if low < WIDTH or high + 2 * WIDTH > gyros.shape[1]:
        return False
    before = gyros[:, low - WIDTH : low].mean(axis=1)
    after = gyros[:, high : high + WIDTH].mean(axis=1)
    later = gyros[:, high + WIDTH : high + 2 * WIDTH].mean(axis=1)
    kept = (later - before) / np.where(after == before, np.inf, after - before)
    return bool(((kept > 0.7) & (kept < 1.4) & members).sum() >= GYROS)
