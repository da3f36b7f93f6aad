"""Deterministic errors: functions of time or of temperature."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, Parameter, Process
from .sampled import cluster_size


class Deterministic(Process):
    """A function of time or temperature; a realisation is its mean."""

    deterministic: ClassVar[bool] = True
    #: The parameter that scales it, and the one that a fit has to search for.
    linear: ClassVar[str] = "amplitude"
    searched: ClassVar[str] = ""

    @property
    def known(self) -> bool:
        """Whether its mean is what a record shows: not where its phase is open."""
        return True

    def shape(self, t: Array, temperature: Array | None = None) -> Array:
        """What its `linear` parameter scales, at times `t` (n,) in s: columns, shape (n, q)."""
        return self.with_(**{self.linear: 1.0}).mean(t, temperature)[:, None]

    def scaled(self, amplitudes: Array) -> Self:
        """The process whose mean is `shape` times these amplitudes, (q,)."""
        return self.with_(**{self.linear: float(amplitudes[0])})

    def referred(self, temperature: Array | None) -> Self:
        """With what is the record's own where it was left open (a reference temperature)."""
        return self

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        start: float = 0.0,
    ) -> Array:
        return self.mean(start + np.arange(n) / fs, temperature)


@dataclass(frozen=True)
class Constant(Deterministic):
    """A constant: turn-on bias, gravity, Earth rate. It is a nuisance in every estimate.

    Parameters
    ----------
    value : float, signal unit
    """

    value: float = FREE
    name: ClassVar[str] = "constant"
    linear: ClassVar[str] = "value"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("value", "signed", "signal unit"),)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return np.zeros(np.shape(tau))

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        return np.full(np.shape(t), self.value)


@dataclass(frozen=True)
class Ramp(Deterministic):
    """Rate ramp, R t: Allan variance R^2 tau^2 / 2 (IEEE Std 952-1997, Annex C.1.4).

    Parameters
    ----------
    R : float, signal unit / s
    """

    R: float = FREE
    name: ClassVar[str] = "ramp"
    linear: ClassVar[str] = "R"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("R", "signed", "slope, signal unit/s"),
    )

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return 0.5 * (self.R * np.asarray(tau, dtype=float)) ** 2

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        return self.R * np.asarray(t, dtype=float)


@dataclass(frozen=True)
class Sinusoid(Deterministic):
    """amplitude sin(2 pi frequency t + phase); phase 0 where it is not given.

    Allan variance amplitude^2 (sin^2(pi f tau) / (pi f tau))^2 (IEEE Std 952-1997, Annex C.1.7);
    the autocovariance is the average over the phase. Its spectrum is a line, not a density.

    Parameters
    ----------
    amplitude : float, signal unit
    frequency : float, Hz
    phase : float, optional, rad
    """

    amplitude: float = FREE
    frequency: float = FREE
    phase: float | None = None
    name: ClassVar[str] = "sinusoid"
    searched: ClassVar[str] = "frequency"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "amplitude", "signal unit"),
        Parameter("frequency", "frequency", "Hz"),
        Parameter("phase", "angle", "rad", optional=True),
    )

    @property
    def known(self) -> bool:
        return self.phase is not None

    def shape(self, t: Array, temperature: Array | None = None) -> Array:
        """Of unknown phase it has two columns, sine and cosine."""
        if self.phase is not None:
            return super().shape(t, temperature)
        angle = 2.0 * np.pi * self.frequency * t
        return np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def scaled(self, amplitudes: Array) -> Self:
        if len(amplitudes) == 1:
            return super().scaled(amplitudes)
        return self.with_(
            amplitude=float(np.hypot(*amplitudes)),
            phase=float(np.arctan2(amplitudes[1], amplitudes[0])),
        )

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        tau = np.asarray(tau, dtype=float)
        if fs is None:
            width = np.pi * self.frequency * tau
            return self.amplitude**2 * (np.sin(width) ** 2 / width) ** 2
        m = cluster_size(tau, fs)
        x = np.pi * self.frequency / fs
        return self.amplitude**2 * (np.sin(m * x) ** 2 / (m * np.sin(x))) ** 2

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return (
            0.5
            * self.amplitude**2
            * np.cos(2.0 * np.pi * self.frequency * np.asarray(lag, dtype=float))
        )

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        angle = 2.0 * np.pi * self.frequency * np.asarray(t, dtype=float) + (self.phase or 0.0)
        return self.amplitude * np.sin(angle)


@dataclass(frozen=True)
class WarmUp(Deterministic):
    """amplitude exp(-t / time_constant): the transient after switching on.

    Parameters
    ----------
    amplitude : float, signal unit
    time_constant : float, s
    """

    amplitude: float = FREE
    time_constant: float = FREE
    name: ClassVar[str] = "warm_up"
    searched: ClassVar[str] = "time_constant"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "signed", "value at t = 0, signal unit"),
        Parameter("time_constant", "time", "s"),
    )

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        return self.amplitude * np.exp(-np.asarray(t, dtype=float) / self.time_constant)


@dataclass(frozen=True)
class Step(Deterministic):
    """A jump of the bias by `amplitude` at `time` (the first sample at or after it has it whole),
    or a straight change from there on that lasts for a `duration`.

    Parameters
    ----------
    amplitude : float, signal unit
    time : float, s from the first sample
    duration : float, optional, s
    """

    amplitude: float = FREE
    time: float = FREE
    duration: float | None = None
    name: ClassVar[str] = "step"
    searched: ClassVar[str] = "time"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "signed", "signal unit"),
        Parameter("time", "other", "s from the first sample"),
        Parameter("duration", "time", "s of a change that is not sudden", optional=True),
    )

    @property
    def onset(self) -> float:
        return self.time

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        since = np.asarray(t, dtype=float) - self.time
        if self.duration:
            return self.amplitude * np.clip(since / self.duration, 0.0, 1.0)
        return np.where(since >= -1e-9, self.amplitude, 0.0)
