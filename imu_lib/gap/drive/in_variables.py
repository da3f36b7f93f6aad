"""What the noise of the readings does to the columns that are made of readings.

A scale factor's column is the reading itself, and the reading holds the very noise that the
innovations hold: noise alone looks like a scale factor of one wherever a channel shakes more than
it moves. What it adds to the score is drawn from the hypothesis and taken off, as for a regression
with errors in variables (Fuller 1987); the information keeps it, so that a step is too short rather
than too long, and the path built next leads to the same end.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array

from . import columns

if TYPE_CHECKING:
    from .problem import Noise, Problem

DRAWS = 2
TINY = 1e-30  # of a variance: a state that a channel does not reach
NEARLY = 1e-6  # of each variance: states that follow from others have a root all the same
#: Column of the scale factor of each channel, and the one that is their sum.
SCALES = (*columns.of("gyro_scale"), *columns.of("accel_scale"))
CLOCK = columns.of("imu_clock")[0]


def squares(problem: Problem, noise: Noise, use: Array) -> Array:
    """Expected squares of what the white noise of each channel does to the innovations,
    (f, 6, 6).
    """
    roots, unit = _drawn(problem)
    speed = problem.arrays["node_speed"][1:, None]
    level = np.sqrt(problem.white(noise) + np.square(noise.per_speed) * speed**2)
    asked = np.einsum("kcij,dkcj->kdci", roots, unit) * level[:, None, :, None]
    kind = problem.arrays["force"].dtype  # of another, the filter would be compiled anew
    asked = np.ascontiguousarray(asked.reshape(len(asked), -1, 9), dtype=kind)
    jac = problem.evaluate(noise, use=use, asked=asked).jac
    assert jac is not None, "what was asked for"
    return np.mean(jac.reshape(*jac.shape[:2], DRAWS, 6) ** 2, axis=2)


def _drawn(problem: Problem) -> tuple[Array, Array]:
    """Roots of the covariances that unit noise of a channel leaves over each interval, (k-1, 6, 9,
    9), and standard normal variables (DRAWS, k-1, 6, 9); once for a path.
    """
    kept: dict[str, tuple[Array, Array]] = problem.__dict__.setdefault("drawn", {})
    if "both" not in kept:
        noise = problem.arrays["noise"]
        size = np.sqrt(np.maximum(np.diagonal(noise, axis1=-2, axis2=-1), TINY))
        alike = noise / (size[..., :, None] * size[..., None, :])
        roots = np.linalg.cholesky(alike + NEARLY * np.eye(9)) * size[..., None]
        unit = np.random.default_rng(0).standard_normal((DRAWS, *size.shape))
        kept["both"] = roots, unit
    return kept["both"]


def bias(of_channels: Array) -> Array:
    """What sums of squares (..., 6) add to the score (..., P) of values that are nothing."""
    out = np.zeros((*of_channels.shape[:-1], len(columns.ALL)))
    out[..., list(SCALES)] = of_channels
    out[..., CLOCK] = of_channels.sum(axis=-1)
    return out
