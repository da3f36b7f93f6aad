"""Whitened innovations as a regression on what each parameter does to them (`condense`): values,
standard deviations and gains of sets of columns, with the limits of what their names can mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import t as student

from imu_lib.arrays import Array, ArrayLike

from . import columns, in_variables, receiver_filter

if TYPE_CHECKING:
    from .problem import Innovations, Problem
    from .state import State

HUBER = 4.0  # standard deviations
BLOCK = 20.0  # s over which scores are summed to see how correlated they are
FEWEST_BLOCKS = 6  # from which on their scatter says something
#: Beyond five standard deviations of its prior a value is no longer what its name says (a scale
#: factor of 0.25, a bias of 2.5 m/s^2); times and causes outside the catalogue have no such limit.
LIMIT = np.array(
    [
        np.inf if c.effect.startswith(("other", "gnss_time_offset")) else 5.0 * c.prior
        for c in columns.ALL
    ]
)


LIMITS = LIMIT / columns.PRIOR
#: An error of a reading that is constant and one that grows with it: on a level road the force
#: along an axis hardly changes, so that the two are one ridge and may each be anything.
_CONSTANT = {"accel_bias": "accel_scale", "gyro_bias": "gyro_scale"}
#: (bias, scale) columns of the same axis.
PAIRS = tuple(
    pair
    for b, s in _CONSTANT.items()
    for pair in zip(columns.GROUPS[b], columns.GROUPS[s], strict=True)
)
ALONG = 0.9  # correlation of two values from which on they are one ridge
#: Standard deviations of their priors beyond which both lie, of sensors as they are, once in 400.
BOTH = 2.0


def cancelling(index: Sequence[int] | Array, x: Array, cov: Array) -> Array:
    """Mask of the values of a set that only make up for another's: of a bias and a scale factor of
    one axis, both larger than sensors have, that lie apart along their common ridge, the scale
    factor.
    """
    out = np.zeros(len(index), bool)
    place = {int(i): k for k, i in enumerate(index)}
    for bias, scale in PAIRS:
        if bias not in place or scale not in place:
            continue
        b, s = place[bias], place[scale]
        if min(abs(x[b]) / columns.PRIOR[bias], abs(x[s]) / columns.PRIOR[scale]) < BOTH:
            continue
        common = cov[b, s] / np.sqrt(cov[b, b] * cov[s, s])
        out[s] = abs(common) > ALONG and common * x[b] * x[s] > 0.0
    return out


def _meets_a_limit(index: Array, x: Array) -> Array:
    """Mask (r,) of sets, columns `index` (r, k), with a value x (r, k), in prior widths, that its
    name may not have.
    """
    out = np.any(np.abs(x) > LIMITS[index], axis=1)
    shape = len(x), len(columns.PRIOR)
    whole, here = np.zeros(shape), np.zeros(shape, bool)
    np.put_along_axis(whole, index, x, axis=1)
    np.put_along_axis(here, index, True, axis=1)
    large = np.abs(whole) > BOTH
    for bias, scale in PAIRS:
        out |= large[:, bias] & large[:, scale]
    for r in np.flatnonzero(here[:, receiver_filter.COLUMNS].all(axis=1)):
        out[r] |= receiver_filter.none(index[r], x[r]).any()
    return out


@dataclass(frozen=True)
class Regression:
    """Information (P, P) and score (P,) of all columns, for total values; temper: by how much
    innovations left over are larger, or more alike from one to the next, than white ones of unit
    variance; spread (P, P): sum of the squares of the scores of `blocks` stretches, each by itself.
    """

    information: np.ndarray
    score: np.ndarray
    temper: float
    count: int
    spread: np.ndarray | None = None
    blocks: int = 0

    def solve(self, index: ArrayLike) -> tuple[Array, Array, float]:
        """Values, covariance and gain (nats, tempered) of a set of columns."""
        return self._free(index)[:3]

    def sd(self, index: ArrayLike) -> Array:
        """Standard deviations (k,) of the values of a set, such that 1.96 of them are an interval
        of 95 %: the likelihood's, or those of the sandwich where they are larger (Huber 1967; over
        blocks, within which innovations may be correlated, Liang and Zeger 1986), with Student's
        quantile for few blocks.
        """
        _, cov, _, part = self._free(index)
        own = np.diag(cov)
        if self.spread is None or self.blocks < FEWEST_BLOCKS:
            return np.sqrt(own)
        index = np.asarray(index, int)
        scores = self.spread[np.ix_(index, index)] / self.temper**2
        robust = np.einsum("ij,jk,ki->i", cov, scores, cov) * self.blocks / (self.blocks - 1)
        robust *= (float(student.ppf(0.975, self.blocks - 1)) / 1.96) ** 2
        return np.sqrt(np.where(part, np.maximum(own, robust), own))

    def told(self, index: ArrayLike) -> tuple[Array, Array]:
        """Values and standard deviations, as of `sd`, of a set that has been named: a value that is
        seen well and beyond its prior shows the prior to be too narrow, and is not drawn to nothing
        by it (the prior's width by maximum likelihood, at least what it was: Efron 2010, 1.2).
        """
        index = np.asarray(index, int)
        x, cov, _, part = self._free(index)
        sd = self.sd(index)
        prior = columns.PRIOR[index]
        wide = part & (np.abs(x) > prior) & (np.sqrt(np.diag(cov)) < 0.5 * prior)
        if not wide.any():
            return x, sd
        free, width = index[part], np.where(wide, np.abs(x), prior)[part]
        less = np.linalg.inv(
            self.information[np.ix_(free, free)] / self.temper + np.diag(width**-2)
        )
        grown = np.ones(index.size)
        grown[part] = np.sqrt(np.diag(less) / np.diag(cov)[part])
        x[part] = less @ self.score[free] / self.temper
        return x, sd * grown

    def _free(self, index: ArrayLike) -> tuple[Array, Array, float, Array]:
        """Values, covariance, gain, and mask of the values that are free: what asks for one that
        its name does not have is something else.
        """
        index = np.asarray(index, int)
        part = np.ones(index.size, bool)
        if not index.size:
            return np.zeros(0), np.zeros((0, 0)), 0.0, part
        x, cov, gain = self.solved(index)
        for _ in range(4):
            away = (np.abs(x) > LIMIT[index]) | cancelling(index, x, cov)
            away |= receiver_filter.none(index, x)
            if not away.any():
                break
            part &= ~away
            rest = index[part]
            y, c, gain = self.solved(rest)
            x, cov = np.zeros(index.size), np.diag(columns.PRIOR[index] ** 2)
            x[part], cov[np.ix_(part, part)] = y, c
        return x, cov, gain, part

    def gains(self, sets: Sequence[Sequence[int]]) -> Array:
        """The gain of `solve` for each of many sets of columns, which costs a fraction where no
        value meets a limit.
        """
        whole, score = self._scaled
        out, sizes = np.zeros(len(sets)), np.array([len(s) for s in sets], int)
        for size in np.unique(sizes[sizes > 0]):
            rows = np.flatnonzero(sizes == size)
            index = np.array([s for s in sets if len(s) == size], int)
            b = score[index]
            x = np.linalg.solve(whole[index[:, :, None], index[:, None, :]], b[..., None])[..., 0]
            out[rows] = 0.5 * np.einsum("rk,rk->r", b, x)
            for r in np.flatnonzero(_meets_a_limit(index, x)):
                out[rows[r]] = self.solve(index[r])[2]
        return out

    @cached_property
    def seen(self) -> Array:
        """Mask (P,) of the columns that do anything on the drive."""
        return np.asarray(np.diag(self.information) > 0.0)

    @cached_property
    def counted(self) -> Array:
        """Mask (P,) of those of which the drive shows more than their priors do."""
        return np.asarray(np.diag(self.information) * columns.PRIOR**2 > self.temper)

    @cached_property
    def _scaled(self) -> tuple[Array, Array]:
        """Tempered information with the priors', and score, of values in prior widths."""
        a = self.information / self.temper * np.outer(columns.PRIOR, columns.PRIOR)
        return a + np.eye(len(columns.PRIOR)), self.score / self.temper * columns.PRIOR

    def solved(self, index: Array) -> tuple[Array, Array, float]:
        """As `solve`, without limits."""
        if not index.size:
            return np.zeros(0), np.zeros((0, 0)), 0.0
        prior, (whole, score) = columns.PRIOR[index], self._scaled
        b = score[index]
        factor = cho_factor(whole[np.ix_(index, index)])
        x = cho_solve(factor, b)
        cov = cho_solve(factor, np.eye(index.size)) * np.outer(prior, prior)
        return x * prior, cov, 0.5 * float(b @ x)


def gains(state: State, result: Innovations, prior: Array) -> tuple[Array, Array]:
    """Nats that each of some effects asked about in turn gains alone, (k,), and its values, (k, p):
    `result` has sensitivities to the p parameters of each, of these prior widths, side by side.
    """
    good = state.use & np.isfinite(result.e)
    assert result.jac is not None, "innovations without sensitivities"
    e, j = result.e[good], result.jac[good]
    width, temper = prior.size, state.reg.temper
    found, values = np.zeros(j.shape[1] // width), np.zeros((j.shape[1] // width, width))
    for k in range(found.size):
        part = j[:, width * k : width * (k + 1)] * prior
        b = part.T @ e / temper
        x = np.linalg.solve(part.T @ part / temper + np.eye(width), b)
        found[k], values[k] = 0.5 * float(b @ x), prior * x
    return found, values


def of(
    problem: Problem, result: Innovations, theta: Array, use: Array, noisy: Array | None = None
) -> Regression:
    """From innovations with sensitivities at held values `theta`; noisy (f, 6, 6): of
    `in_variables.squares`, what of the sensitivities is noise.
    """
    good = use & np.isfinite(result.e)
    assert result.jac is not None, "innovations without sensitivities"
    e, j = result.e[good], result.jac[good]
    square = np.zeros((e.size, 6)) if noisy is None else noisy[good]
    total = e + j @ theta

    information, score = j.T @ j, j.T @ total - in_variables.bias(square.sum(axis=0))
    plain = Regression(information, score, 1.0, e.size)
    seen = np.flatnonzero(np.diag(information) > 0.0)
    x = np.zeros(theta.size)
    x[seen] = plain.solve(seen)[0]
    left = total - j @ x
    # what lies far out even then is not let decide (Huber 1964)
    size = max(1.0, 1.48 * float(np.median(np.abs(left))))
    weight = np.minimum(1.0, HUBER * size / np.maximum(np.abs(left), 1e-12))
    if np.mean(weight < 1.0) > 1e-3:
        root = np.sqrt(weight)
        j *= root[:, None]
        total, e, square = total * root, e * root, square * weight[:, None]
        information, score = j.T @ j, j.T @ total - in_variables.bias(square.sum(axis=0))
        x[seen] = Regression(information, score, 1.0, e.size).solve(seen)[0]
        left = total - j @ x
    time = np.broadcast_to(problem.time[:, None], good.shape)[good]
    block = ((time - time[0]) / BLOCK).astype(int)
    begins = np.flatnonzero(np.diff(block, prepend=-1))
    ends = np.append(begins[1:], left.size)
    both = np.stack([left, e])
    sums = np.array([both[:, a:b] @ j[a:b] for a, b in zip(begins, ends)])
    sums -= in_variables.bias(np.add.reduceat(square, begins))[:, None]
    ratios = np.sum(sums[:, 0, seen] ** 2, axis=0) / np.diag(information)[seen]
    temper = max(1.0, float(np.mean(left**2)), float(np.median(ratios)))
    spread = sums[:, 1].T @ sums[:, 1]  # about what is held: with all columns free, less is left
    return Regression(information, score, temper, e.size, spread, len(begins))
