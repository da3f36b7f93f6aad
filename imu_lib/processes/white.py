"""White noise and quantization: the noises without memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import UndefinedFormError

from .base import FREE, Parameter, Process, StateSpace


@dataclass(frozen=True)
class WhiteNoise(Process):
    """White noise on the signal: angle random walk of a gyro, velocity random walk of an
    accelerometer.

    Two-sided density N^2; Allan variance N^2 / tau (IEEE Std 952-1997, Annex C.1.1).

    Parameters
    ----------
    N : float, signal unit / sqrt(Hz)
    """

    N: float = FREE
    name: ClassVar[str] = "white_noise"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("N", "amplitude", "density, unit/sqrt(Hz)"),
    )

    @property
    def fast(self) -> bool:
        return True

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return np.full(np.shape(f), 2.0 * self.N**2)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return self.N**2 / np.asarray(tau, dtype=float)

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        if fs is None:
            raise UndefinedFormError(
                "the variance of white noise in continuous time is infinite: give `fs`"
            )
        return np.where(np.abs(np.asarray(lag, dtype=float)) * fs < 0.5, self.N**2 * fs, 0.0)

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
        x = rng.standard_normal(n)
        x *= self.N * np.sqrt(fs)
        return x

    def state_space(self) -> StateSpace:
        self._require()
        empty = np.zeros((0, 0))
        return StateSpace(empty, empty, np.zeros(0), empty, direct=self.N**2)


@dataclass(frozen=True)
class ReadOutNoise(WhiteNoise):
    """White noise that is added behind the low-pass filter, as that of a converter: the floor of
    the filter's stop band.

    Parameters
    ----------
    N : float, signal unit / sqrt(Hz)
    """

    name: ClassVar[str] = "read_out_noise"

    @property
    def behind_filter(self) -> bool:
        return True


@dataclass(frozen=True)
class Quantization(Process):
    """Quantization in the sense of IEEE Std 952: a white error of variance Q^2 on the *integrated*
    output.

    The rate is its difference quotient, x_k = (e_k - e_{k-1}) / dt, so the Allan variance is
    3 Q^2 / tau^2, slope -1 (Annex C.1.5). Rounding a rate output is `Resolution`: its error is
    white on the rate itself, slope -1/2.

    Parameters
    ----------
    Q : float, signal unit times s
    rounded : int, optional
        1: the integrated output is rounded to steps of Q sqrt(12), and a simulated sum does just
        that. What is read out lies on a grid of Q sqrt(12) fs, behind a low-pass filter if there
        is one.
    """

    Q: float = FREE
    rounded: int | None = None
    name: ClassVar[str] = "quantization"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("Q", "amplitude", "standard deviation of the integrated output"),
        Parameter("rounded", "count", "1: by rounding the integrated output", optional=True),
    )

    @property
    def fast(self) -> bool:
        return True

    @property
    def behind_filter(self) -> bool:
        return bool(self.rounded)

    @classmethod
    def of_grid(cls, step: float, fs: float) -> Quantization:
        """That of an integrated output whose increments lie on a grid of `step`, signal unit, at
        `fs` Hz.
        """
        return cls(Q=float(step / (fs * np.sqrt(12.0))), rounded=1)

    def round(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """The increments, shape (n,), of the rounded integral of `x`, shape (n,), at `fs` Hz."""
        step = self.Q * np.sqrt(12.0) * fs
        return np.diff(np.rint(np.cumsum(np.concatenate([[rng.random()], x / step])))) * step

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        if fs is None:
            raise UndefinedFormError(
                "the spectrum of quantization depends on the sampling: give `fs`"
            )
        return 8.0 * self.Q**2 * fs * np.sin(np.pi * np.asarray(f, dtype=float) / fs) ** 2

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return 3.0 * self.Q**2 / np.asarray(tau, dtype=float) ** 2

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        if fs is None:
            raise UndefinedFormError(
                "the autocovariance of quantization depends on the sampling: give `fs`"
            )
        d = np.rint(np.abs(np.asarray(lag, dtype=float)) * fs)
        return (self.Q * fs) ** 2 * (2.0 * (d == 0) - 1.0 * (d == 1))

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
        return np.diff(rng.standard_normal(n + 1)) * (self.Q * fs)
