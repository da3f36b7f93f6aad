"""How a coefficient is spread over the units of a fleet, apart from the error of its estimates.

Each unit's coefficient is positive; its logarithm is y_i, known to the standard error s_i. The
units' true values scatter: y_i ~ N(mu, tau^2 + s_i^2), and a unit that does not show the
coefficient says that its true value lies below its upper limit, which 95 of 100 such limits hold:
one that is far below what the others show does not make the scatter. The posterior of (mu, tau)
under flat priors (Gelman 2006, Sec. 4.3, for three units or more) is taken on a grid. From it come
the typical value exp(mu), the scatter tau, and the worst of 95 per cent of all units: the 0.95
quantile of exp(mu + 1.645 tau), an upper tolerance bound of content and confidence 95 per cent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special, stats

from imu_lib.estimate import Z95, Estimate

#: Content of the tolerance bound, and confidence in it.
CONTENT = CONFIDENCE = 0.95
#: Fewest units that a spread is told of.
LEAST = 3
#: Points of each axis of the grid, and while it is still looked for.
_POINTS, _SEARCH = 161, 41
#: How often the upper limit of what a record does not show holds.
LIMIT = 0.95
#: A weight of exp(-NEGLIGIBLE) beside the largest is none.
NEGLIGIBLE = 50.0


@dataclass(frozen=True)
class Spread:
    """The spread of one coefficient over units.

    Attributes
    ----------
    typical : Estimate
        Median over all units that the maker makes, the coefficient's unit, 95 % interval.
    scatter : Estimate
        Standard deviation of its logarithm from unit to unit; 0.1 is 10 per cent.
    worst : float
        What 95 % of all units stay below, with 95 % confidence.
    error : float
        Median standard error of the logarithm in one unit's estimate, for comparison.
    units, shown : int
        Units asked, and those that show the coefficient.
    """

    typical: Estimate
    scatter: Estimate
    worst: float
    error: float
    units: int
    shown: int

    def to_json(self):
        return {
            "typical": self.typical.to_json(),
            "scatter": self.scatter.to_json(),
            "worst": self.worst,
            "error": self.error,
            "units": self.units,
            "shown": self.shown,
        }


def logarithms(value, low, high):
    """(y, s) of estimates with 95 % intervals, arrays (n,): logarithms and their standard errors.

    An interval that is open on one side counts twice its other half.
    """
    value, low, high = (np.asarray(v, float) for v in (value, low, high))
    with np.errstate(divide="ignore", invalid="ignore"):
        y = np.log(value)
        below, above = y - np.log(low), np.log(high) - y
    below = np.where(np.isfinite(below) & (low > 0), below, np.nan)
    below, above = (np.where(np.isfinite(v), v, w) for v, w in ((below, above), (above, below)))
    half = np.where(np.isfinite(below + above), 0.5 * (below + above), np.nan)
    return y, half / Z95


def widening(z) -> float:
    """How much larger the variance of a variance's estimate is than under a normal distribution, 1
    or more, from the kurtosis of values (n,) about their trimmed mean.

    References
    ----------
    Bonett 2006, Computational Statistics & Data Analysis 50, 775.
    """
    z = np.asarray(z, float)
    if z.size < 5 or not np.ptp(z):
        return 1.0
    centre = stats.trim_mean(z, min(0.25, 1 / (2 * np.sqrt(z.size - 4))))
    kurtosis = z.size * np.sum((z - centre) ** 4) / np.sum((z - z.mean()) ** 2) ** 2
    return max(1.0, (kurtosis - (z.size - 3) / z.size) / 2)


def of_units(value, low, high) -> Spread | None:
    """The spread of a positive coefficient over units.

    Parameters
    ----------
    value, low, high : array_like, shape (n,)
        One estimate a unit, with its 95 % interval; `value` NaN where the unit does not show it and
        `high` is its upper limit.

    Returns
    -------
    Spread, or None where fewer than three units show the coefficient.
    """
    value, low, high = (np.asarray(v, float) for v in (value, low, high))
    y, s = logarithms(value, low, high)
    shown = np.isfinite(y) & np.isfinite(s) & (s > 0)
    if shown.sum() < LEAST:
        return None
    absent = np.isnan(value) & np.isfinite(high) & (high > 0)
    y, s, limits = y[shown], s[shown], np.log(high[absent])
    mu, tau, weight = _posterior(y, s, limits)
    at_mu, at_tau = weight.sum(axis=1), weight.sum(axis=0)
    typical = np.exp(_quantiles(mu, at_mu, (0.5, 0.025, 0.975)))
    # units of heavier tails than the normal say less of their scatter
    middle = tau[np.searchsorted(np.cumsum(at_tau), 0.5)]
    wide = widening((y - y.mean()) / np.sqrt(middle**2 + s**2))
    scatter = _quantiles(tau, at_tau ** (1 / wide), (0.5, 0.025, 0.975))
    bound = (mu[:, None] + stats.norm.ppf(CONTENT) * tau[None, :]).ravel()
    order = np.argsort(bound)
    worst = float(np.exp(_quantiles(bound[order], weight.ravel()[order], (CONFIDENCE,))[0]))
    low_end = float(scatter[1]) if at_tau[0] < 0.5 * at_tau.max() else 0.0
    return Spread(
        Estimate(*map(float, typical)),
        Estimate(float(scatter[0]), low_end, float(scatter[2])),
        worst,
        float(np.median(s)),
        int(shown.sum() + absent.sum()),
        int(shown.sum()),
    )


def _posterior(y, s, limits):
    """Grids of mu (a,) and tau (b,) and the posterior's weight on them (a, b), sum 1; the grids are
    laid again where the weight is.
    """
    middle, size = float(np.median(y)), max(float(np.std(y)), float(np.median(s)), 1e-6)
    reach = 8 * size if not limits.size else 8 * size + max(middle - float(limits.min()), 0.0)
    mu = np.linspace(middle - reach, middle + reach, _SEARCH)
    tau = np.linspace(0.0, 8 * size + reach * (limits.size > 0), _SEARCH)
    for points in (_SEARCH, _SEARCH, _SEARCH, _POINTS):
        weight = _weight(mu, tau, y, s, limits)
        mu = _closer(mu, weight.sum(axis=1), points)
        tau = _closer(tau, weight.sum(axis=0), points, least=0.0)
    return mu, tau, _weight(mu, tau, y, s, limits)


def _weight(mu, tau, y, s, limits):
    # the sum of squares over the units is a parabola in mu, of three numbers at each tau
    centre = y.mean()
    at, off = y - centre, (mu - centre)[:, None]
    variance = tau[:, None] ** 2 + s**2
    weights = 1 / variance
    constant = np.sum(np.log(variance) + at**2 * weights, axis=1)
    squares = off**2 * weights.sum(axis=1) - 2 * off * (weights @ at)
    log = -0.5 * (constant + squares)
    if limits.size:
        log += _below(mu, tau, limits, log)
    weight = np.exp(log - log.max())
    return weight / weight.sum()


def _below(mu, tau, limits, log):
    """Log-probability (a, b) that each unit which shows nothing lies below its limit, where the
    others' `log` leaves any weight; -inf elsewhere.
    """
    mean, sd = np.broadcast_arrays(mu[:, None], np.maximum(tau, 1e-9))
    best = np.unravel_index(np.argmax(log), log.shape)
    least = log[best] + _held((limits - mean[best]) / sd[best]).sum()
    left = log > least - NEGLIGIBLE  # what the limits add is never above zero
    out = np.full(log.shape, -np.inf)
    out[left] = 0.0
    for limit in limits:
        out[left] += _held((limit - mean[left]) / sd[left])
    return out


def _held(z):
    """Logarithm of the chance that a limit z standard deviations from the mean holds: of 95 limits
    in a hundred that of the value below, of the others nothing is said.
    """
    return np.log(LIMIT * special.ndtr(z) + 1 - LIMIT)


def _closer(grid, weight, points, least=-np.inf):
    """The grid over what holds all but 1e-7 of the weight, with a margin."""
    total = np.cumsum(weight)
    low, high = np.searchsorted(total, (1e-7, 1 - 1e-7))
    step = grid[1] - grid[0]
    low, high = grid[low] - 2 * step, grid[min(high, grid.size - 1)] + 2 * step
    return np.linspace(max(low, least), high, points)


def _quantiles(grid, weight, shares):
    total = np.cumsum(weight) - 0.5 * weight
    return np.interp(shares, total / weight.sum(), grid)
