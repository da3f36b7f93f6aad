"""One fit of a whole model to a whole record."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.processes import LowPass, Sum

from .drifts import solve_drifts
from .evaluate import as_sum, goodness
from .intervals import intervals
from .maximise import maximise
from .problem import Problem
from .statistics import Statistics


@dataclass(frozen=True)
class Fit:
    """What `fit` returns.

    Attributes
    ----------
    model : Sum
        The maximum-likelihood model, every parameter with a value; a term whose amplitude is zero
        is left out.
    parameters : dict of str to Estimate
        By the label of the template (`N`, `sigma`, `correlation_time`, `sigma_2`, ...), 95 %
        intervals by the profile of the likelihood. `value` is None where the record does not show
        the term.
    labels, covariance : tuple of str, ndarray (k, k)
        Inverse Fisher information of the logarithms of the free parameters.
    loglike, aic, bic : float
        Up to the same constant for every model of these statistics; BIC counts the statistics, not
        the samples.
    p_value : float
        Goodness of fit.
    expected : ndarray, shape (b,)
        Density under the model in the bands of `statistics`, unit^2/Hz.
    power : ndarray, shape (b,)
        Ordinate sums with the fitted drifts taken out.
    """

    model: Sum
    parameters: dict[str, Estimate]
    labels: tuple[str, ...]
    covariance: np.ndarray = field(repr=False)
    loglike: float
    aic: float
    bic: float
    p_value: float
    theta: np.ndarray = field(repr=False)
    expected: np.ndarray = field(repr=False)
    power: np.ndarray = field(repr=False)
    statistics: Statistics = field(repr=False)
    template: Sum = field(repr=False)

    def __getitem__(self, label: str) -> Estimate:
        return self.parameters[label]

    @property
    def free(self) -> int:
        """Number of fitted parameters."""
        return len(self.parameters)


def fit(
    x: Any,
    fs: Any,
    model: Any,
    *,
    starts: Any = (),
    temperature: Array | None = None,
    estimates: bool = True,
    grid: bool = True,
) -> Fit:
    """Fit a sum of processes by maximum likelihood.

    Parameters
    ----------
    x : ndarray, shape (n,), or Statistics
    fs : float
        Rate, Hz (None with Statistics).
    model : Sum or Process
        Parameters that are None are estimated, the others are held.
    starts : sequence of Sum
        Complete models to start from, besides the built-in grid over times and frequencies.
    temperature : ndarray, shape (n,), optional
        For a temperature term, degC.
    estimates : bool
        False leaves the profile intervals out (model choice needs the maximum only).
    grid : bool
        False climbs from `starts` alone: a refit near a known optimum in a few milliseconds.

    Raises
    ------
    ValueError
        If a parameter can't be fitted or nothing is left to explain the noise.
    UndefinedFormError
        For an output stage without a spectrum.
    """
    stats = x if isinstance(x, Statistics) else Statistics.of(x, fs)
    template = as_sum(model)
    if not template.noise.terms:
        raise ValueError("`model` needs at least one random process")
    noise = template.noise
    given = [vector(noise, start) for start in starts]
    drifts = solve_drifts(stats, template, temperature, given)
    problem = Problem.of(drifts.stats, noise, drifts.regressors)
    theta, value, information = maximise(problem, [*given, *drifts.starts], grid=grid or not given)
    found, theta, value, information = (
        intervals(problem, theta, value, information)
        if estimates
        else (plain(problem, theta), theta, value, information)
    )
    return _fitted(template, stats, drifts, problem, (theta, value, information), found)


def _fitted(
    template: Sum,
    stats: Statistics,
    drifts: Any,
    problem: Problem,
    at: tuple[Array, float, Array],
    found: dict[str, Estimate],
) -> Fit:
    """The fit whose maximum lies `at` (theta, log-likelihood, information), with what was `found`
    of its parameters.
    """
    theta, value, information = at
    expected = problem.density(theta)
    power = problem.remaining(expected)
    fitted, drift_estimates = drifts.finish(expected)
    parameters = {**found, **drift_estimates}
    zero = theta <= problem.floors(theta) + 1e-6
    values = {u.label: float(np.exp(t)) for u, t in zip(problem.free, theta)}
    complete = template.noise.with_values(values)
    gone = {u.index for u, z in zip(problem.free, zero) if z and u.amplitude}
    entries = [p for i, p in enumerate(complete) if i not in gone]
    best = Sum.of([*entries, *fitted])
    k = len(problem.free) + len(drift_estimates)
    count = len(stats.power)
    return Fit(
        best,
        parameters,
        tuple(u.label for u in problem.free),
        np.linalg.pinv(information, hermitian=True),
        float(value),
        float(2 * k - 2 * value),
        float(k * np.log(count) - 2 * value),
        goodness(stats, expected, k, power),
        theta,
        expected,
        power,
        stats,
        template,
    )


def vector(noise: Sum, start: Any) -> Array:
    """Logarithms of a start model's values for the unknowns of the template, in their order."""
    start = as_sum(start).noise
    known = {label: getattr(list(start)[index], name) for label, index, name in start.labels()}
    out = []
    for label, index, name in noise.labels():
        process = list(noise)[index]
        parameter = next(p for p in process.parameters if p.name == name)
        if getattr(process, name) is None and (
            not parameter.optional
            or (isinstance(process, LowPass) and name == "cutoff" and process.tunable)
        ):
            if not known.get(label):
                raise ValueError(f"`starts`: the start model has no value for `{label}`")
            out.append(np.log(known[label]))
    return np.array(out)


def plain(problem: Problem, theta: Array) -> dict[str, Estimate]:
    """Estimates without intervals: the maximum alone."""
    return {u.label: Estimate(float(np.exp(t)), 0.0, np.inf) for u, t in zip(problem.free, theta)}
