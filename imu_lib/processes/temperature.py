"""A bias that follows the temperature of the record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numba import njit
from scipy.signal import lfilter

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import InputError

from .base import FREE, Parameter
from .deterministic import Deterministic


@dataclass(frozen=True)
class Temperature(Deterministic):
    """slope (T - reference) + curvature (T - reference)^2: the bias follows the temperature.

    With a `lag` the sensor's own temperature follows that of the record through a first-order
    delay, which it has behind it at the first sample. With `play` it takes another way down than up
    (hysteresis): it stays where it is until the temperature has turned by so much.

    Parameters
    ----------
    slope : float, signal unit / degC
    reference : float, degC
    curvature : float, optional, signal unit / degC^2
    lag : float, optional, s
    play : float, optional, degC
    """

    slope: float = FREE
    reference: float = FREE
    curvature: float | None = None
    lag: float | None = None
    play: float | None = None
    name: ClassVar[str] = "temperature"
    linear: ClassVar[str] = "slope"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("slope", "signed", "signal unit/degC"),
        Parameter("reference", "other", "degC"),
        Parameter("curvature", "signed", "signal unit/degC^2", optional=True),
        Parameter("lag", "time", "of the sensor behind the thermometer, s", optional=True),
        Parameter("play", "other", "between the ways up and down, degC", optional=True),
    )

    def with_(self, **parameters: Any) -> Self:
        """The same process with some parameters replaced. A new slope alone keeps the shape: the
        curvature grows with it.
        """
        if self.curvature and "slope" in parameters and "curvature" not in parameters:
            parameters["curvature"] = self.curvature * parameters["slope"] / self.slope
        return super().with_(**parameters)

    def referred(self, temperature: Array | None) -> Self:
        """With the mean temperature of the record for a reference that was left open.

        Raises
        ------
        ValueError
            If there is no temperature.
        """
        if temperature is None:
            raise ValueError("`temperature` is needed: the model has a temperature term")
        if self.reference is not None:
            return self
        return self.with_(reference=float(np.mean(temperature)))

    def mean(self, t: ArrayLike, temperature: Array | None = None) -> Array:
        self._require()
        if temperature is None:
            raise InputError("the model has a temperature term: give the temperature of the record")
        temperature = np.asarray(temperature, dtype=float)
        if temperature.shape != np.shape(t):
            raise ValueError(
                f"`temperature` must have the shape of the time, {np.shape(t)}, not "
                f"{temperature.shape}"
            )
        if self.lag is not None:
            temperature = delayed(temperature, np.asarray(t, dtype=float), self.lag)
        if self.play is not None:
            temperature = behind_play(temperature, self.play)
        above = temperature - self.reference
        return self.slope * above + (self.curvature or 0.0) * above**2


def delayed(x: Array, t: Array, lag: float) -> Array:
    """`x` at the even times `t`, s, behind a first-order delay of `lag` s, shape (n,).

    Exact for straight lines between the samples (the ramp-invariant form of the filter).
    """
    if len(x) < 2:
        return np.array(x, dtype=float)
    h = (t[-1] - t[0]) / (len(t) - 1) / lag
    p = np.exp(-h)
    mean = -np.expm1(-h) / h  # of the decay over one step
    y, _ = lfilter([1.0 - mean, mean - p], [1.0, -p], x - x[0], zi=[0.0])
    return y + x[0]


@njit(cache=True)
def behind_play(x: Array, play: float) -> Array:
    """`x`, shape (n,), behind a backlash of `play` in all, in whose middle it begins."""
    out = np.empty_like(x)
    at = x[0]
    for k in range(len(x)):
        at = min(max(at, x[k] - 0.5 * play), x[k] + 0.5 * play)
        out[k] = at
    return out
