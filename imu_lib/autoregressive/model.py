"""An autoregressive model: coefficients, poles, residuals, and what it is a sample of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_toeplitz, toeplitz
from scipy.signal import lfilter

from imu_lib.estimate import Estimate
from imu_lib.processes import Autoregressive, GaussMarkov


@dataclass(frozen=True)
class ARModel:
    """x_k - mean = sum_i phi_i (x_{k-i} - mean) + w_k.

    Parameters
    ----------
    phi : ndarray, shape (p,)
        Coefficients in the sign of statsmodels and of the 2011 paper (Eq. 3). The 2013 paper (Eq.
        9) and the 2008
        paper write x(n) = -sum alpha_k x(n - k): `alpha` is `-phi`.
    sigma : float
        Standard deviation of the driving noise w (beta_0 of the 2013 paper), signal unit.
    mean : float
    n : int
        Samples that the fit used.
    method : str
    """

    phi: np.ndarray
    sigma: float
    mean: float
    n: int
    method: str

    @property
    def order(self) -> int:
        return len(self.phi)

    @property
    def alpha(self) -> np.ndarray:
        """The coefficients as the 2013 and 2008 papers print them."""
        return -self.phi

    @property
    def poles(self) -> np.ndarray:
        """Poles, shape (p,)."""
        return poles(self.phi)

    @property
    def stable(self) -> bool:
        """Whether all poles are inside the unit circle."""
        return bool(np.all(np.abs(self.poles) < 1))

    @property
    def covariance(self) -> np.ndarray:
        """Asymptotic covariance of `phi`, shape (p, p): sigma^2 Gamma^-1 / n, the same for all the
        methods.
        """
        if not self.order or not self.stable:
            return np.full((self.order, self.order), np.nan)
        return np.linalg.inv(toeplitz(autocovariance(self.phi, 1.0, self.order - 1))) / self.n

    def estimates(self) -> tuple[list[Estimate], Estimate]:
        """Coefficients and sigma with their 95 % intervals."""
        sd = np.sqrt(np.diag(self.covariance)) if self.order else []
        phi = [Estimate.normal(value, s) for value, s in zip(self.phi, sd, strict=True)]
        return phi, Estimate.lognormal(self.sigma, 1 / np.sqrt(2 * self.n))

    def residuals(self, x) -> np.ndarray:
        """One-step prediction errors of `x`, shape (n - p,)."""
        x = np.asarray(x, dtype=float) - self.mean
        return lfilter(np.concatenate([[1.0], -self.phi]), 1.0, x)[self.order :]

    def process(self, fs) -> Autoregressive:
        """The model as a process of the error model, stepping at `fs` Hz."""
        return Autoregressive(phi=tuple(self.phi), sigma=self.sigma, rate=fs)


def poles(phi) -> np.ndarray:
    """Roots of z^p - phi_1 z^(p-1) - ... - phi_p, shape (p,)."""
    return np.roots(np.concatenate([[1.0], -np.asarray(phi, dtype=float)]))


def autocovariance(phi, sigma, lags) -> np.ndarray:
    """Autocovariance of a stationary autoregressive process, lags 0 ... `lags`, shape (lags + 1,).

    The Yule-Walker equations turned round: linear in gamma_0 ... gamma_p. ValueError if the
    process is not stationary.
    """
    phi = np.asarray(phi, dtype=float)
    p = phi.size
    if p and np.max(np.abs(poles(phi))) >= 1:
        raise ValueError(
            f"`phi` has a pole of {np.max(np.abs(poles(phi))):.4g}: the process is not stationary"
        )
    system = np.eye(p + 1)
    for k in range(p + 1):
        for i in range(1, p + 1):
            system[k, abs(k - i)] -= phi[i - 1]
    gamma = np.zeros(max(lags, p) + 1)
    gamma[: p + 1] = np.linalg.solve(system, np.concatenate([[sigma**2], np.zeros(p)]))
    for k in range(p + 1, lags + 1):
        gamma[k] = phi @ gamma[k - 1 : k - p - 1 : -1] if k > p else 0.0
    return gamma[: lags + 1]


def best_predictor(gamma, order) -> tuple[np.ndarray, float]:
    """Coefficients and error standard deviation of the best linear predictor of a known
    autocovariance.

    What any fit of that order tends to on an endless record of a process with this autocovariance.
    """
    gamma = np.asarray(gamma, dtype=float)
    phi = solve_toeplitz(gamma[:order], gamma[1 : order + 1]) if order else np.zeros(0)
    return phi, float(np.sqrt(gamma[0] - phi @ gamma[1 : order + 1]))


def from_gauss_markov(process: GaussMarkov, fs) -> Autoregressive:
    """The AR(1) that samples of a Gauss-Markov process at `fs` Hz follow exactly (2011 paper, Eqs.
    9-12).

    phi = exp(-1 / (fs Tc)), and the driving noise has the variance sigma^2 (1 - phi^2) (Eq. 11;
    Eq. 3 of the 2013
    paper).
    """
    phi = np.exp(-1 / (fs * process.correlation_time))
    drive = process.sigma * np.sqrt(-np.expm1(-2 / (fs * process.correlation_time)))
    return Autoregressive(phi=(float(phi),), sigma=float(drive), rate=fs)


def to_gauss_markov(model: ARModel, fs) -> dict[str, Estimate]:
    """sigma and correlation time of the Gauss-Markov process that an AR(1) samples, with intervals
    (2011, Eq. 13).

    Tc = -1 / (fs ln phi). The interval of Tc is that of phi carried through the logarithm, so it
    is open above where phi may be 1. ValueError unless the order is 1 and 0 < phi < 1.
    """
    if model.order != 1 or not 0 < model.phi[0] < 1:
        raise ValueError(
            "`model` must be an AR(1) with 0 < phi < 1 to be a sampled Gauss-Markov process"
        )
    (phi,), _ = model.estimates()
    low, high = max(phi.low, 1e-300), phi.high
    tc = Estimate(
        *(float(-1 / (fs * np.log(v))) if v < 1 else np.inf for v in (phi.value, low, high))
    )
    # d ln sigma / d phi = phi / (1 - phi^2); sigma of w and phi are asymptotically independent.
    spread = np.hypot(
        phi.value / (1 - phi.value**2) * (phi.high - phi.low) / 3.92, 1 / np.sqrt(2 * model.n)
    )
    return {
        "sigma": Estimate.lognormal(model.sigma / np.sqrt(1 - phi.value**2), float(spread)),
        "correlation_time": tc,
    }
