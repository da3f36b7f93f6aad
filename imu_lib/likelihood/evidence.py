"""The maximum of a likelihood and its evidence: the log marginal likelihood by Laplace's method.

Free parameters have log-uniform priors of the widths that their slots state, amplitudes of mean
shapes log-uniform ones of either sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.arrays import Array

from .maximise import climb
from .problem import Problem
from .slot import Slot

#: Widths of the log-uniform priors: three decades of amplitude, four of time.
AMPLITUDE_WIDTH, TIME_WIDTH = float(np.log(1e3)), float(np.log(1e4))
#: Steps of a climb from a start that is near, and gain below which it ends.
STEPS, TOLERANCE = 14, 0.02


@dataclass(frozen=True)
class Maximum:
    """A maximum of the likelihood.

    Attributes
    ----------
    ll, evidence : float
        Log-likelihood there, and log marginal likelihood.
    terms, low_pass
        The noises and the filter there.
    vector : ndarray, shape (k,)
        The free parameters, logarithms.
    cov, information : ndarray, shape (k, k)
        Their covariance, and the Fisher information that it is the inverse of.
    beta, beta_cov : ndarray, shapes (q,), (q, q)
        Amplitudes of the mean shapes and their covariance.
    expected, remaining : ndarray, shape (b,)
        Density there, and ordinate sums without the mean shapes.
    slots : tuple of Slot
    """

    ll: float
    terms: tuple[Any, ...]
    low_pass: Any
    vector: Array
    cov: Array
    information: Array
    beta: Array
    beta_cov: Array
    evidence: float
    expected: Array
    remaining: Array
    slots: tuple[Slot, ...] = ()


def maximum(problem: Problem, start: Array | None = None) -> Maximum:
    """The maximum near `start` or the terms' own values."""
    theta = problem.start() if start is None else np.array(start, float)
    if len(theta):
        theta, _, information = climb(problem, theta, steps=STEPS, tolerance=TOLERANCE)
    else:
        information = np.zeros((0, 0))
    expected = problem.density(theta)
    beta, beta_cov = np.zeros(0), np.zeros((0, 0))
    if problem.regressors is not None:
        beta, beta_cov = problem.regressors.solve(expected)
    ll = problem.of_density(expected)
    worth = ll + _occam(problem.slots, information)
    worth += sum(
        amplitude_occam(abs(b) / np.sqrt(max(v, 1e-300))) for b, v in zip(beta, np.diag(beta_cov))
    )
    terms, low_pass = problem.unpack(theta)
    return Maximum(
        ll,
        terms,
        low_pass,
        theta,
        np.linalg.pinv(information, hermitian=True) if len(theta) else information,
        information,
        beta,
        beta_cov,
        float(worth),
        expected,
        problem.remaining(expected),
        problem.slots,
    )


def _occam(slots: tuple[Slot, ...], information: Array) -> float:
    """Log ratio of posterior to prior volume of the free parameters; no axis counts for more than
    the widest prior.
    """
    if not slots:
        return 0.0
    widths = np.concatenate([np.asarray(s.widths, float) for s in slots])
    sd = 1.0 / np.sqrt(np.maximum(np.linalg.eigvalsh(information), 1e-12))
    wide = np.log(np.maximum(sd, 1e-6) * np.sqrt(2 * np.pi))
    return float(np.sum(np.minimum(wide, np.log(widths.max()))) - np.sum(np.log(widths)))


def amplitude_occam(snr: float) -> float:
    """Log ratio of posterior to prior width of an amplitude of either sign, uniform in its
    logarithm over three decades.
    """
    return float(np.log(np.sqrt(2 * np.pi) / (2 * AMPLITUDE_WIDTH * max(snr, 1.0))))
