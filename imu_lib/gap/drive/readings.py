"""What the readings themselves say of white noise: whether it is there at rest, or grows with the
speed.

Fixes part a white noise from a vibration that follows the speed where the speed changes; second
differences of the readings, which motion hardly reaches, do so wherever the car once stands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.record import CHANNELS

if TYPE_CHECKING:
    from imu_lib.gap.drive.problem import Problem
    from imu_lib.gap.drive.random_effects import Change

BLOCK = 2.0  # s
SLOW = 0.1  # s over which readings are averaged, to see them at a few hertz
STANDING = 1.0  # m/s
MOST = 6.0  # nats that are given for it at the most: a sensor's own filter takes noise away, too
#: Densities over blocks (b, 6), and the squared speed in them (b,).
Densities = tuple[Array, Array]
FOUR = np.log(4.0)  # of the density: a noise that is off by as much is not what the readings show


def densities(problem: Problem, over: float = 0.0) -> Densities:
    """White noise of the channels over blocks of the drive, (b, 6), two-sided, and the squared
    speed in them, (b,); over : s, of readings averaged over as much.
    """
    drive, path = problem.drive, problem.path
    both, time, rate = np.column_stack([drive.gyro, drive.accel]), drive.time, drive.rate
    several = max(int(over * rate), 1)
    whole = len(both) // several * several
    both = both[:whole].reshape(-1, several, 6).mean(axis=1)
    time, rate = time[:whole:several], rate / several
    square = np.diff(both, 2, axis=0) ** 2 / 6.0 / rate
    count = max(int(BLOCK * rate), 10)
    blocks = len(square) // count
    square = square[: blocks * count].reshape(blocks, count, 6)
    middle = time[: blocks * count].reshape(blocks, count).mean(axis=1)
    speed = np.interp(middle, path["time"], np.linalg.norm(path["velocity"], axis=1))
    return np.maximum(np.median(square, axis=1) / 0.455, 1e-30), speed**2


def possible(change: Change, values: Array, slow: Densities) -> bool:
    """Whether the readings have the power, at a few hertz and motion included, that a change of
    white noise says: within FOUR; so of every other change.

    slow : of `densities` over SLOW
    """
    density, square_speed = slow
    told = _told(change, values, square_speed)
    if told is None or not density.size:
        return True
    channel, expected = told
    moves = square_speed >= min(STANDING**2, float(np.median(square_speed)))
    apart = np.log(expected[moves]) - np.log(density[moves, CHANNELS.index(channel)])
    return bool(np.median(apart) < FOUR)


def shows(problem: Problem, channel: str, density: float) -> bool:
    """Whether the readings of a channel have a white noise N of about that density, and not less:
    within FOUR of its square.
    """
    own = np.median(densities(problem)[0][:, CHANNELS.index(channel)])
    return bool(np.log(own) > 2.0 * np.log(density) - FOUR)


def evidence(change: Change, values: Array, measured: Densities) -> float:
    """Nats, at most 0, by which a change of white noise is not what the readings show; 0 for
    others.

    measured : of `densities`
    """
    density, square_speed = measured
    told = _told(change, values, square_speed)
    if told is None:
        return 0.0
    channel, expected = told
    apart = np.abs(np.log(density[:, CHANNELS.index(channel)]) - np.log(expected))
    apart, rests = np.minimum(apart / FOUR, 1.0), square_speed < STANDING**2
    if min(rests.sum(), (~rests).sum()) < 3:
        return -MOST * float(apart.mean())
    return -MOST * float(0.5 * (apart[rests].mean() + apart[~rests].mean()))


def _told(change: Change, values: Array, square_speed: Array) -> tuple[str, Array] | None:
    """The channel of a change of white noise, and the density that it says at those speeds; None
    of another change.
    """
    if change.effect == "vibration":
        p = change.describe(values)
        return p["channel"], p["N"] ** 2 + p["N_per_speed"] ** 2 * square_speed
    if change.key[0] == "bias_model" and change.key[2] == "white_noise":
        return change.key[1], np.full(square_speed.size, float(values[0]) ** 2)
    return None
