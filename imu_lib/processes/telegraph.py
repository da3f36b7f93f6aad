"""Random telegraph noise: burst or popcorn noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, Parameter, Process, StateSpace
from .gauss_markov import GaussMarkov


@dataclass(frozen=True)
class Telegraph(Process):
    """A signal that jumps between two levels at the instants of a Poisson process.

    Autocovariance (amplitude / 2)^2 exp(-2 rate abs(lag)) (Machlup 1954): the second-order
    statistics of a Gauss-Markov process with sigma = amplitude / 2 and
    correlation_time = 1 / (2 rate), from which only its two levels tell it.

    Parameters
    ----------
    amplitude : float, signal unit
        Distance between the two levels.
    rate : float, 1/s
        Flips per second.
    """

    amplitude: float = FREE
    rate: float = FREE
    name: ClassVar[str] = "telegraph"
    gaussian: ClassVar[bool] = False
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "amplitude", "between the two levels, signal unit"),
        Parameter("rate", "rate", "flips per second"),
    )

    @property
    def memory(self) -> float:
        return self.twin.memory

    @property
    def twin(self) -> GaussMarkov:
        """The Gauss-Markov process of the same autocovariance."""
        self._require()
        return GaussMarkov(sigma=0.5 * self.amplitude, correlation_time=0.5 / self.rate)

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        return self.twin.psd(f, fs)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        return self.twin.avar(tau, fs)

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        return self.twin.autocovariance(lag, fs)

    def state_space(self) -> StateSpace:
        """The Gauss-Markov process of the same second-order statistics (best linear filter)."""
        return self.twin.state_space()

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
        flips = rng.poisson(self.rate / fs, n)
        state = (np.cumsum(flips) + rng.integers(2)) % 2
        return self.amplitude * (state - 0.5)
