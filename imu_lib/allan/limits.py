"""Intervals of a joint Allan fit, and upper limits for what a record does not show.

The scatter of an Allan curve grows with the very parameters that are estimated: where a time
constant comes out short by chance, a standard error taken at the fit is too small as well. So the
ends of an interval are where the estimate lies 1.96 standard errors away with the error taken
*there*, the other parameters moved along with it; amplitudes on the scale of the cube root of
their square, which makes a chi-square nearly normal (Wilson and Hilferty), time constants on the
logarithmic one. The flat level is treated like an amplitude, its place moving along.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from imu_lib.allan.flat import flat_gradient, flat_time
from imu_lib.allan.problem import Problem, iterate
from imu_lib.arrays import Array
from imu_lib.estimate import Z95, Estimate
from imu_lib.processes import Sum

ONE_SIDED = 1.6448536269514722  # 95 % point of the standard normal distribution
AMPLITUDE = 2 / 3  # the power of an amplitude that is the cube root of its square


def drop_absent(
    problem: Problem, found: tuple[Array, Array, float, float], *, needed: float = 2.706
) -> tuple[Array, Array, float, float]:
    """Take out, one after the other, terms without which the misfit grows by less than `needed`.

    2.706 is the 95 % point for an amplitude that cannot be negative. Returns shape, squares,
    misfit, criterion of what is left; `problem.active` tells which terms those are.
    """
    linear = problem.terms.linear
    while True:
        shape, squares, _, _ = found
        problem.active &= squares > 0
        sd = np.sqrt(np.diag(problem.information(shape, squares)))[: squares.size]
        weak = [i for i in np.flatnonzero(problem.active) if sd[i] > 0.2 and linear[i][2]]
        trials = []
        for i in weak:
            if problem.active.sum() == 1:
                break
            problem.active[i] = False
            without = iterate(problem, shape)
            # both misfits against the covariance of the model without the term
            white = problem.whitener(problem.covariance(*without[:2]))
            alone = problem.solve(without[0], white)[1]
            problem.active[i] = True
            trials.append((alone - iterate(problem, shape, white=white)[2], i, without))
        if not trials or min(trials, key=lambda t: t[0])[0] > needed:
            return found
        _, i, found = min(trials, key=lambda t: t[0])
        problem.active[i] = False


def estimates(
    problem: Problem, shape: Array, squares: Array
) -> tuple[dict[str, Estimate], Estimate]:
    """Estimates of all free parameters by label, and of the flat level."""
    linear, shapes = problem.terms.linear, problem.terms.shape
    cov = problem.information(shape, squares)
    moving = problem.moving()
    parameters = {}

    def ends(i: int, value: float, power: float) -> Estimate:
        unit = np.eye(len(cov))[i]
        return _ends(problem, shape, squares, cov, value, lambda *_: unit, power)

    for i, (_, _, label) in enumerate(linear):
        if label is None:  # what a filter takes away is no coefficient
            continue
        parameters[label] = (
            ends(i, np.sqrt(squares[i]), AMPLITUDE)
            if problem.active[i]
            else Estimate.absent(_upper(problem, shape, squares, i))
        )
    for k, (_, _, label) in enumerate(shapes):
        parameters[label] = (
            ends(len(linear) + k, np.exp(shape[k]), 0.0) if moving[k] else Estimate.absent()
        )
    order = [label for label, *_ in problem.terms.template.labels() if label in parameters]
    return {label: parameters[label] for label in order}, _flat(problem, shape, squares, cov)


def _ends(
    problem: Problem,
    shape: Array,
    squares: Array,
    cov: Array,
    value: float,
    gradient: Callable[[Array, Array], Array],
    power: float,
) -> Estimate:
    """Interval of a positive quantity, its standard error taken at the ends.

    `gradient(shape, squares)` is the derivative of its logarithm by the logarithms of the
    amplitudes and shape parameters, (p,); on the scale of its power `power` (0: of its logarithm)
    its estimate is nearly normal.
    """
    slope = gradient(shape, squares)
    variance = slope @ cov @ slope
    if variance == 0:  # nothing that was estimated moves it: a level that is flat nowhere
        return Estimate(float(value), np.nan, np.nan)
    change = cov @ slope / variance
    k = squares.size
    ends = []
    for sign in (-1, 1):
        sd = np.sqrt(variance)
        step = sign * Z95 * sd
        for _ in range(6 if sd > 0.02 else 0):
            step = np.clip(step, -4.0, 4.0)
            there = shape + change[k:] * step, squares * np.exp(2 * change[:k] * step)
            slope = gradient(*there)
            sd = np.sqrt(slope @ problem.information(*there) @ slope)
            new = _log_step(sign * Z95 * sd, power)
            if abs(new - step) < 0.01 * abs(step):
                break
            step = 0.5 * (step + new)
        with np.errstate(over="ignore"):  # an end that is open above
            ends.append(value * np.exp(step))
    return Estimate(float(value), float(ends[0]), float(ends[1]))


def _log_step(z: float, power: float) -> float:
    """ln(v0 / v) where v^p lies z p v0^p from v0^p (power 0: the logarithm itself)."""
    if not power:
        return z
    return -np.log(max(1 - z * power, 0.05)) / power


def _upper(problem: Problem, shape: Array, squares: Array, i: int) -> float:
    """95 % upper limit of an amplitude that is out of the fit; infinite where the record sets
    none.

    With c the squared amplitude, its estimate scatters like a chi-square of mean c + a with
    relative error r, a being what the other terms put in its place: standard error r (c + a). The
    limit is where the estimate that the term would have had (zero or too small to count) lies
    1.645 standard errors down on the cube-root scale.
    """
    basis, _ = problem.design(shape)
    moving = problem.moving()
    white = problem.whitener(problem.covariance(shape, squares))
    problem.active[i] = True
    seen = problem.solve(shape, white)[0][i]

    def sd(c: float) -> float:
        trial = squares.copy()
        trial[i] = c
        return 2 * c * np.sqrt(problem.information(shape, trial, moving)[i, i])

    tiny = 1e-4 * np.min(problem.predict(shape, squares) / basis[:, i])
    floor = sd(tiny)
    c = seen + ONE_SIDED * floor
    for _ in range(25):
        r = max((sd(c) - floor) / c, 1e-3)
        shrink = 1 - ONE_SIDED * r / 3
        new = (seen + floor / r) * shrink**-3 - floor / r if shrink > 0.02 else np.inf
        if not np.isfinite(new) or abs(new - c) < 0.02 * c:
            c = new
            break
        c = np.sqrt(c * new)
    problem.active[i] = False
    return float(np.sqrt(c))


def _flat(problem: Problem, shape: Array, squares: Array, cov: Array) -> Estimate:
    """The model's Allan deviation where it is flat, the place moving along with the parameters."""
    model = problem.terms.model(shape, squares)
    first = flat_time(model, problem.tau[0], problem.tau[-1])
    moves = np.diag(cov) > 0

    def gradient(shape: Array, squares: Array) -> Array:
        log = np.concatenate([0.5 * np.log(np.maximum(squares, 1e-300)), shape])

        def model_of(moved: Array) -> Sum:
            every = log.copy()
            every[moves] = moved
            return problem.terms.model(every[squares.size :], np.exp(2 * every[: squares.size]))

        place = flat_time(model_of(log[moves]), problem.tau[0], problem.tau[-1], beside=first)
        out = np.zeros(log.size)
        out[moves] = flat_gradient(model_of, log[moves], place)
        return out

    level = np.sqrt(model.avar(np.array([first]), problem.fs)[0])
    return _ends(problem, shape, squares, cov, level, gradient, AMPLITUDE)
