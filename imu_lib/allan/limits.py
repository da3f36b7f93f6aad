"""Intervals of a joint Allan fit, and upper limits for what a record does not show.

The scatter of an Allan curve grows with the very parameters that are estimated: where a time constant comes out short
by chance, a standard error taken at the fit is too small as well. So the ends of an interval are where the estimate
lies 1.96 standard errors away with the error taken *there*, the other parameters moved along with it; amplitudes on
the scale of the cube root of their square, which makes a chi-square nearly normal (Wilson and Hilferty), time
constants on the logarithmic one.
"""

from __future__ import annotations

import numpy as np
from scipy import optimize

from imu_lib.allan import confidence
from imu_lib.allan.problem import iterate
from imu_lib.estimate import Z95, Estimate

ONE_SIDED = 1.6448536269514722  # 95 % point of the standard normal distribution


def drop_absent(problem, found, *, needed=2.706):
    """Take out, one after the other, terms without which the misfit grows by less than `needed`.

    2.706 is the 95 % point for an amplitude that cannot be negative. Returns shape, squares, misfit, criterion of
    what is left; `problem.active` tells which terms those are.
    """
    linear = problem.terms.linear
    while True:
        shape, squares, _, _ = found
        problem.active &= squares > 0
        sd = np.sqrt(np.diag(problem.information(shape, squares)))[:squares.size]
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


def estimates(problem, shape, squares):
    """Estimates of all free parameters by label, and of the flat level."""
    linear, shapes = problem.terms.linear, problem.terms.shape
    cov = problem.information(shape, squares)
    moving = problem.moving()
    parameters = {}
    for i, (_, _, label) in enumerate(linear):
        if label is None:  # what a filter takes away is no coefficient
            continue
        parameters[label] = (_ends(problem, shape, squares, cov, i) if problem.active[i]
                             else Estimate.absent(_upper(problem, shape, squares, i)))
    for k, (_, _, label) in enumerate(shapes):
        parameters[label] = (_ends(problem, shape, squares, cov, len(linear) + k) if moving[k]
                             else Estimate.absent())
    order = [label for label, *_ in problem.terms.template.labels() if label in parameters]
    return {label: parameters[label] for label in order}, _flat(problem, shape, squares, cov)


def _ends(problem, shape, squares, cov, i):
    """Interval of parameter i (amplitudes first, then shapes), its standard error taken at the ends."""
    k = squares.size
    value = np.sqrt(squares[i]) if i < k else np.exp(shape[i - k])
    power = 2 / 3 if i < k else 0.0
    change = cov[:, i] / cov[i, i]
    ends = []
    for sign in (-1, 1):
        sd = np.sqrt(cov[i, i])
        step = sign * Z95 * sd
        for _ in range(6 if sd > 0.02 else 0):
            step = np.clip(step, -4.0, 4.0)
            there = problem.information(shape + change[k:] * step, squares * np.exp(2 * change[:k] * step))
            sd = np.sqrt(there[i, i])
            new = _log_step(sign * Z95 * sd, power)
            if abs(new - step) < 0.01 * abs(step):
                break
            step = 0.5 * (step + new)
        ends.append(value * np.exp(step))
    return Estimate(float(value), float(ends[0]), float(ends[1]))


def _log_step(z, power):
    """ln(v0 / v) where v^p lies z p v0^p from v0^p (power 0: the logarithm itself)."""
    if not power:
        return z
    return -np.log(max(1 - z * power, 0.05)) / power


def _upper(problem, shape, squares, i):
    """95 % upper limit of an amplitude that is out of the fit; infinite where the record sets none.

    With c the squared amplitude, its estimate scatters like a chi-square of mean c + a with relative error r, a being
    what the other terms put in its place: standard error r (c + a). The limit is where the estimate that the term would
    have had (zero or too small to count) lies 1.645 standard errors down on the cube-root scale.
    """
    basis, _ = problem.design(shape)
    moving = problem.moving()
    white = problem.whitener(problem.covariance(shape, squares))
    problem.active[i] = True
    seen = problem.solve(shape, white)[0][i]

    def sd(c):
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


def flat_time(model, shortest, longest):
    """Averaging time, s, at which a sum's Allan deviation is flattest; where it has a Gauss-Markov process, on its bump."""
    tau = np.geomspace(shortest, longest, 400)
    markov = [p.correlation_time for p in model.terms if p.name.startswith("gauss_markov") and p.sigma]
    near = np.zeros(tau.size, dtype=bool)
    for time in markov:
        near |= (tau >= time) & (tau <= 6 * time)
    log = np.log(tau)

    def steepness(u, step=1e-3):
        ends = model.avar(np.exp(np.array([u - step, u + step])))
        return (np.log(ends[1] / ends[0]) / (2 * step)) ** 2

    slope = np.abs(np.gradient(np.log(model.avar(tau)), log))
    k = int(np.argmin(np.where(near if near.any() else True, slope, np.inf)))
    bounds = log[max(k - 1, 0)], log[min(k + 1, tau.size - 1)]
    return float(np.exp(optimize.minimize_scalar(steepness, bounds=bounds, method="bounded", options={"xatol": 1e-7}).x))


def _flat(problem, shape, squares, cov):
    """The model's Allan deviation where it is flattest; its interval by the delta method, the place moving along."""
    def log_deviation(log):
        k = squares.size
        model = problem.terms.model(log[k:], np.exp(2 * log[:k]))
        tau = flat_time(model, problem.tau[0], problem.tau[-1])
        return 0.5 * np.log(model.avar(np.array([tau]), problem.fs)[0])

    log = np.concatenate([0.5 * np.log(np.maximum(squares, 1e-300)), shape])
    moves = np.flatnonzero(np.diag(cov) > 0)
    gradient = np.zeros(log.size)
    for i in moves:
        step = np.zeros(log.size)
        step[i] = min(0.02, np.sqrt(cov[i, i]))
        gradient[i] = (log_deviation(log + step) - log_deviation(log - step)) / (2 * step[i])
    sd = np.sqrt(gradient @ cov @ gradient)
    level = float(np.exp(log_deviation(log)))
    low, high = confidence.interval(level, 1 / max(2 * sd**2, 1e-12))
    return Estimate(level, float(low), float(high))
