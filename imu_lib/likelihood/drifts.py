"""Deterministic terms in the fit: their amplitudes by generalised least squares, their times by
search.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.processes import Sum
from imu_lib.processes.deterministic import Deterministic

from .drift_search import DriftSearch
from .regressors import Regressors
from .statistics import Statistics


@dataclass
class Drifts:
    """The drifts of a template, ready to be solved with the noise."""

    stats: Statistics
    regressors: Regressors | None
    starts: list[Any] = field(default_factory=list)
    terms: list[Any] = field(default_factory=list)
    widths: list[Any] = field(default_factory=list)
    labels: list[Any] = field(default_factory=list)
    known: list[Any] = field(default_factory=list)
    searched: dict[int, dict[str, Estimate]] = field(default_factory=dict)

    def finish(self, expected: Array) -> tuple[list[Any], dict[str, Estimate]]:
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


def solve_drifts(
    stats: Statistics, template: Sum, temperature: Array | None, given: list[Array]
) -> Drifts:
    """Find the times of the drifts under the noise that fits best, and set their amplitudes up for
    solving.
    """
    terms = [(i, d) for i, d in enumerate(template.terms) if isinstance(d, Deterministic)]
    known = [term for _, term in terms if _known(term)]
    if not terms:
        return Drifts(stats, None)
    t = np.arange(stats.n) / stats.rate
    if known:
        stats = stats.subtract(Sum(tuple(known)).mean(t, temperature))
    unknown = [(i, term) for i, term in terms if not _known(term)]
    if not unknown:
        return Drifts(stats, None, known=known)
    labels = [
        {name: label for label, index, name in template.labels() if index == i} for i, _ in unknown
    ]
    drifts = [term.referred(temperature) for _, term in unknown]
    found = DriftSearch(stats, template.noise, drifts, t, temperature)
    theta = found.run(given)
    columns = found.columns()
    searched = {id(term): interval for term, interval in zip(found.drifts, found.intervals)}
    return Drifts(
        stats,
        stats.regressors(np.hstack(columns)),
        theta,
        found.drifts,
        [c.shape[1] for c in columns],
        labels,
        known,
        searched,
    )


def _known(term: Deterministic) -> bool:
    return getattr(term, term.linear) is not None and term.complete
