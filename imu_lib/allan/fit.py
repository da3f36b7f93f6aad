"""Joint fit of a sum of processes to a whole Allan curve: the public door, the starts, and the
result.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from imu_lib.allan.deviation import AllanCurve
from imu_lib.allan.limits import drop_absent, estimates
from imu_lib.allan.problem import Problem, Terms, iterate
from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.processes import Process, Sum


@dataclass(frozen=True)
class AllanFit:
    """A sum of processes fitted to an Allan curve.

    Attributes
    ----------
    model : Sum
        The fitted sum; an amplitude that the record does not show is zero.
    parameters : dict of str to Estimate
        What was fitted, with 95 % intervals, by the labels of the sum (`N`, `sigma`,
        `correlation_time`, `sigma_2`).
    flat : Estimate
        The flat level: the fitted Allan deviation where it is flat (see `imu_lib.allan.flat`).
    misfit : float
        Generalised sum of squares of the residuals, about chi-square with `dof` degrees of
        freedom.
    dof : int
    p_value : float
        Probability of a misfit as large if the model is true.
    criterion : float
        Misfit + log determinant of the covariance + ln(j) per parameter: smaller is better among
        templates.
    tau, predicted, sd : ndarray, shape (j,)
        Averaging times that were fitted, the model's Allan deviation there, and the relative
        standard error that an estimate of it has under the model.
    """

    model: Sum
    parameters: dict[str, Estimate]
    flat: Estimate
    misfit: float
    dof: int
    p_value: float
    criterion: float
    tau: Array
    predicted: Array
    sd: Array

    def __getitem__(self, label: str) -> Estimate:
        return self.parameters[label]


def choose(
    curve: AllanCurve, *, ratio: float = 2.0, shortest: float = 0.0, longest: float = np.inf
) -> Array:
    """Indices of the averaging times that a fit uses: one an octave, beyond which
    more change the parameters' standard errors by less than a per cent."""
    ok = np.flatnonzero((curve.tau >= shortest) & (curve.tau <= longest) & (curve.adev > 0))
    if ok.size == 0:
        return ok
    log = np.log(curve.tau[ok])
    goal = log[0] + np.log(ratio) * np.arange(np.rint((log[-1] - log[0]) / np.log(ratio)) + 1)
    return ok[np.unique(np.abs(log[None, :] - goal[:, None]).argmin(axis=1))]


def fit(
    curve: AllanCurve,
    terms: Sum | Process,
    *,
    shortest: float = 0.0,
    longest: float = np.inf,
    filtered: bool = False,
) -> AllanFit:
    """Fit a sum of processes to an Allan curve by iterated generalised least squares.

    Parameters
    ----------
    curve : AllanCurve
    terms : Sum or Process
        The template: parameters at None are fitted, others held. Output stages (a low-pass filter,
        rounding) must be complete; they enter as they are.
    shortest, longest : float
        Range of averaging times to use, s.
    filtered : bool
        The sensor filters its output and the template does not say how: allow for what a short
        filter takes from white noise beyond its own length, and begin there (`shortest`).

    Returns
    -------
    AllanFit

    Raises
    ------
    ValueError
        Where the template leaves nothing to fit, or the range holds too few averaging times for
        it.
    """
    return _finished(*_found(curve, terms, shortest, longest, filtered))


def fit_best(
    curve: AllanCurve,
    templates: list[Sum],
    *,
    shortest: float = 0.0,
    longest: float = np.inf,
    filtered: bool = False,
    enough: float = 0.05,
    discrepancies: Sequence[float] = (0.0,),
) -> AllanFit:
    """The first of several templates that describes the curve (p-value above `enough`), or else
    the best of them.

    Best is the least criterion; with an infinite `enough` all templates compete. Other arguments
    as for `fit`; a template with too many parameters for the curve is passed over. `discrepancies`
    are relative errors of the Allan variance that are allowed to the model itself, taken in turn
    until the best template fits (p-value above 0.01): no sum of a few processes describes a real
    sensor to the thousandth that the shortest averaging times are known to, and without that
    allowance they would bend the fit everywhere else.

    Returns
    -------
    AllanFit
    """

    def p_value(tried: tuple[Any, ...]) -> float:
        return stats.chi2.sf(tried[1][2], tried[0].tau.size - tried[2])

    best: tuple[float, float, tuple[Any, ...]] | None = None
    for discrepancy in discrepancies:
        for template in templates:
            try:
                tried = _found(curve, template, shortest, longest, filtered, discrepancy)
            except ValueError:
                continue
            if p_value(tried) > enough:
                return _finished(*tried)
            criterion = tried[1][3] + tried[2] * np.log(tried[0].tau.size)
            if best is None or best[0] != discrepancy or criterion < best[1]:
                best = discrepancy, criterion, tried
        if best is None:
            raise ValueError("`curve` has too few averaging times to fit anything")
        if p_value(best[2]) > 0.01:
            break
    assert best is not None  # `discrepancies` is not empty
    return _finished(*best[2])


def _found(
    curve: AllanCurve,
    terms: Sum | Process,
    shortest: float,
    longest: float,
    filtered: bool,
    discrepancy: float = 0.0,
) -> tuple[Problem, tuple[Array, Array, float, float], int]:
    """Problem, (shape, squares, misfit, criterion) at the minimum, number of parameters."""
    template = Terms(terms, filtered=filtered)
    index = choose(curve, shortest=shortest, longest=longest)
    count = len(template.linear) + len(template.shape)
    if index.size <= count:
        raise ValueError(
            f"`curve` has {index.size} averaging times in the range, too few to fit {count} "
            "parameters"
        )
    problem = Problem(curve, template, index, discrepancy)
    found = min(
        (iterate(problem, start, rounds=2) for start in _starts(problem, curve)),
        key=lambda one: one[3],
    )
    return problem, iterate(problem, found[0]), count


def _finished(problem: Problem, found: tuple[Array, Array, float, float], count: int) -> AllanFit:
    """The result, with absent terms taken out and intervals."""
    shape, squares, misfit, criterion = drop_absent(problem, found)
    parameters, flat = estimates(problem, shape, squares)
    model = problem.terms.model(shape, squares)
    dof = problem.tau.size - count
    variance = np.diag(problem.covariance(shape, squares))
    predicted = problem.predict(shape, squares)
    return AllanFit(
        model,
        parameters,
        flat,
        float(misfit),
        int(dof),
        float(stats.chi2.sf(misfit, dof)),
        float(criterion + count * np.log(problem.tau.size)),
        problem.tau,
        np.sqrt(predicted),
        np.sqrt(variance) / predicted / 2,
    )


def _starts(problem: Problem, curve: AllanCurve, *, points: int = 16, best: int = 3) -> list[Array]:
    """Shape parameters to start from: the best few, well apart, of a logarithmic grid."""
    shape = problem.terms.shape
    if not shape:
        return [np.empty(0)]
    axis = np.log(
        np.geomspace(6 * problem.tau[0], max(curve.duration / 6, 12 * problem.tau[0]), points)
    )
    terms = problem.terms.template.terms
    grid = np.stack(
        [g.ravel() for g in np.meshgrid(*[sign * axis for sign in problem.sign], indexing="ij")],
        axis=1,
    )
    for i in range(1, len(shape)):  # twins among the terms in order of their time constants
        if (
            terms[shape[i][0]].name == terms[shape[i - 1][0]].name
            and shape[i][1] == shape[i - 1][1]
        ):
            grid = grid[grid[:, i] > grid[:, i - 1]]
    white = problem.first_whitener()
    misfit = np.array([problem.solve(p, white)[1] for p in grid])
    chosen: list[Array] = []
    for p in grid[np.argsort(misfit)]:
        if all(np.abs(p - q).max() > 1.5 * (axis[1] - axis[0]) for q in chosen):
            chosen.append(p)
        if len(chosen) == best:
            break
    return chosen
