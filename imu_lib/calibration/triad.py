"""What a calibration finds about three sensors: scale factors, cross-coupling, biases.

The reading of a triad at the true input u (specific force or angular rate, body axes) is

    y = M u + b + noise,        u = M^-1 (y - b)                                  (1)

M is 3 x 3; its diagonal holds `nominal` (1 + scale factor error), its off-diagonal elements the
cross-coupling (misalignment and non-orthogonality, the M_y, M_z of Eqs. 1 and 3 of the 2008
paper), b is the zero-offset bias in the unit of the reading.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from ..estimate import Estimate

AXES = ("x", "y", "z")


def interval(value: float, sd: float, dof: float) -> Estimate:
    """`value` with its 95 % interval from a standard deviation that has `dof` degrees of
    freedom.
    """
    half = stats.t.ppf(0.975, dof) * sd if dof > 0 else np.inf
    return Estimate(float(value), float(value - half), float(value + half))


@dataclass(frozen=True)
class Triad:
    """Calibration of three sensors, Eq. (1) of this module.

    Parameters
    ----------
    matrix : ndarray, shape (3, 3)
        M, reading per unit of input.
    bias : ndarray, shape (3,)
        b, in the unit of the reading.
    covariance : ndarray, shape (12, 12)
        Of the nine elements of M (row by row) and the three of b; zero where not estimated.
    dof : int
        Degrees of freedom behind the covariance.
    estimated : ndarray of bool, shape (12,)
        Which of the twelve the data determined; the others are held (cross-coupling at zero).
    nominal : float
        The sensitivity that a scale factor error is relative to (1 where readings are in SI).
    residual_sd : float
        Standard deviation of the residuals of the fit: m/s^2 for accelerometers, rad/s for a rate
        table, rad (direction of gravity after a turn) for `from_turns`.
    consistency : float
        Mean square of the residuals over what the noise at rest explains (1 when the model of the
        sensor and of its noise holds); nan where the residuals themselves were the measure of the
        noise.
    """

    matrix: np.ndarray
    bias: np.ndarray
    covariance: np.ndarray
    dof: int
    estimated: np.ndarray
    nominal: float = 1.0
    residual_sd: float = float("nan")
    consistency: float = float("nan")

    def correct(self, reading: np.ndarray) -> np.ndarray:
        """True input from readings, ndarray, shape (n, 3)."""
        return np.linalg.solve(self.matrix, (np.asarray(reading) - self.bias).T).T

    def distort(self, truth: np.ndarray) -> np.ndarray:
        """Readings (without noise) of a true input, ndarray, shape (n, 3)."""
        return np.asarray(truth) @ self.matrix.T + self.bias

    def _estimate(self, index: int, value: float, factor: float = 1.0) -> Estimate | None:
        if not self.estimated[index]:
            return None
        return interval(value, factor * np.sqrt(self.covariance[index, index]), self.dof)

    @property
    def biases(self) -> tuple[Estimate | None, ...]:
        """Zero-offset bias per axis, in units of the input (reading / nominal)."""
        return tuple(
            self._estimate(9 + i, self.bias[i] / self.nominal, 1 / self.nominal) for i in range(3)
        )

    @property
    def scale_factors(self) -> tuple[Estimate | None, ...]:
        """Scale factor error per axis, dimensionless (0.01 is one per cent)."""
        return tuple(
            self._estimate(4 * i, self.matrix[i, i] / self.nominal - 1, 1 / self.nominal)
            for i in range(3)
        )

    @property
    def cross_coupling(self) -> dict[str, Estimate | None]:
        """``{"xy": ...}``: what the x sensor reads of the y input, relative to nominal (rad where
        small).
        """
        return {
            AXES[i] + AXES[j]: self._estimate(
                3 * i + j, self.matrix[i, j] / self.nominal, 1 / self.nominal
            )
            for i in range(3)
            for j in range(3)
            if i != j
        }

    def to_json(self) -> dict:
        """Everything as plain lists and `{value, low, high}`."""

        def plain(e):
            return None if e is None else e.to_json()

        return {
            "bias": {a: plain(e) for a, e in zip(AXES, self.biases, strict=True)},
            "scale_factor": {a: plain(e) for a, e in zip(AXES, self.scale_factors, strict=True)},
            "cross_coupling": {k: plain(e) for k, e in self.cross_coupling.items()},
            "matrix": self.matrix.tolist(),
            "offset": self.bias.tolist(),
            "nominal": self.nominal,
            "residual_sd": self.residual_sd,
            "consistency": None if np.isnan(self.consistency) else self.consistency,
            "degrees_of_freedom": int(self.dof),
        }


def triad(scale_factor=(0.0, 0.0, 0.0), bias=(0.0, 0.0, 0.0), cross_coupling=None) -> Triad:
    """A triad with known errors, for simulations.

    Parameters
    ----------
    scale_factor : array-like, shape (3,)
        Scale factor errors x y z, dimensionless.
    bias : array-like, shape (3,)
        Zero-offset biases, unit of the input.
    cross_coupling : dict or None
        ``{"xy": 0.01, ...}``, rad.
    """
    matrix = np.diag(1 + np.asarray(scale_factor, float))
    for name, value in (cross_coupling or {}).items():
        matrix[AXES.index(name[0]), AXES.index(name[1])] = value
    return Triad(matrix, np.asarray(bias, float), np.zeros((12, 12)), 0, np.zeros(12, bool))
