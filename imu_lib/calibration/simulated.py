"""Laboratory and hand-held calibration records with known truth.

Readings are `triad.distort(truth)` plus noise. `noise(n)` is any function that returns (n, 3) noise in the
unit of the reading; `white(sd, rng)` makes the simplest, `from_model` draws it from an error model.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ..units import DEG_PER_S, G
from .table import CALGARY, steps
from .triad import Triad, triad


def white(sd: float, rng: np.random.Generator):
    """White noise of standard deviation `sd` per sample on three axes."""
    return lambda n: rng.normal(0.0, sd, (n, 3))


def from_model(model, fs: float, rng: np.random.Generator, kind: str = "accel"):
    """Noise of the three `kind` channels of an error model (channels it lacks stay silent)."""

    def draw(n):
        drawn = model.simulate(n, fs, rng)
        return np.column_stack([drawn.get(f"{kind}_{axis}", np.zeros(n)) for axis in "xyz"])

    return draw


def panel(
    sensor: Triad,
    fs: float,
    *,
    turns: int = 6,
    rate: float = 6 * DEG_PER_S,
    phase: float = 0.0,
    gravity: float = CALGARY,
    noise=None,
) -> tuple[np.ndarray, np.ndarray]:
    """Accelerometers turned about their z axis in the vertical plane: time (n,) and readings (n, 3)."""
    time = np.arange(round(turns * 2 * np.pi / rate * fs)) / fs
    angle = rate * time + phase
    truth = gravity * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    return time, sensor.distort(truth) + (noise(len(time)) if noise else 0.0)


def stepped_table(
    sensor: Triad, fs: float, *, dwell: float = 20.0, noise=None, settling: float = 1.0, axis: int = 2
) -> tuple[np.ndarray, np.ndarray]:
    """Gyroscopes on a stepped rate table: rates (33,) rad/s and readings (n, 3); each step is reached with
    time constant `settling` s."""
    rates, each = steps(), round(dwell * fs)
    before = np.concatenate([[0.0], rates[:-1]])
    decay = np.exp(-np.arange(each) / fs / settling)
    truth = np.zeros((each * len(rates), 3))
    truth[:, axis] = (rates[:, None] + (before - rates)[:, None] * decay).ravel()
    return rates, sensor.distort(truth) + (noise(len(truth)) if noise else 0.0)


def hand_held(
    poses: int,
    fs: float,
    rng: np.random.Generator,
    *,
    accelerometers: Triad | None = None,
    gyroscopes: Triad | None = None,
    rest: float = 4.0,
    turn: float = 2.0,
    gravity: float = G,
    accel_noise=None,
    gyro_noise=None,
) -> tuple[np.ndarray, np.ndarray]:
    """A sensor put down by hand in `poses` random poses: readings accel (n, 3) and gyro (n, 3).

    Each turn is about one random body axis by 60 to 170 degrees with a smooth rate, and ends in a rest. While
    it turns, the hand shakes the accelerometers.
    """
    still, moving = round(rest * fs), round(turn * fs)
    profile = np.sin(np.pi * (np.arange(moving) + 0.5) / moving) ** 2
    profile /= profile.sum() / fs
    rate = [np.zeros((still, 3))]
    for _ in range(poses - 1):
        axis = rng.normal(size=3)
        angle = rng.uniform(np.pi / 3, 17 / 18 * np.pi)
        rate += [profile[:, None] * angle * axis / np.linalg.norm(axis), np.zeros((still, 3))]
    rate = np.concatenate(rate)
    down, force = gravity * Rotation.random(rng=rng).as_matrix()[2], np.empty_like(rate)
    shake = np.abs(rate).max(axis=1) > 0
    for k, back in enumerate(Rotation.from_rotvec(-rate / fs).as_matrix()):  # gravity as the body sees it
        force[k] = down
        if shake[k]:
            down = back @ down
    force[shake] += rng.normal(0.0, 0.1 * gravity, (shake.sum(), 3))
    a = (accelerometers or triad()).distort(force) + (accel_noise(len(rate)) if accel_noise else 0.0)
    w = (gyroscopes or triad()).distort(rate) + (gyro_noise(len(rate)) if gyro_noise else 0.0)
    return a, w
