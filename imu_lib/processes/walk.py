"""Random walk: the integral of white noise."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, Parameter, Process, StateSpace
from .sampled import cluster_size


@dataclass(frozen=True)
class RandomWalk(Process):
    """Rate random walk of a gyro, acceleration random walk of an accelerometer.

    dx/dt = w with two-sided density K^2: Allan variance K^2 tau / 3 in the continuous limit
    (IEEE Std 952-1997, Annex C.1.3) and K^2 dt (2 m^2 + 1) / (6 m) for point samples, which is
    1.5 times the table at one sample.

    Parameters
    ----------
    K : float, signal unit / s / sqrt(Hz)
    """

    K: float = FREE
    name: ClassVar[str] = "random_walk"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("K", "amplitude", "density of the rate, unit/s/sqrt(Hz)"),
    )

    @property
    def memory(self) -> float:
        return math.inf

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        f = np.asarray(f, dtype=float)
        with np.errstate(divide="ignore"):
            if fs is None:
                return 2.0 * self.K**2 / (2.0 * np.pi * f) ** 2
            return 2.0 * self.K**2 / (2.0 * fs * np.sin(np.pi * f / fs)) ** 2

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        tau = np.asarray(tau, dtype=float)
        if fs is None:
            return self.K**2 * tau / 3.0
        m = cluster_size(tau, fs)
        return self.K**2 / fs * (2.0 * m**2 + 1.0) / (6.0 * m)

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        start: float = 0.0,
    ) -> Array:
        self._require()
        steps = rng.standard_normal(n)
        steps *= self.K / np.sqrt(fs)
        steps[:1] = 0.0
        return np.cumsum(steps, out=steps)

    def state_space(self) -> StateSpace:
        self._require()
        return StateSpace(np.zeros((1, 1)), np.array([[self.K**2]]), np.ones(1), np.zeros((1, 1)))
