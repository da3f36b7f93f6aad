"""Deterministic terms in the fit: their amplitudes by generalised least squares, their times by
search.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.fft import idct
from scipy.optimize import minimize_scalar

from imu_lib.estimate import Estimate
from imu_lib.processes import Sum

from .maximise import maximise
from .problem import Problem
from .statistics import Regressors, Statistics


@dataclass
class Drifts:
    """The drifts of a template, ready to be solved with the noise."""

    stats: Statistics
    regressors: Regressors | None
    starts: list = field(default_factory=list)
    terms: list = field(default_factory=list)
    widths: list = field(default_factory=list)
    labels: list = field(default_factory=list)
    known: list = field(default_factory=list)
    searched: dict = field(default_factory=dict)

    def finish(self, expected):
        """(fitted drift processes, estimates by label) under the final density."""
        if self.regressors is None:
            return self.known, {}
        amplitude, covariance = self.regressors.solve(expected)
        fitted, estimates, at = list(self.known), {}, 0
        for term, width, labels in zip(self.terms, self.widths, self.labels):
            a, c = amplitude[at : at + width], covariance[at : at + width, at : at + width]
            at += width
            fitted.append(term.scaled(a))
            size = getattr(fitted[-1], term.linear)
            estimates[labels[term.linear]] = Estimate.normal(size, np.sqrt(a @ c @ a) / abs(size))
            for other, interval in self.searched.get(id(term), {}).items():
                estimates[labels[other]] = interval
        return fitted, estimates


def solve_drifts(stats, template, temperature, given):
    """Find the times of the drifts under the noise that fits best, and set their amplitudes up for
    solving.
    """
    terms = [(i, term) for i, term in enumerate(template.terms) if term.deterministic]
    known = [term for _, term in terms if _known(term)]
    t = np.arange(stats.n) / stats.rate if terms else None
    if known:
        stats = stats.subtract(Sum(tuple(known)).mean(t, temperature))
    unknown = [(i, term) for i, term in terms if not _known(term)]
    if not unknown:
        return Drifts(stats, None, known=known)
    labels = [
        {name: label for label, index, name in template.labels() if index == i} for i, _ in unknown
    ]
    fixed = [term.referred(temperature) for _, term in unknown]
    intervals = [{} for _ in fixed]
    open_ones = [
        j for j, term in enumerate(fixed) if term.searched and getattr(term, term.searched) is None
    ]
    theta = []
    for turn in range(3 if open_ones else 0):
        for j in open_ones:
            others = [
                term.shape(t, temperature)
                for i, term in enumerate(fixed)
                if i != j and (i not in open_ones or intervals[i])
            ]
            own = [fixed[j].shape(t, temperature)] if intervals[j] else []
            now = _best(stats, template.noise, others + own, [*given, *theta], grid=not theta)
            theta = [now[0]]
            free = stats
            if others:
                columns = np.hstack(others)
                free = stats.subtract(columns @ stats.regressors(columns).solve(now[2])[0])
            name = fixed[j].searched
            # under the noise that fits, and (a drift not yet found hides in the slow noise) under
            # a floor of it
            levels = (
                [now[2]]
                if turn
                else [
                    now[2],
                    np.full_like(now[2], np.min(now[2])),
                    np.sqrt(now[2] * np.min(now[2])),
                ]
            )
            tried = []
            for level in levels:
                value, interval = search(free, fixed[j], name, level, t)
                term = fixed[j].with_(**{name: value})
                refit = _best(
                    stats,
                    template.noise,
                    [*others, term.shape(t, temperature)],
                    [*given, *theta],
                    grid=not turn,
                )
                tried.append((refit[1], term, interval, refit[0]))
            _, fixed[j], interval, best = max(tried, key=lambda trial: trial[0])
            intervals[j], theta = {name: interval}, [best]
    columns = [term.shape(t, temperature) for term in fixed]
    searched = {id(term): interval for term, interval in zip(fixed, intervals)}
    return Drifts(
        stats,
        stats.regressors(np.hstack(columns)),
        theta,
        fixed,
        [c.shape[1] for c in columns],
        labels,
        known,
        searched,
    )


def _best(stats, noise, columns, given, grid):
    """(theta, log-likelihood, density) of the noise with these mean shapes solved for."""
    problem = Problem.of(stats, noise, stats.regressors(np.hstack(columns)) if columns else None)
    theta, value, _ = maximise(problem, given, grid=grid or not given, refine=2)
    return theta, value, problem.density(theta)


def _known(term):
    return getattr(term, term.linear) is not None and term.complete


def gain(stats, term, name, value, expected, t):
    """Log-likelihood that the drift gains with its searched parameter at `value`."""
    products = stats.regressors(term.with_(**{name: value}).shape(t))
    amplitude, _ = products.solve(expected)
    return 0.5 * float(amplitude @ (products.cross.T @ (1 / expected)))


def search(stats, term, name, expected, t):
    """Best value of the searched parameter and its 95 % interval (where the gain has fallen by
    1.92).
    """
    if name == "time":
        return step_time(stats, expected, t)
    if name == "frequency":
        first = stats.stretches[0]
        level = np.repeat(expected[: len(first.edges) - 1], np.diff(first.edges))
        inside = slice(first.edges[0] - 1, first.edges[-1] - 1)
        p = first.edges[0] + np.argmax(first.coefficients[inside] ** 2 / level)
        grid = (p + np.arange(-1.5, 1.6, 0.5)) * stats.rate / (2 * first.n)
    else:
        grid = np.geomspace(20 / stats.rate, stats.duration / 2, 12)
    gains = [gain(stats, term, name, g, expected, t) for g in grid]
    i = int(np.argmax(gains))
    low, high = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
    found = minimize_scalar(
        lambda v: -gain(stats, term, name, v, expected, t),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-5 * (high - low)},
    )
    best, top = float(found.x), -found.fun
    width = (high - low) / 8
    drop = [top - gain(stats, term, name, v, expected, t) for v in (best - width, best + width)]
    curvature = max(np.mean(drop), 1e-12) * 2 / width**2
    return best, Estimate.normal(best, min(1 / np.sqrt(curvature), best))


def step_time(stats, expected, t):
    """Time of a step: one inverse transform gives the gain at every sample."""
    s = max(stats.stretches, key=lambda s: s.n)
    at = (
        sum(len(q.edges) - 1 for q in stats.stretches[: stats.stretches.index(s)])
        if len(stats.stretches) > 1
        else 0
    )
    level = np.repeat(expected[at : at + len(s.edges) - 1], np.diff(s.edges))
    whitened = np.zeros(s.n)
    inside = slice(s.edges[0], s.edges[-1])
    whitened[inside] = s.coefficients[s.edges[0] - 1 : s.edges[-1] - 1] / level
    scale = np.sqrt(2 / stats.rate)
    score = np.cumsum(idct(whitened, norm="ortho")[::-1])[::-1] * scale
    probe = np.unique((s.n * (1 - np.cos(np.linspace(0.1, np.pi - 0.1, 41))) / 2).astype(int))
    p = np.arange(s.edges[0], s.edges[-1])
    norms = []
    for j in probe:  # coefficients of a unit step at sample j: a geometric sum of cosines
        step = (
            -np.sin(np.pi * p * j / s.n)
            / (2 * np.sin(np.pi * p / (2 * s.n)))
            * np.sqrt(2 / s.n)
            * scale
        )
        norms.append(np.sum(step**2 / level))
    norm = np.interp(np.arange(s.n), probe, norms)
    gains = 0.5 * score**2 / norm
    edge = max(2, s.n // 200)  # closer to an end than this the level on one side is hardly seen
    gains[:edge] = gains[-edge:] = 0.0
    best = int(np.argmax(gains))
    close = np.flatnonzero(gains > gains[best] - 1.920729)
    offset = s.start
    return float(t[best + offset]), Estimate(
        float(t[best + offset]), float(t[close[0] + offset]), float(t[close[-1] + offset])
    )
