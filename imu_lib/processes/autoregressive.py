"""Autoregressive process of any order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.linalg import solve_discrete_lyapunov
from scipy.signal import freqz, lfilter, lfiltic

from imu_lib.arrays import Array, ArrayLike
from imu_lib.errors import InputError, UndefinedFormError

from .base import FREE, SHORT, Parameter, Process, StateSpace
from .sampled import avar_from_transition, cluster_size

if TYPE_CHECKING:
    from .gauss_markov import GaussMarkov


#: Samples within which a fast noise forgets at the most, where these are longer than `SHORT`.
FEW = 5.0


@dataclass(frozen=True)
class Autoregressive(Process):
    """x_k = phi_1 x_{k-1} + ... + phi_p x_{k-p} + w_k at its own sampling rate.

    The sign is that of statsmodels and of the 2011 paper (Eq. 3); the 2013 (Eq. 9) and 2008
    papers write the coefficients with the opposite sign.

    Parameters
    ----------
    phi : sequence of float, length p
    sigma : float, signal unit
        Standard deviation of w.
    rate : float, Hz
        The rate at which the equation steps; every closed form is of samples at this rate.
    """

    phi: tuple[float, ...] = FREE
    sigma: float = FREE
    rate: float = FREE
    name: ClassVar[str] = "autoregressive"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("phi", "other", "coefficients phi_1 .. phi_p"),
        Parameter("sigma", "amplitude", "standard deviation of w, signal unit"),
        Parameter("rate", "frequency", "sampling rate, Hz"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.phi is not None:
            try:
                phi = tuple(float(c) for c in self.phi)
            except (TypeError, ValueError):
                phi = ()
            if not phi or not np.all(np.isfinite(phi)):
                raise InputError(
                    f"process autoregressive: `phi` must be a list of numbers, not {self.phi!r}"
                )
            object.__setattr__(self, "phi", phi)

    @property
    def poles(self) -> Array:
        """Poles, shape (p,); all inside the unit circle where the process is stationary."""
        return np.roots(np.concatenate([[1.0], -np.array(self.phi)]))

    @property
    def stable(self) -> bool:
        """Whether the process is stationary."""
        return bool(np.all(np.abs(self.poles) < 1.0))

    @property
    def fast(self) -> bool:
        if self.phi is None or self.rate is None:
            return False
        slowest = float(np.max(np.abs(self.poles), initial=0.0))
        return bool(slowest < np.exp(-1.0 / max(SHORT * self.rate, FEW)))

    def _at(self, fs: float | None) -> float:
        self._require()
        if fs is not None and abs(fs / self.rate - 1.0) > 1e-6:
            raise ValueError(
                f"`fs` must be the rate of the autoregressive process, {self.rate:g} Hz, not {fs:g}"
            )
        return self.rate

    def _stationary(self) -> None:
        if not self.stable:
            raise UndefinedFormError(
                f"the autoregressive process is not stationary: its largest pole is "
                f"{np.max(np.abs(self.poles)):.4g}"
            )

    def psd(self, f: ArrayLike, fs: float | None = None) -> Array:
        fs = self._at(fs)
        self._stationary()
        f = np.asarray(f, dtype=float)
        _, h = freqz([1.0], np.concatenate([[1.0], -np.array(self.phi)]), worN=np.ravel(f), fs=fs)
        return (2.0 * self.sigma**2 / fs * np.abs(h) ** 2).reshape(f.shape)

    def avar(self, tau: ArrayLike, fs: float | None = None) -> Array:
        space = self.state_space()
        return avar_from_transition(space.F, space.P0, space.H, cluster_size(tau, self._at(fs)))

    def autocovariance(self, lag: ArrayLike, fs: float | None = None) -> Array:
        space = self.state_space()
        d = np.rint(np.abs(np.asarray(lag, dtype=float)) * self._at(fs)).astype(int)
        right = space.P0 @ space.H
        values = {}
        for k in np.unique(d):
            values[k] = space.H @ np.linalg.matrix_power(space.F, int(k)) @ right
        return np.vectorize(values.get, otypes=[float])(d)

    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        start: float = 0.0,
    ) -> Array:
        self._at(fs)
        space = self.state_space()
        p = len(self.phi)
        denominator = np.concatenate([[1.0], -np.array(self.phi)])
        past = rng.multivariate_normal(np.zeros(p), space.P0, method="eigh")
        w = rng.standard_normal(n) * self.sigma
        return lfilter([1.0], denominator, w, zi=lfiltic([1.0], denominator, past))[0]

    def state_space(self) -> StateSpace:
        self._require()
        self._stationary()
        p = len(self.phi)
        transition = np.zeros((p, p))
        transition[0] = self.phi
        transition[1:, :-1] = np.eye(p - 1)
        step = np.zeros((p, p))
        step[0, 0] = self.sigma**2
        stationary = solve_discrete_lyapunov(transition, step)
        output = np.zeros(p)
        output[0] = 1.0
        return StateSpace(
            transition, step, output, 0.5 * (stationary + stationary.T), rate=self.rate
        )

    def to_gauss_markov(self) -> GaussMarkov:
        """The first-order Gauss-Markov process whose samples an AR(1) is (2011 paper, Eqs. 11-13).

        Raises
        ------
        UndefinedFormError
            Unless p = 1 and 0 < phi < 1.
        """
        from .gauss_markov import GaussMarkov

        self._require()
        if len(self.phi) != 1 or not 0.0 < self.phi[0] < 1.0:
            raise UndefinedFormError(
                "only an AR(1) with 0 < phi < 1 is a sampled Gauss-Markov process"
            )
        phi = self.phi[0]
        return GaussMarkov(
            sigma=self.sigma / np.sqrt(1.0 - phi**2),
            correlation_time=-1.0 / (self.rate * np.log(phi)),
        )
