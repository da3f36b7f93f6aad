"""Generalised method of wavelet moments: a sum of processes fitted to the Haar wavelet variance.

Guerrier, Skaloud, Stebler and Victoria-Feser (2013) match the wavelet variances nu of a record,
one per dyadic scale, with those of a model,

    theta = argmin (nu_hat - nu(theta))' Omega (nu_hat - nu(theta)),

consistent for any positive definite Omega and efficient among such estimators for Omega = V^-1, V
the covariance of nu_hat. The Haar wavelet variance of scale 2m is half the Allan variance at m
samples, so nu(theta) is the closed form that each process knows. V is taken under the model itself
and iterated; "diagonal" keeps its diagonal alone, which is what the authors' software does by
default.
"""

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.stats import chi2

from imu_lib.allan.covariance import Quadrature
from imu_lib.allan.problem import Terms
from imu_lib.estimate import Estimate
from imu_lib.processes import Process, Sum

FLOOR = 1e-9


@dataclass(frozen=True)
class WaveletVariance:
    """Haar wavelet variances of a record (maximal overlap).

    Attributes
    ----------
    m : ndarray of int, shape (j,)
        Half the wavelet's length, samples; the scale of the wavelet is 2 m.
    tau : ndarray, shape (j,)
        The same in s: the Allan averaging time.
    variance, low, high : ndarray, shape (j,)
        Wavelet variance, unit^2, and the 95 % interval for max(windows / 2m, 1) degrees of freedom
        (Percival 1995).
    windows : ndarray of int, shape (j,)
    samples : int
    fs : float, Hz
    """

    m: np.ndarray
    tau: np.ndarray
    variance: np.ndarray
    low: np.ndarray
    high: np.ndarray
    windows: np.ndarray
    samples: int
    fs: float


def wavelet_variance(x, fs):
    """Haar wavelet variances at every dyadic scale that leaves four windows' length,
    WaveletVariance.

    Raises
    ------
    ValueError
        If `x` has fewer than 16 samples or is not finite.
    """
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or len(x) < 16 or not np.isfinite(x).all():
        raise ValueError("`x` must be finite, one-dimensional and hold at least 16 samples")
    n = len(x)
    total = np.concatenate([[0.0], np.cumsum(x - x.mean())])
    m = 2 ** np.arange(int(np.log2(n / 4)) + 1)
    variance = np.array(
        [
            np.mean(
                ((total[2 * k :] - 2 * total[k : n + 1 - k] + total[: n + 1 - 2 * k]) / (2 * k))
                ** 2
            )
            for k in m
        ]
    )
    windows = n + 1 - 2 * m
    freedom = np.maximum(windows / (2 * m), 1.0)
    return WaveletVariance(
        m,
        m / fs,
        variance,
        variance * freedom / chi2.ppf(0.975, freedom),
        variance * freedom / chi2.ppf(0.025, freedom),
        windows,
        n,
        float(fs),
    )


@dataclass(frozen=True)
class WaveletFit:
    """A sum of processes fitted to wavelet variances.

    Attributes
    ----------
    model : Sum
    parameters : dict of str to Estimate
        95 % intervals, normal in the logarithm.
    predicted : ndarray, shape (j,)
        Wavelet variances of the model.
    misfit, dof, p_value : float, int, float
        Hansen's test of the over-identifying moments ("optimal" weights only; p_value is None
        otherwise).
    """

    model: Sum
    parameters: dict
    predicted: np.ndarray = field(repr=False)
    misfit: float
    dof: int
    p_value: float | None
    moments: WaveletVariance = field(repr=False)

    def __getitem__(self, label):
        return self.parameters[label]


class _Moments:
    """The template's wavelet variances and densities as functions of the logarithms of its
    unknowns.

    Unknowns are ordered amplitudes first, then times and frequencies, as
    `imu_lib.allan.problem.Terms` keeps them.
    """

    def __init__(self, moments, template):
        self.moments, self.terms = moments, Terms(template)
        self.unknown = [(label, True) for _, _, label in self.terms.linear]
        self.unknown += [(label, False) for _, _, label in self.terms.shape]
        self.amplitude = np.array([a for _, a in self.unknown])
        self.count = len(self.terms.linear)
        self.quadrature = Quadrature(moments.m, moments.samples, moments.windows, moments.fs)

    def parts(self, shape):
        """Wavelet variances of the free terms at unit amplitude, and of all that is held."""
        return self._split(self.terms.variances(shape, self.moments.tau, self.moments.fs) / 2)

    def _split(self, rows):
        """Rows of the free terms, and the sum of the others."""
        free = [t for t, _, _ in self.terms.linear]
        held = [t for t in range(len(rows)) if t not in free]
        return rows[free], rows[held].sum(axis=0)

    def model(self, theta):
        return self.terms.model(theta[self.count :], np.exp(2 * theta[: self.count]))

    def predict(self, theta):
        nu, held = self.parts(theta[self.count :])
        return np.exp(2 * theta[: self.count]) @ nu + held

    def jacobian(self, theta, step=1e-4):
        nu, _ = self.parts(theta[self.count :])
        columns = list(2 * np.exp(2 * theta[: self.count])[:, None] * nu)
        for k in range(self.count, len(theta)):
            e = step * np.eye(len(theta))[k]
            columns.append((self.predict(theta + e) - self.predict(theta - e)) / (2 * step))
        return np.stack(columns, axis=1)

    def covariance(self, theta):
        density, held = self._split(
            self.terms.densities(theta[self.count :], self.quadrature.f, self.moments.fs)
        )
        return self.quadrature.covariance(np.exp(2 * theta[: self.count]) @ density + held) / 4

    def starts(self, places=6):
        """Times over the range of scales, squared amplitudes by non-negative least squares on
        relative residuals.
        """
        axis = np.log(np.geomspace(4 / self.moments.fs, self.moments.tau[-1] / 2, places))
        for row in product(axis, repeat=len(self.terms.shape)):
            nu, held = self.parts(np.array(row))
            columns = (nu / self.moments.variance).T
            scale = columns.max(axis=0)
            squares = nnls(columns / scale, 1 - held / self.moments.variance)[0] / scale
            yield np.concatenate([0.5 * np.log(np.maximum(squares, 1e-6 / scale)), row])


def fit(x, fs, model, *, weights="optimal", starts=()):
    """Fit a sum of processes by the generalised method of wavelet moments.

    Parameters
    ----------
    x : ndarray, shape (n,), or WaveletVariance
    fs : float
        Rate, Hz (None with WaveletVariance).
    model : Sum or Process
        Parameters that are None are fitted.
    weights : "optimal" or "diagonal"
    starts : sequence of Sum
        Complete models to start from instead of the built-in grid.
    """
    if weights not in ("optimal", "diagonal"):
        raise ValueError(f"`weights` must be 'optimal' or 'diagonal', got {weights!r}")
    moments = x if isinstance(x, WaveletVariance) else wavelet_variance(x, fs)
    template = Sum((model,)) if isinstance(model, Process) and not isinstance(model, Sum) else model
    problem = _Moments(moments, template)
    if len(moments.m) <= len(problem.unknown):
        raise ValueError(
            f"`x` has {len(moments.m)} dyadic scales, too few for {len(problem.unknown)} parameters"
        )
    given = [np.log([_value(start, label) for label, _ in problem.unknown]) for start in starts]
    # weights as if the scales were independent: with equal ones the few windows of the longest
    # scales choose the start
    rough = np.diag(np.sqrt(np.maximum(moments.windows / (2 * moments.m), 1.0)) / moments.variance)
    first = [_descend(problem, theta, rough) for theta in given or problem.starts()]
    theta = min(first, key=lambda one: one.cost).x
    for _ in range(6):
        covariance = problem.covariance(theta)
        root = _root(covariance if weights == "optimal" else np.diag(np.diag(covariance)))
        found = _descend(problem, theta, root)
        done = np.max(np.abs(found.x - theta)) < 1e-3
        theta = found.x
        if done:
            break
    return _result(problem, theta, root, weights)


def _value(start, label):
    index, name = next((index, name) for known, index, name in start.labels() if known == label)
    return getattr(list(start)[index], name)


def _root(covariance):
    """R with R'R the inverse covariance; eigenvalues of the correlation below 1e-6 are lifted to
    that.
    """
    scale = np.sqrt(np.diag(covariance))
    value, vector = np.linalg.eigh(covariance / np.outer(scale, scale))
    return (vector / np.sqrt(np.maximum(value, 1e-6))).T / scale


def _descend(problem, theta, root):
    low, high = (
        np.where(problem.amplitude, -60.0, np.log(0.2 / problem.moments.fs)),
        np.where(problem.amplitude, 40.0, np.log(problem.moments.samples / problem.moments.fs)),
    )
    return least_squares(
        lambda t: root @ (problem.moments.variance - problem.predict(t)),
        np.clip(theta, low + 1e-6, high - 1e-6),
        jac=lambda t: -root @ problem.jacobian(t),
        bounds=(low, high),
        x_scale=1.0,
        max_nfev=100,
    )


def _result(problem, theta, root, weights):
    predicted, moments = problem.predict(theta), problem.moments
    slope, covariance = root @ problem.jacobian(theta), root @ problem.covariance(theta) @ root.T
    inverse = np.linalg.pinv(slope.T @ slope, hermitian=True)
    # the sandwich: right for any weights
    spread = inverse @ slope.T @ covariance @ slope @ inverse
    sd = np.sqrt(np.maximum(np.diag(spread), 0.0))
    estimates = {
        label: Estimate.lognormal(np.exp(t), s)
        for (label, _), t, s in zip(problem.unknown, theta, sd)
    }
    for k, (label, amplitude) in enumerate(problem.unknown):
        quiet = theta.copy()
        quiet[k] = -60.0
        if amplitude and np.max((predicted - problem.predict(quiet)) / predicted) < FLOOR**0.5:
            estimates[label] = Estimate.absent(estimates[label].high)
    residual = root @ (moments.variance - predicted)
    misfit, dof = float(residual @ residual), len(moments.m) - len(theta)
    return WaveletFit(
        problem.model(theta),
        estimates,
        predicted,
        misfit,
        dof,
        float(chi2.sf(misfit, dof)) if weights == "optimal" else None,
        moments,
    )
