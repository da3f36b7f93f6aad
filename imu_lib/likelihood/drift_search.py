"""Times and frequencies of drifts, found one drift after the other under the noise that fits
best.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.fft import idct
from scipy.optimize import minimize_scalar

from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.processes import Sum
from imu_lib.processes.deterministic import Deterministic

from .maximise import maximise
from .problem import Problem
from .statistics import Statistics

#: Rounds over the drifts whose parameter is searched: the first find them, the last settles them.
TURNS = 3


class DriftSearch:
    """Drifts, some with a parameter that is searched, beside the `noise` of a template."""

    def __init__(
        self,
        stats: Statistics,
        noise: Sum,
        drifts: Iterable[Deterministic],
        t: Array,
        temperature: Array | None,
    ) -> None:
        self.stats, self.noise, self.drifts = stats, noise, list(drifts)
        self.t, self.temperature = t, temperature
        self.intervals: list[dict[str, Estimate]] = [{} for _ in self.drifts]
        self.open = [
            j for j, d in enumerate(self.drifts) if d.searched and getattr(d, d.searched) is None
        ]

    def run(self, given: list[Array]) -> list[Array]:
        """Search them all; start vectors of the noise for the last fit, `given` ones beside."""
        theta: list[Array] = []
        for turn in range(TURNS if self.open else 0):
            for j in self.open:
                theta = [self._one(j, given, theta, turn)]
        return theta

    def columns(self) -> list[Array]:
        """Shapes of all drifts, each (n, q)."""
        return [self._shape(drift) for drift in self.drifts]

    def _shape(self, drift: Deterministic) -> Array:
        return drift.shape(self.t, self.temperature)

    def _one(self, j: int, given: list[Array], last: list[Array], turn: int) -> Array:
        """Set the parameter of drift `j`; the vector of the noise beside it, after the `last`."""
        others = [
            self._shape(drift)
            for i, drift in enumerate(self.drifts)
            if i != j and (i not in self.open or self.intervals[i])
        ]
        own = [self._shape(self.drifts[j])] if self.intervals[j] else []
        theta, _, density = self._best(others + own, [*given, *last], grid=not last)
        free = self.stats
        if others:
            columns = np.hstack(others)
            free = free.subtract(columns @ free.regressors(columns).solve(density)[0])
        name, tried = self.drifts[j].searched, []
        for level in _levels(density, turn):
            value, interval = search(free, self.drifts[j], name, level, self.t)
            drift = self.drifts[j].with_(**{name: value})
            beside = [*others, self._shape(drift)]
            again = self._best(beside, [*given, theta], grid=not turn)
            tried.append((again[1], drift, interval, again[0]))
        _, self.drifts[j], interval, best = max(tried, key=lambda trial: trial[0])
        self.intervals[j] = {name: interval}
        return best

    def _best(
        self, columns: list[Array], starts: list[Array], *, grid: bool
    ) -> tuple[Array, float, Array]:
        """(theta, log-likelihood, density) of the noise with these mean shapes solved for."""
        regressors = self.stats.regressors(np.hstack(columns)) if columns else None
        problem = Problem.of(self.stats, self.noise, regressors)
        theta, value, _ = maximise(problem, starts, grid=grid or not starts, refine=2)
        return theta, value, problem.density(theta)


def _levels(density: Array, turn: int) -> list[Array]:
    """Densities to search under: the one that fits, and at first (a drift not yet found hides in
    the slow noise) a floor of it.
    """
    if turn:
        return [density]
    floor = np.min(density)
    return [density, np.full_like(density, floor), np.sqrt(density * floor)]


def gain(
    stats: Statistics, term: Deterministic, name: str, value: float, expected: Array, t: Array
) -> float:
    """Log-likelihood that the drift gains with its searched parameter at `value`."""
    products = stats.regressors(term.with_(**{name: value}).shape(t))
    amplitude, _ = products.solve(expected)
    return 0.5 * float(amplitude @ (products.cross.T @ (1 / expected)))


def search(
    stats: Statistics, term: Deterministic, name: str, expected: Array, t: Array
) -> tuple[float, Estimate]:
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


def step_time(stats: Statistics, expected: Array, t: Array) -> tuple[float, Estimate]:
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
