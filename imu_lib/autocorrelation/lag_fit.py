"""Generalised least squares on sample autocovariances of block means: white noise, Gauss-Markov,
random walk.

Times are in blocks and covariances in units of the record's variance; `gauss_markov` puts the
units back.
Parameters: ln sigma^2, ln Tc, the white part of a block's variance, and (segments) the walk's
variance per block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import nnls

from imu_lib.autocorrelation.correlation import (
    autocovariance,
    bartlett_covariance,
    expected_autocovariance,
)

#: Correlation time, in blocks, of the template that a process is looked for with.
TEMPLATE = 6.0
#: Fewest blocks of a fit, and blocks of a segment.
SMALLEST, SEGMENT = 48, 96
#: A fit is worth its time where the best correlation time of a coarse grid lies here, in blocks.
_NEAR = (1.4, 24.0)


@dataclass(frozen=True)
class Level:
    """Means of `m` samples: their number, and how clearly a correlation of a few blocks shows in
    them.

    Of the means themselves either all are there (`blocks`), or what a fit by segments needs of
    them: `products`, the sum of the outer products of segments of SEGMENT means, and how many.
    """

    m: int
    n: int
    gamma: np.ndarray
    significance: float
    limit: float  # 95 % upper limit of sigma^2 for the template's correlation time
    blocks: np.ndarray | None = None
    products: tuple[np.ndarray, int] | None = None

    @classmethod
    def of(cls, m, n, gamma, **more):
        """The level of these sample autocovariances, lags 0 ... k."""
        k = gamma.size - 1
        # In white noise the lags beyond 0 are independent, of variance gamma_0^2 / n and mean
        # -gamma_0 / n.
        template = block_autocovariance(TEMPLATE, k + 1)[1:] - 2 * TEMPLATE / n
        weight = template @ template
        estimate = template @ (gamma[1:] + gamma[0] / n) / weight
        sd = gamma[0] / np.sqrt(n * weight)
        limit = float(max(estimate, 0.0) + 1.645 * sd)
        return cls(m, n, gamma, float(estimate / sd), limit, **more)

    def of_segments(self):
        """Sum of the outer products of the segments, each less its own mean, and their number."""
        if self.products is not None:
            return _centred(self.products[0]), self.products[1]
        count = self.n // SEGMENT
        y = self.blocks[: count * SEGMENT].reshape(count, SEGMENT)
        y = y - y.mean(axis=1, keepdims=True)
        return y.T @ y, count


@dataclass(frozen=True)
class Solution:
    """Parameters, their covariance, and the model's mean of the autocovariances."""

    theta: np.ndarray
    covariance: np.ndarray
    gamma: np.ndarray
    mean: np.ndarray

    @property
    def tc(self):
        return np.exp(self.theta[1])

    @property
    def z(self):
        """Standard errors of sigma^2 above zero."""
        return 1 / np.sqrt(self.covariance[0, 0])


def block_levels(x, lags, block=None, *, unit=1) -> list[Level]:
    """Block means of 1, 2, 4, ... samples (or of `block` alone) of `x`, whose mean is removed; `x`
    may be means of `unit` samples already.
    """
    found, m = [], block or 1
    y = x[: x.size - x.size % m].reshape(-1, m).mean(axis=1)
    while y.size >= SMALLEST:
        k = min(lags, y.size // 3)
        gamma = autocovariance(y - y.mean(), k)
        found.append(Level.of(m * unit, y.size, gamma, blocks=y))
        if block:
            break
        m *= 2
        y = y[: y.size - y.size % 2].reshape(-1, 2).mean(axis=1)
    return found


def block_autocovariance(tc, count, m=np.inf):
    """Autocovariance of means of `m` samples of a unit Gauss-Markov process, `tc` in blocks;
    exact.
    """
    a = 1.0 / tc
    q = -np.expm1(-a)
    h = np.arange(count) - 1.0
    if m > 64:  # the limit; it differs by less than 1 / (6 m^2 tc^2)
        gamma = (q / a) ** 2 * np.exp(-a * h)
        gamma[0] = 2 * (a - q) / a**2
        return gamma
    b = a / m
    p = -np.expm1(-b)
    gamma = (q / (m * p)) ** 2 * np.exp(-b - a * h)
    gamma[0] = (m + 2 * np.exp(-b) * (m * p - q) / p**2) / m**2
    return gamma


def fit_whole(level, *, anywhere=False) -> Solution | None:
    """White noise and Gauss-Markov on the autocovariance of the whole record, Bartlett's
    covariance.

    None where the correlation time is plainly not a handful of blocks, unless it may lie
    `anywhere`.
    """
    n, k = level.n, level.gamma.size - 1

    def gamma_of(theta, count):
        gamma = np.exp(theta[0]) * block_autocovariance(np.exp(theta[1]), count, level.m)
        gamma[0] += theta[2]
        return gamma

    def mean_of(theta):
        if n <= 4096:
            return expected_autocovariance(gamma_of(theta, n), n, k)
        return gamma_of(theta, k + 1) - (theta[2] + 2 * np.exp(theta[0] + theta[1])) / n

    def covariance_of(theta):
        return bartlett_covariance(
            gamma_of(theta, min(n, int(12 * np.exp(theta[1])) + 2 * k + 8)), n, k
        )

    start, tc = _start(level.gamma, [block_autocovariance, _white])
    if not anywhere and not _NEAR[0] <= tc <= _NEAR[1]:
        return None
    return _iterate(
        np.array([*start[:1], np.log(tc), start[1]]), level.gamma, mean_of, covariance_of, n / 2
    )


def fit_segments(level, *, anywhere=False) -> Solution | None:
    """White noise, Gauss-Markov and random walk on the autocovariance averaged over segments of 96
    blocks, or None.

    Each segment's own mean is removed, so a walk has a well-defined mean here; mean and covariance
    are exact for
    Gaussian processes, segments counted as independent.
    """
    k = min(level.gamma.size - 1, SEGMENT // 3)
    products, count = level.of_segments()
    gamma = _diagonal_means(products, k) / count
    i = np.arange(SEGMENT)
    distance = np.abs(i[:, None] - i)
    walk = np.minimum(i[:, None], i) + np.where(
        distance == 0, 1 / 3, 0.5
    )  # means of a walk over unit blocks
    walk_mean = _diagonal_means(_centred(walk), k)
    white_mean = expected_autocovariance(_white(None, SEGMENT), SEGMENT, k)

    def unit_mean(tc, _=None):
        return expected_autocovariance(block_autocovariance(tc, SEGMENT, level.m), SEGMENT, k)

    def mean_of(theta):
        return (
            np.exp(theta[0]) * unit_mean(np.exp(theta[1]))
            + theta[2] * white_mean
            + theta[3] * walk_mean
        )

    def covariance_of(theta):  # of the forms y' S_h y / n: 2 tr(S_h C S_k C) / n^2
        matrix = (
            np.exp(theta[0]) * block_autocovariance(np.exp(theta[1]), SEGMENT, level.m)[distance]
        )
        matrix = _centred(matrix + theta[2] * np.eye(SEGMENT) + theta[3] * walk)
        products = np.zeros((k + 1, SEGMENT, SEGMENT))
        for h in range(k + 1):
            products[h, : SEGMENT - h] += matrix[h:] / 2
            products[h, h:] += matrix[: SEGMENT - h] / 2
        flat = products.reshape(k + 1, -1)
        return 2 * flat @ products.transpose(0, 2, 1).reshape(k + 1, -1).T / (SEGMENT**2 * count)

    start, tc = _start(gamma, [unit_mean, lambda *_: white_mean, lambda *_: walk_mean])
    if not anywhere and not _NEAR[0] <= tc <= _NEAR[1]:
        return None
    return _iterate(
        np.array([start[0], np.log(tc), start[1], start[2]]), gamma, mean_of, covariance_of, SEGMENT
    )


def _centred(matrix):
    """Covariance once the mean of the series is removed."""
    matrix = matrix - matrix.mean(axis=0)
    return matrix - matrix.mean(axis=1, keepdims=True)


def _diagonal_means(matrix, k):
    """Sums along the diagonals 0 ... k over the matrix's size."""
    return np.array([np.trace(matrix, h) for h in range(k + 1)]) / len(matrix)


def excess(level, solution, fine) -> float:
    """Standard errors by which the lags 1 to 4 of a coarser level exceed what the fit at `fine`
    predicts.
    """
    ratio = level.m / fine.m
    gamma = np.exp(solution.theta[0]) * block_autocovariance(solution.tc / ratio, level.n)
    gamma[0] += solution.theta[2] / ratio
    mean = expected_autocovariance(gamma, level.n, 4)
    covariance = bartlett_covariance(gamma[:4096], level.n, 4)
    return float((level.gamma[1:5] - mean[1:]).sum() / np.sqrt(covariance[1:, 1:].sum()))


def _white(_, count):
    return np.concatenate([[1.0], np.zeros(count - 1)])


def _start(gamma, shapes):
    """Non-negative amplitudes of the shapes (the first as a logarithm) and the best correlation
    time of a grid.
    """
    best = None
    weight = np.ones(gamma.size)
    weight[0] = 0.5  # the white part is found from lag 0 alone: let it not rule the others
    for tc in np.geomspace(1.0, gamma.size, 10):
        design = np.column_stack([s(tc, gamma.size) for s in shapes])
        amplitude, misfit = nnls(design * weight[:, None], gamma * weight)
        if best is None or misfit < best[2]:
            best = (amplitude, tc, misfit)
    amplitude, tc, _ = best
    amplitude[0] = np.log(max(amplitude[0], 1e-4 * gamma[0]))
    return amplitude, tc


def _iterate(theta, gamma, mean_of, covariance_of, longest, iterations=20):
    """Gauss-Newton with the covariance re-evaluated at every step; None where it does not
    settle.
    """
    size = theta.size
    step = np.array([1e-5, 1e-5, 1e-5 * gamma[0], 1e-5 * gamma[0]])[:size]
    settled = False
    for turn in range(iterations):
        if size == 4 and turn > 3 and not 1.0 < np.exp(theta[1]) < 32:
            return None  # on its way out of the range in which segments resolve it
        weight = covariance_of(theta)
        weight[np.diag_indices_from(weight)] *= 1 + 1e-9
        try:
            factor = cho_factor(weight)
            mean = mean_of(theta)
            jacobian = np.column_stack(
                [
                    (mean_of(theta + step * e) - mean_of(theta - step * e)) / (2 * step[i])
                    for i, e in enumerate(np.eye(size))
                ]
            )
            information = jacobian.T @ cho_solve(factor, jacobian)
            covariance = np.linalg.inv(information)
        except (LinAlgError, np.linalg.LinAlgError, ValueError):
            return None
        change = covariance @ (jacobian.T @ cho_solve(factor, gamma - mean))
        change[:2] = np.clip(change[:2], -0.7, 0.7)
        theta = theta + change
        theta[1] = np.clip(theta[1], np.log(0.2), np.log(longest))
        # The white part may come out a little negative, never so far that the model has no
        # spectrum.
        theta[2] = max(theta[2], -0.3 * np.exp(theta[0]) * -np.expm1(-1 / np.exp(theta[1])))
        theta[3:] = np.maximum(theta[3:], 0.0)
        settled = np.all(np.abs(change[:2]) < 1e-3)
        if settled:
            break
    if not settled or not np.all(np.isfinite(theta)) or not np.all(np.diag(covariance) > 0):
        return None
    return Solution(theta, covariance, gamma, mean)
