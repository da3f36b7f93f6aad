"""Laboratory and hand-held calibration records with known truth.

Readings are `triad.distort(truth)` plus noise. `noise(n)` is any function that returns (n, 3)
noise in the unit of the reading; `white(sd, rng)` makes the simplest, `from_model` draws it from
an error model.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ..units import DEG_PER_S, G
from .table import CALGARY, averages, line, rotation, steps
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
    """Accelerometers turned about their z axis in the vertical plane: time (n,) and readings (n,
    3).
    """
    time = np.arange(round(turns * 2 * np.pi / rate * fs)) / fs
    angle = rate * time + phase
    truth = gravity * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    return time, sensor.distort(truth) + (noise(len(time)) if noise else 0.0)


def stepped_table(
    sensor: Triad,
    fs: float,
    *,
    dwell: float = 20.0,
    noise=None,
    settling: float = 1.0,
    axis: int = 2,
) -> tuple[np.ndarray, np.ndarray]:
    """Gyroscopes on a stepped rate table: rates (33,) rad/s and readings (n, 3); each step is
    reached with time constant `settling` s."""
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

    Each turn is about one random body axis by 60 to 170 degrees with a smooth rate, and ends in a
    rest. While it turns, the hand shakes the accelerometers.
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
    for k, back in enumerate(
        Rotation.from_rotvec(-rate / fs).as_matrix()
    ):  # gravity as the body sees it
        force[k] = down
        if shake[k]:
            down = back @ down
    force[shake] += rng.normal(0.0, 0.1 * gravity, (shake.sum(), 3))
    a = (accelerometers or triad()).distort(force) + (
        accel_noise(len(rate)) if accel_noise else 0.0
    )
    w = (gyroscopes or triad()).distort(rate) + (gyro_noise(len(rate)) if gyro_noise else 0.0)
    return a, w


def panel_runs(
    bias,
    scale_factor,
    fs: float,
    rng: np.random.Generator,
    *,
    noise=None,
    rate_sd: float = 0.05 * DEG_PER_S,
):
    """Repeated panel tests: a sensor with `bias` (r, 3) m/s^2 and `scale_factor` (r, 3) in run r,
    the panel's rate off by
    `rate_sd` rad/s. Returns the fits of x and y, (r, 2) lists of `Line`, and the last run's time
    and readings.
    """
    fits = []
    for b, s in zip(bias, scale_factor):
        time, reading = panel(
            triad(s, b), fs, rate=6 * DEG_PER_S + rng.normal(0, rate_sd), noise=noise
        )
        fits.append([rotation(time, reading[:, axis]) for axis in (0, 1)])
    return fits, time, reading


def table_runs(bias, scale_factor, fs: float, *, noise=None):
    """Repeated stepped rate-table tests of a yaw gyroscope with `bias` (r,) rad/s and
    `scale_factor` (r,). Returns the fits, (r,) list of `Line`, and the last run's readings (n,)
    rad/s."""
    fits = []
    for b, s in zip(bias, scale_factor):
        rates, reading = stepped_table(triad((0, 0, s), (0, 0, b)), fs, noise=noise)
        fits.append(line(rates, averages(reading[:, 2], fs)))
    return fits, reading[:, 2]


def coverage(records: int, *, poses: int = 24, fs: float = 50.0, noise: float = 0.02) -> np.ndarray:
    """Which 95 % intervals of `from_gravity` hold the truth, ndarray of bool, shape (records, 9),
    over simulated hand-held records of different sensors (seeds 0, 1, ...)."""
    from .poses import from_gravity
    from .rest import rest_windows

    out = np.zeros((records, 9), bool)
    for seed in range(records):
        rng = np.random.default_rng(seed)
        cross = {k: rng.normal(0, 0.005) for k in ("xy", "xz", "yz")}
        truth = triad(rng.normal(0, 0.005, 3), rng.normal(0, 0.1, 3), cross)
        accel, _ = hand_held(
            poses, fs, rng, accelerometers=truth, rest=3.0, accel_noise=white(noise, rng)
        )
        found = from_gravity(rest_windows(accel, fs).means(accel))
        estimates = (*found.biases, *found.scale_factors, *(found.cross_coupling[k] for k in cross))
        out[seed] = [
            e.covers(v)
            for e, v in zip(estimates, (*truth.bias, *(np.diag(truth.matrix) - 1), *cross.values()))
        ]
    return out
