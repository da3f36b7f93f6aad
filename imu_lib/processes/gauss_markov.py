"""Gauss-Markov processes of first and second order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from imu_lib.arrays import Array, ArrayLike

from .base import FREE, SHORT, Parameter, Process, StateSpace
from .sampled import avar_from_semivariogram, cluster_size

_PARAMETERS = (
    Parameter("sigma", "amplitude", "standard deviation, signal unit"),
    Parameter("correlation_time", "time", "lag at which the autocorrelation is 1/e, s"),
)


@dataclass(frozen=True)
class GaussMarkov(Process):
    """First-order Gauss-Markov process, autocovariance sigma^2 exp(-abs(lag) / Tc).

    dx/dt = -x / Tc + w with two-sided density 2 sigma^2 / Tc (Gelb 1974, Sec. 2.2; 2013 paper
    Eqs. 1 and 4). The Allan deviation peaks at 1.893 Tc with 0.617 sigma. Sampled, it is an AR(1)
    with coefficient exp(-dt / Tc) (2011 paper Eqs. 9-13).

    Parameters
    ----------
    sigma : float, signal unit
    correlation_time : float, s
    """

    sigma: float = FREE
    correlation_time: float = FREE
    name: ClassVar[str] = "gauss_markov"
    parameters: ClassVar = _PARAMETERS

    @property
    def memory(self) -> float:
        return self.correlation_time

    @property
    def fast(self) -> bool:
        return self.correlation_time is not None and self.correlation_time < SHORT

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        f = np.asarray(f, dtype=float)
        T = self.correlation_time
        if fs is None:
            return 4.0 * self.sigma**2 * T / (1.0 + (2.0 * np.pi * f * T) ** 2)
        b = 1.0 / (fs * T)
        numerator = 2.0 * self.sigma**2 / fs * -np.expm1(-2.0 * b)
        return numerator / (np.expm1(-b) ** 2 + 4.0 * np.exp(-b) * np.sin(np.pi * f / fs) ** 2)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        tau = np.asarray(tau, dtype=float)
        if fs is None:
            return self.sigma**2 * _avar_continuous(tau / self.correlation_time)
        return self.sigma**2 * _avar_sampled(
            cluster_size(tau, fs), 1.0 / (fs * self.correlation_time)
        )

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        return self.sigma**2 * np.exp(-np.abs(np.asarray(lag, dtype=float)) / self.correlation_time)

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
        b = 1.0 / (fs * self.correlation_time)
        w = rng.standard_normal(n)
        w[1:] *= np.sqrt(-np.expm1(-2.0 * b))  # the first sample is drawn stationary
        return self.sigma * lfilter([1.0], [1.0, -np.exp(-b)], w)

    def state_space(self) -> StateSpace:
        self._require()
        variance = self.sigma**2
        return StateSpace(
            np.array([[-1.0 / self.correlation_time]]),
            np.array([[2.0 * variance / self.correlation_time]]),
            np.ones(1),
            np.array([[variance]]),
        )


def _avar_continuous(a: Array) -> Array:
    """Allan variance over sigma^2 at a = tau / Tc; a series where the closed form would cancel."""
    a = np.asarray(a, dtype=float)
    small = np.minimum(a, 0.02)
    series = small * (
        2 / 3 + small * (-1 / 2 + small * (7 / 30 + small * (-1 / 12 + small * 31 / 1260)))
    )
    u = -np.expm1(-np.maximum(a, 0.02))
    big = np.maximum(a, 0.02)
    return np.where(a < 0.02, series, (2.0 * big - 2.0 * u - u * u) / big**2)


def _avar_sampled(m: Array, b: float) -> Array:
    """Allan variance over sigma^2 of samples b = dt / Tc apart, m to a cluster; exact.

    For a = m b small the closed form cancels: there the semivariogram 1 - exp(-b d) is expanded
    in powers of d, whose sums are polynomials in m (the first is the random walk's).
    """
    a = m * b
    q = -np.expm1(-a)  # 1 - phi^m
    p = -np.expm1(-b)  # 1 - phi
    closed = (m * (2.0 - p) / p - (1.0 - p) * q * (2.0 + q) / p**2) / m**2
    series = (
        b * (2.0 * m**2 + 1.0) / (3.0 * m)
        - b**2 * m**2 / 2.0
        + b**3 * (21.0 * m**4 - 5.0 * m**2 - 1.0) / (90.0 * m)
        - a**4 / 12.0
        + 31.0 * a**5 / 1260.0
    )
    return np.where(a < 0.02, series, closed)


#: Time at which (1 + x) exp(-x) has fallen to 1/e (Gelb 1974, Table 2.2-1).
SECOND_ORDER_TIME = 2.146193220620583


@dataclass(frozen=True)
class GaussMarkov2(Process):
    """Second-order Gauss-Markov process, autocovariance sigma^2 (1 + beta t) exp(-beta t), with
    t = abs(lag).

    The correlation time is where the autocorrelation is 1/e, 2.146 / beta (Gelb 1974,
    Table 2.2-1). x'' + 2 beta x' + beta^2 x = w with two-sided density 4 beta^3 sigma^2.

    Parameters
    ----------
    sigma : float, signal unit
    correlation_time : float, s
    """

    sigma: float = FREE
    correlation_time: float = FREE
    name: ClassVar[str] = "gauss_markov_2"
    parameters: ClassVar = _PARAMETERS

    @property
    def memory(self) -> float:
        return self.correlation_time

    @property
    def fast(self) -> bool:
        return self.correlation_time is not None and self.correlation_time < SHORT

    @property
    def beta(self) -> float:
        """Natural frequency, rad/s."""
        return SECOND_ORDER_TIME / self.correlation_time

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        f = np.asarray(f, dtype=float)
        if fs is None:
            return 8.0 * self.sigma**2 * self.beta**3 / ((2.0 * np.pi * f) ** 2 + self.beta**2) ** 2
        # z-transform of (1 + b |d|) p^|d|, with p = exp(-b)
        b = self.beta / fs
        p = np.exp(-b)
        z = np.exp(-2j * np.pi * f / fs) * p
        one_sided_sum = z / (1.0 - z) + b * z / (1.0 - z) ** 2
        return 2.0 * self.sigma**2 / fs * (1.0 + 2.0 * one_sided_sum.real)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        tau = np.asarray(tau, dtype=float)
        if fs is None:
            return self.sigma**2 * _avar2_continuous(self.beta * tau)
        m = cluster_size(tau, fs)
        # beyond 512 samples the sampling changes the value by less than 1e-6
        out = _avar2_continuous(self.beta * m / fs)
        short = np.atleast_1d(m <= 512)
        if short.any():
            x = self.beta / fs * np.arange(2 * int(np.atleast_1d(m)[short].max()))
            s = -np.expm1(-x) - x * np.exp(-x)
            out = np.atleast_1d(out).copy()
            out[short] = [avar_from_semivariogram(s, int(k)) for k in np.atleast_1d(m)[short]]
            out = out.reshape(m.shape)
        return self.sigma**2 * out

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        self._require()
        x = self.beta * np.abs(np.asarray(lag, dtype=float))
        return self.sigma**2 * (1.0 + x) * np.exp(-x)

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
        space = self.state_space()
        transition, step = space.discrete(1.0 / fs)
        # x_k = H (zI - Phi)^-1 w: the two noises enter through their own numerators
        w = rng.multivariate_normal(np.zeros(2), step, size=n, method="eigh")
        w[0] = rng.multivariate_normal(np.zeros(2), space.P0, method="eigh")
        denominator = np.array([1.0, -np.trace(transition), np.linalg.det(transition)])
        return lfilter([1.0, -transition[1, 1]], denominator, w[:, 0]) + lfilter(
            [0.0, transition[0, 1]], denominator, w[:, 1]
        )

    def state_space(self) -> StateSpace:
        self._require()
        beta, variance = self.beta, self.sigma**2
        return StateSpace(
            np.array([[0.0, 1.0], [-(beta**2), -2.0 * beta]]),
            np.diag([0.0, 4.0 * beta**3 * variance]),
            np.array([1.0, 0.0]),
            np.diag([variance, variance * beta**2]),
        )


def _avar2_continuous(x: Array) -> Array:
    """Allan variance over sigma^2 at x = beta tau."""
    x = np.asarray(x, dtype=float)
    small = np.minimum(x, 0.3)
    series = np.zeros(x.shape)
    factorial = 6.0
    for k in range(4, 16):
        factorial *= k
        series = series + (-1.0) ** k * (3.0 - k) / factorial * (2.0 - 2.0 ** (k - 1)) * small ** (
            k - 2
        )
    big = np.maximum(x, 0.3)

    def g(u: Array) -> Array:
        return 2.0 * u - 3.0 + (u + 3.0) * np.exp(-u)

    return np.where(x < 0.3, 2.0 * series, 2.0 * (2.0 * g(big) - 0.5 * g(2.0 * big)) / big**2)
