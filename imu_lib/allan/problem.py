"""A template against an Allan curve: design, covariance and misfit, and the iterated fit of one
start.

The Allan variance is linear in the squared amplitudes and smooth in the time constants. For time
constants held, the squared amplitudes follow from non-negative generalised least squares; the time
constants follow by minimising what is left. The covariance of the estimates depends on the model
itself (imu_lib.allan.covariance), so it is taken at the fit, and fit and covariance are iterated
until they agree: the weights then come from the smooth model, not from the scattered curve, which
keeps the solution unbiased.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import linalg, optimize

from imu_lib.allan.covariance import Quadrature
from imu_lib.allan.deviation import AllanCurve
from imu_lib.arrays import Array
from imu_lib.errors import UndefinedFormError
from imu_lib.processes import LowPass, Process, Sum


class Terms:
    """The terms of a template: what is free in each, and its Allan variance and density at unit
    amplitude.

    With `filtered`, one more free term of variance -3 q^2 / tau^2: what any short filter on white
    noise takes away at averaging times beyond its length.
    """

    def __init__(self, template: Sum | Process, *, filtered: bool = False) -> None:
        self.template = template if isinstance(template, Sum) else Sum((template,))
        self.linear: list[tuple[int, str, str | None]] = []
        self.shape: list[tuple[int, str, str]] = []
        labels = {(index, name): label for label, index, name in self.template.labels()}
        for t, process in enumerate(self.template.terms):
            for p in process.parameters:
                if getattr(process, p.name) is None and not p.optional:
                    size = p.kind == "amplitude" or process.name == "ramp"
                    if not size and p.kind not in ("time", "frequency", "rate"):
                        raise ValueError(
                            f"`terms`: give {process.name} its `{p.name}`; an Allan curve cannot "
                            "fit it"
                        )
                    (self.linear if size else self.shape).append((t, p.name, labels[t, p.name]))
        if not self.linear and not self.shape:
            raise ValueError(
                "`terms` leaves nothing to fit: leave the parameters to be estimated at None"
            )
        self.filtered = filtered
        if filtered:
            self.linear.append((len(self.template.terms) + 1, "Q", None))
        self.filter = tuple(s for s in self.template.stages if isinstance(s, LowPass))
        self.stages = tuple(s for s in self.template.stages if not isinstance(s, LowPass))
        self.cache: dict[Any, Any] = {}

    def model(self, shape: Array, squares: Array) -> Sum:
        """The complete sum for log shape parameters and squared amplitudes."""
        values = {
            label: float(np.exp(v)) for (_, _, label), v in zip(self.shape, shape, strict=True)
        }
        values |= {
            label: float(np.sqrt(max(c, 0.0)))
            for (_, _, label), c in zip(self.linear, squares, strict=True)
            if label
        }
        return self.template.with_values(values)

    def variances(self, shape: Array, tau: Array, fs: float) -> Array:
        """Allan variance (terms + 1, j) at unit amplitude; after the terms, what the stages add."""
        rows = [
            self._kept("variance", t, own, lambda one: one.avar(tau, fs))
            for t, own in self._shapes(shape)
        ]
        return np.array([*rows, -3 / tau**2] if self.filtered else rows)

    def densities(self, shape: Array, f: Array, fs: float) -> Array:
        """Density (terms + 1, k) at unit amplitude; after the terms, that of the stages."""

        def density(one: Sum) -> Array:
            try:
                return one.psd(f, fs)
            except UndefinedFormError:  # a ramp, a sinusoid: no random part
                return np.zeros(f.shape)

        rows = [self._kept("density", t, own, density) for t, own in self._shapes(shape)]
        return np.array([*rows, -8 * fs * np.sin(np.pi * f / fs) ** 2] if self.filtered else rows)

    def _shapes(self, shape: Array) -> list[tuple[int | None, tuple[float, ...]]]:
        """Each term with its own log shape parameters; None for the stages."""
        values = list(zip(self.shape, shape, strict=True))
        own = [
            (t, tuple(float(v) for (s, _, _), v in values if s == t))
            for t in range(len(self.template.terms))
        ]
        return [*own, (None, ())]

    def _kept(
        self, what: str, t: int | None, shape: tuple[float, ...], form: Callable[[Sum], Array]
    ) -> Array:
        """A closed form of one term at unit amplitude, reckoned once."""
        key = what, t, shape
        if key not in self.cache:
            if len(self.cache) > 600:
                self.cache.clear()
            self.cache[key] = form(Sum((), self.stages) if t is None else self._unit(t, shape))
        return self.cache[key]

    def _unit(self, t: int, shape: tuple[float, ...]) -> Sum:
        """One term at unit amplitude, behind the filter unless it is too slow to be touched."""
        values = dict(
            zip([name for s, name, _ in self.shape if s == t], np.exp(shape), strict=True)
        )
        values |= {name: 1.0 for s, name, _ in self.linear if s == t}
        term = self.template.terms[t].with_(**values)
        lowest = min((s.cutoff for s in self.filter), default=0)
        slow = getattr(term, "correlation_time", 0) * lowest > 20
        return Sum((term,), () if slow else self.filter)


class Problem:
    """One curve against one template: design, covariance and misfit in log shape parameters and
    squared amplitudes.

    `discrepancy` is a relative error of the model itself, independent at each averaging time.
    """

    def __init__(
        self, curve: AllanCurve, terms: Terms, index: Array, discrepancy: float = 0.0
    ) -> None:
        self.discrepancy = discrepancy
        # a time constant below a few samples is white noise, one beyond the record a walk
        self.bounds = np.log(
            np.array([5 * curve.tau[index[0]], max(curve.duration, 10 * curve.tau[index[0]])])
        )
        kinds = [
            {p.name: p.kind for p in terms.template.terms[t].parameters}[name]
            for t, name, _ in terms.shape
        ]
        self.sign = np.array(
            [1.0 if kind == "time" else -1.0 for kind in kinds]
        )  # a frequency is an inverse time
        self.terms, self.tau, self.fs = terms, curve.tau[index], curve.fs
        self.v = curve.avar[index]
        self.edf = curve.edf[index]
        self.quad = Quadrature(curve.m[index], curve.samples, curve.n[index], curve.fs)
        self.free = [t for t, _, _ in terms.linear]
        self.held = [t for t in range(len(terms.template.terms) + 1) if t not in self.free]
        self.active = np.ones(len(terms.linear), dtype=bool)  # terms that are in the fit at all

    def moving(self) -> Array:
        """Which shape parameters are fitted: all but those of a term that is out, (s,) of bool."""
        out = {t for t, here in zip(self.free, self.active, strict=True) if not here}
        return np.array([t not in out for t, _, _ in self.terms.shape], dtype=bool)

    def design(self, shape: Array) -> tuple[Array, Array]:
        """Allan variance of the free terms (j, terms) and of what is held (j,)."""
        avar = self.terms.variances(shape, self.tau, self.fs)
        return avar[self.free].T, avar[self.held].sum(axis=0)

    def predict(self, shape: Array, squares: Array) -> Array:
        """Allan variance of the model (j,)."""
        basis, held = self.design(shape)
        return basis @ squares + held

    def covariance(self, shape: Array, squares: Array) -> Array:
        """Covariance of the estimates under the model (j, j), with a ramp's cross terms."""
        avar = self.terms.variances(shape, self.tau, self.fs)
        density = self.terms.densities(shape, self.quad.f, self.fs)
        weight = np.ones(len(avar))
        weight[self.free] = squares
        total = weight @ density
        if self.terms.filtered:  # no filter takes away more than there is
            total = np.maximum(total, 1e-3 * np.maximum(density, 0).T @ weight)
        out = self.quad.covariance(total)
        trend = np.maximum(weight @ np.where(np.any(density, axis=1)[:, None], 0.0, avar), 0.0)
        if trend.any():
            mean = np.sqrt(trend)
            out += 4 * np.outer(mean, mean) * self.quad.mean_covariance(total)
        if self.discrepancy:
            out[np.diag_indices_from(out)] += (self.discrepancy * (weight @ avar)) ** 2
        return out

    def whitener(self, covariance: Array) -> Array:
        """Inverse square root of the covariance; eigenvalues of the correlation below 1e-4 are
        lifted to that.
        """
        scale = np.sqrt(np.maximum(np.diag(covariance), (1e-9 * self.v) ** 2))
        value, vector = linalg.eigh(covariance / np.outer(scale, scale))
        return (vector / np.sqrt(np.maximum(value, 1e-4))).T / scale

    def solve(self, shape: Array, white: Array) -> tuple[Array, float]:
        """Squared amplitudes >= 0 and the misfit at held shape."""
        basis, held = self.design(shape)
        a, b = white @ basis, white @ (self.v - held)
        norm = np.linalg.norm(a, axis=0)
        squares = np.zeros(norm.size)
        found, rest = optimize.nnls((a / norm)[:, self.active], b)
        squares[self.active] = found
        return squares / norm, rest**2

    def information(self, shape: Array, squares: Array, moving: Array | None = None) -> Array:
        """Covariance of the logarithms of the amplitudes and shape parameters at this model (p,
        p).

        Rows and columns follow `terms.linear`, then `terms.shape`; what is not in the fit has
        zeros. `moving` says which shape parameters are uncertain, by default those of the terms in
        the fit.
        """
        white = self.whitener(self.covariance(shape, squares))
        basis, _ = self.design(shape)
        columns = [2 * basis * squares]
        for step in 1e-3 * np.eye(shape.size):
            rise = (self.design(shape + step)[0] - self.design(shape - step)[0]) @ squares / 2e-3
            columns.append(rise[:, None])
        kept = np.flatnonzero(
            np.concatenate([self.active, self.moving() if moving is None else moving])
        )
        jacobian = white @ np.hstack(columns)[:, kept]
        norm = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-150)
        jacobian = jacobian / norm
        inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-13, hermitian=True) / np.outer(
            norm, norm
        )
        out = np.zeros((basis.shape[1] + shape.size,) * 2)
        out[np.ix_(kept, kept)] = inverse
        return out

    def first_whitener(self) -> Array:
        """For the starts: the curve's own scatter, as if averaging times were independent."""
        return np.diag(np.sqrt(self.edf / 2) / self.v)


def iterate(
    problem: Problem, shape: Array, *, rounds: int = 15, white: Array | None = None
) -> tuple[Array, Array, float, float]:
    """Fit and covariance in turn from one start: shape, squares, misfit, misfit + log determinant.

    With `white` given, that covariance is kept.
    """
    held = white is not None
    inverse = problem.first_whitener() if white is None else white
    squares, _ = problem.solve(shape, inverse)
    last = None
    for _ in range(rounds):
        if not held:
            inverse = problem.whitener(problem.covariance(shape, squares))
        shape = _best_shape(problem, shape, inverse)
        squares, misfit = problem.solve(shape, inverse)
        now = np.concatenate([np.exp(shape), np.sqrt(squares)])
        if held or last is not None and np.allclose(now, last, rtol=1e-3, atol=0):
            break
        last = now
    return shape, squares, misfit, misfit - 2 * np.linalg.slogdet(inverse)[1]


def _best_shape(problem: Problem, shape: Array, white: Array) -> Array:
    """Shape parameters of least misfit under a given covariance, near `shape`."""
    moving = problem.moving()

    def put(part: Array) -> Array:
        out = shape.copy()
        out[moving] = problem.sign[moving] * np.clip(problem.sign[moving] * part, *problem.bounds)
        return out

    def rest(part: Array) -> float:
        return problem.solve(put(part), white)[1]

    start = shape[moving]
    if start.size == 0:
        return shape
    if start.size == 1:
        return put(
            optimize.minimize_scalar(
                rest,
                method="bounded",
                bounds=(start[0] - 1.2, start[0] + 1.2),
                options={"xatol": 1e-4},
            ).x
        )
    simplex = np.vstack([start, start + 0.1 * np.eye(start.size)])
    return put(
        optimize.minimize(
            rest,
            start,
            method="Nelder-Mead",
            options={"xatol": 1e-4, "fatol": 1e-6, "initial_simplex": simplex},
        ).x
    )
