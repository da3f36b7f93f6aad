"""The likelihood of a model, given the statistics of a record, and how well the model fits.

With P_b the summed ordinates of band b, m_b their number and S_b their expectation under the model,

    log L = -1/2 sum_b [ m_b log S_b + P_b / S_b ]

up to a constant that no model changes: a Gaussian likelihood of single coefficients at the slow
end, the gamma likelihood of the frequency-averaged periodogram at the fast end, in one formula.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import gammaincc, ndtri
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.processes import Constant, LowPass, Process, Sum

from .statistics import Statistics


def as_sum(model: Any) -> Sum:
    """A process or a sum as a sum, without the constant (the mean is a nuisance)."""
    model = (
        model if isinstance(model, Sum) else Sum((model,)) if isinstance(model, Process) else model
    )
    if not isinstance(model, Sum):
        raise ValueError(
            f"`model` must be a process or a sum of processes, got {type(model).__name__}"
        )
    return Sum(tuple(t for t in model.terms if not isinstance(t, Constant)), model.stages)


def density(stats: Statistics, noise: Sum) -> Array:
    """Expected mean ordinate of each band, shape (b,), unit^2/Hz, of the random terms behind the
    filter.
    """
    ends = sum(stats.layout.ends(term, noise.low_pass) for term in noise.terms)
    return stats.collapse(noise.psd(stats.grid, stats.rate)) + ends


#: Share of a model's own density that is left where coarse rounding takes some of it away.
LEAST_LEFT = 1e-3


def with_extra(density: Array, extra: Array | float) -> Array:
    """A model's `density` with what the electronics add to it; coarse rounding may add less than
    nothing, but leaves a rest.
    """
    return np.maximum(density + extra, LEAST_LEFT * density)


def gaussian(stats: Statistics, expected: Array, power: Array | None = None) -> Array:
    """log L from the expected mean ordinates, shape (..., b)."""
    power = stats.power if power is None else power
    return -0.5 * np.sum(stats.count * np.log(expected) + power / expected, axis=-1)


def without_mean(stats: Statistics, model: Any, temperature: Array | None = None) -> Statistics:
    """Statistics with the model's deterministic terms (ramp, sinusoid, warm-up, step, temperature)
    taken out.
    """
    drifts = model.drifts
    if not drifts.terms:
        return stats
    mean = drifts.mean(np.arange(stats.n) / stats.rate, temperature)
    if model.low_pass is not None:
        mean = model.low_pass.run(*_padded(mean, model.low_pass, stats))
    return stats.subtract(mean)


def _padded(mean: Array, low_pass: LowPass, stats: Statistics) -> tuple[Array, float, int]:
    steps, before = low_pass.grid(stats.rate)
    at = np.arange(stats.n * steps + before) / steps - before / steps
    return np.interp(at, np.arange(stats.n), mean), stats.rate, stats.n


def log_likelihood(stats: Statistics, model: Any, *, temperature: Array | None = None) -> float:
    """Log-likelihood of a complete model.

    Parameters
    ----------
    stats : Statistics
    model : Sum or Process
        Every parameter has a value. Random terms enter by their spectrum (behind the low-pass
        filter, with the variance that spikes and rounding add), deterministic ones by their mean.
    temperature : ndarray, shape (n,), optional
        For a temperature term, degC.

    Raises
    ------
    UndefinedFormError
        For an output stage that has no spectrum (saturation, stuck, a change of noise level).
    """
    model = as_sum(model)
    return float(gaussian(without_mean(stats, model, temperature), density(stats, model.noise)))


def residuals(stats: Statistics, model: Any, *, temperature: Array | None = None) -> Array:
    """Standard normal score of each band under the model, shape (b,): positive where the record
    has more power.
    """
    model = as_sum(model)
    return _scores(without_mean(stats, model, temperature), density(stats, model.noise))


def _scores(stats: Statistics, expected: Array, power: Array | None = None) -> Array:
    power = stats.power if power is None else power
    upper = np.clip(gammaincc(stats.count / 2, power / expected / 2), 1e-300, 1 - 1e-16)
    return -ndtri(upper)


def goodness(
    stats: Statistics,
    expected: Array,
    parameters: int,
    power: Array | None = None,
    *,
    per_decade: tuple[float, ...] = (2.5, 8),
) -> float:
    """p-value of the hypothesis that the record has this spectrum.

    Chi-square sums of normal scores over all bands and over `per_decade` bands a decade, where a
    smooth misfit adds up; the smallest of their p-values counts as the smallest of three (Sidak).

    Parameters
    ----------
    expected : ndarray, shape (b,)
    parameters : int
        Fitted parameters, taken off the degrees of freedom.
    """
    power = stats.power if power is None else power
    p_values = []
    for bins in (*(_bands(stats, width) for width in per_decade), np.arange(len(power))):
        total = np.bincount(bins, power / expected)
        count = np.bincount(bins, stats.count)
        keep = count > 0
        upper = np.clip(gammaincc(count[keep] / 2, total[keep] / 2), 1e-300, 1 - 1e-16)
        square = float(np.sum(ndtri(upper) ** 2))
        p_values.append(chi2.sf(square, max(int(keep.sum()) - parameters, 1)))
    return float(-np.expm1(3 * np.log1p(-min(min(p_values), 1 - 1e-16))))


def _bands(stats: Statistics, per_decade: float) -> Array:
    group = np.floor(np.log10(stats.frequency) * per_decade).astype(int)
    return np.unique(group, return_inverse=True)[1]


__all__ = [
    "Statistics",
    "as_sum",
    "density",
    "gaussian",
    "goodness",
    "log_likelihood",
    "residuals",
    "with_extra",
    "without_mean",
]
