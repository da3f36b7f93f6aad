"""Park and Gao's two laboratory tests, and how far ten runs of one pin down its repeatability.

- Rotation panel (2008 paper, Section 4, Figs. 6 to 8, Table 2): an accelerometer turned at a
  constant rate W in the vertical plane reads

      y(t) = b + (1 + S) g cos(W t + p) = b + A cos(W t) + C sin(W t),    (1 + S) g = sqrt(A^2 +
      C^2)    (1)

  W is found anew in every run, because the motor does not keep it.
- Rate table (same section, Fig. 9, Table 3): a yaw gyroscope at steps 0, 10, ... 80, ... -80,
  ... 0 deg/s, each step averaged after it has settled, gives 33 equations y = b + (1 + S) w (Eq.
  4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import minimize_scalar

from ..errors import InputError
from ..estimate import Estimate
from ..units import DEG_PER_S
from .triad import interval

#: Standard gravity of the multi-sensor laboratory in Calgary (2008 paper, Section 4), m/s^2.
CALGARY = 9.8080


@dataclass(frozen=True)
class Line:
    """Bias and scale factor of one sensor. `bias` in the unit of the input, `scale_factor`
    dimensionless;
    `residual` (n,) what the line leaves, `reference` (n,) the inputs, `nonlinearity` its largest
    share of full scale;
    `rate` rad/s and `phase` rad of the panel where it turned."""

    bias: Estimate
    scale_factor: Estimate
    reference: np.ndarray
    residual: np.ndarray
    rate: float = 0.0
    phase: float = 0.0

    @property
    def nonlinearity(self) -> float:
        """Largest residual over the largest input."""
        return float(np.abs(self.residual).max() / np.abs(self.reference).max())


def line(reference: np.ndarray, reading: np.ndarray) -> Line:
    """Bias and scale factor by least squares on known inputs, both ndarray, shape (n,), same unit
    (2008 Eq. 4).

    Raises
    ------
    InputError
        With fewer than three inputs, or all of them equal.
    """
    x, y = np.asarray(reference, float), np.asarray(reading, float)
    if len(x) < 3 or np.ptp(x) == 0:
        raise InputError(
            f"{len(x)} steps with inputs from {x.min():g} to {x.max():g} do not determine bias and "
            "scale factor; use at least three steps with different inputs."
        )
    design = np.column_stack([np.ones_like(x), x])
    solution, *_ = np.linalg.lstsq(design, y, rcond=None)
    residual, dof = y - design @ solution, len(x) - 2
    sd = np.sqrt(residual @ residual / dof * np.diag(np.linalg.inv(design.T @ design)))
    return Line(
        interval(solution[0], sd[0], dof), interval(solution[1] - 1, sd[1], dof), x, residual
    )


def steps(largest: float = 80 * DEG_PER_S, step: float = 10 * DEG_PER_S) -> np.ndarray:
    """The rates of the stepped test, 0 up to `largest`, down to its negative, back to 0; rad/s."""
    k = round(largest / step)
    return step * np.concatenate(
        [np.arange(k + 1), np.arange(k - 1, -k - 1, -1), np.arange(-k + 1, 1)]
    )


def averages(
    reading: np.ndarray, fs: float, *, dwell: float = 20.0, settle: float = 10.0
) -> np.ndarray:
    """Mean reading of each step of `dwell` s after `settle` s of it, ndarray, shape (n // (dwell
    fs), ...).
    """
    each, skip = round(dwell * fs), round(settle * fs)
    count = len(reading) // each
    return np.array([reading[k * each + skip : (k + 1) * each].mean(axis=0) for k in range(count)])


def rotation(
    time: np.ndarray, reading: np.ndarray, *, gravity: float = CALGARY, rate: float | None = None
) -> Line:
    """Bias and scale factor of an accelerometer on a turning panel, Eq. (1).

    Parameters
    ----------
    time, reading : ndarray, shape (n,), s and m/s^2
    gravity : float, m/s^2
    rate : float, rad/s; found from the record when None

    Raises
    ------
    InputError
        When the record holds less than one turn.
    """
    t, y = np.asarray(time, float), np.asarray(reading, float)

    def design(w):
        return np.column_stack([np.ones_like(t), np.cos(w * t), np.sin(w * t)])

    def cost(w):
        a = design(w)
        solution, *_ = np.linalg.lstsq(a, y, rcond=None)
        return float(((y - a @ solution) ** 2).sum())

    if rate is None:
        power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)), 8 * len(y)))
        span = t[-1] - t[0]
        peak = 2 * np.pi * (np.argmax(power) / (8 * len(y))) * (len(t) - 1) / span
        if peak * span < 2 * np.pi:
            raise InputError("The record holds less than one turn of the panel; record several.")
        width = 1.0 / span
        rate = float(
            minimize_scalar(
                cost, bounds=(peak - width, peak + width), method="bounded", options={"xatol": 1e-9}
            ).x
        )
    a = design(rate)
    solution, *_ = np.linalg.lstsq(a, y, rcond=None)
    residual, dof = y - a @ solution, len(y) - 4
    covariance = residual @ residual / dof * np.linalg.inv(a.T @ a)
    size = np.hypot(*solution[1:])
    slope = np.array([0.0, *solution[1:]]) / size
    reference = (y - residual - solution[0]) * gravity / size
    return Line(
        interval(solution[0], np.sqrt(covariance[0, 0]), dof),
        interval(size / gravity - 1, np.sqrt(slope @ covariance @ slope) / gravity, dof),
        reference,
        residual,
        rate,
        float(np.arctan2(-solution[2], solution[1])),
    )


def values(fits, name: str) -> np.ndarray:
    """A result (`bias`, `scale_factor`) of repeated runs, ndarray of the shape of `fits`: a list
    of `Line`, or of lists of them.
    """
    if isinstance(fits, Line):
        return np.asarray(getattr(fits, name).value)
    return np.array([values(fit, name) for fit in fits])


@dataclass(frozen=True)
class Repeatability:
    """Mean and standard deviation of repeated runs with their 95 % intervals (normal runs,
    independent).
    """

    mean: Estimate
    sd: Estimate
    runs: int


def repeatability(values: np.ndarray) -> Repeatability:
    """How a result repeats from run to run, ndarray, shape (n,), n >= 2; sd with n - 1."""
    v = np.asarray(values, float)
    dof = len(v) - 1
    sd = v.std(ddof=1)
    low, high = sd * np.sqrt(dof / stats.chi2.ppf([0.975, 0.025], dof))
    return Repeatability(
        interval(v.mean(), sd / np.sqrt(len(v)), dof),
        Estimate(float(sd), float(low), float(high)),
        len(v),
    )


def change(values: np.ndarray) -> tuple[int, float]:
    """Best split of a series into two levels and the probability of one as good by chance.

    Returns
    -------
    (k, p) : the second level starts at run k; p from all the orderings' split statistics
    (permutation test,
        4,999 random orderings of a fixed seed).
    """
    v = np.asarray(values, float)

    def best(x):
        n, k = x.shape[-1], np.arange(1, x.shape[-1])
        left = np.cumsum(x, axis=-1)[..., :-1]
        gain = (left / k - x.mean(axis=-1, keepdims=True)) ** 2 * k * n / (n - k)
        return gain.argmax(axis=-1) + 1, gain.max(axis=-1)

    k, gain = best(v)
    rng = np.random.default_rng(1)
    shuffled = rng.permuted(np.tile(v, (4999, 1)), axis=1)
    return int(k), float((1 + (best(shuffled)[1] >= gain * (1 - 1e-12)).sum()) / 5000)
