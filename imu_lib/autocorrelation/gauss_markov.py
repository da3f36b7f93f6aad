"""First-order Gauss-Markov process and white noise, fitted to the autocovariance.

The sample autocovariances of one record are strongly correlated with each other: neighbouring lags
share almost all of their products. A plain least-squares fit of sigma^2 exp(-lag / Tc) (Eq. 11 of
the 2013 paper, Eq. 9 of the 2011 paper) to them has intervals many times too small. Here the fit
is generalised least squares with the covariance of the lags evaluated at the fitted model, and
against the exact mean of the lags once the record's own mean is off.

A gyroscope's white noise is a thousand times its Gauss-Markov variance, sample by sample, and its
correlation time thousands of samples. The record is therefore first averaged over blocks. The
block is not the user's choice: blocks of 1, 2, 4, ... samples are tried, and of those where the
fitted correlation time is a handful of blocks the most significant is taken. Where the record
drifts on beyond that (a random walk, which has no autocovariance), the autocovariance is averaged
over segments, each less its own mean, and a walk is fitted with it. Of two correlated processes it
is the more significant one that is reported.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.autocorrelation.correlation import prepared
from imu_lib.autocorrelation.lag_fit import (
    SEGMENT,
    SMALLEST,
    block_levels,
    excess,
    fit_segments,
    fit_whole,
)
from imu_lib.estimate import Z95, Estimate
from imu_lib.processes import GaussMarkov

#: Correlation time in blocks at which a block is fit to resolve it.
_RESOLVED = (2.5, 16.0)
#: Standard errors above zero that a Gauss-Markov variance must have to count as shown; see
#: `fit_gauss_markov`.
_SHOWN = 4.0


@dataclass(frozen=True)
class GaussMarkovFit:
    """Gauss-Markov process and white noise read from the autocovariance.

    Parameters
    ----------
    sigma, correlation_time : Estimate
        Signal unit; s. Absent (value None) where no correlation is shown.
    N : Estimate
        White noise coefficient at the scale of the block, signal unit per sqrt(Hz).
    K : Estimate
        Random walk, fitted where the record drifts; else absent, with no limit.
    block : int
        Samples per block mean.
    lag, autocovariance, fitted : ndarray, shape (m,)
        Of the block means, s and signal unit squared; `fitted` is the model's mean of them.
    significance : float
        Standard errors between the process's variance and zero under white noise, for the best
        template.
    """

    sigma: Estimate
    correlation_time: Estimate
    N: Estimate
    K: Estimate
    block: int
    lag: np.ndarray
    autocovariance: np.ndarray
    fitted: np.ndarray
    significance: float

    @property
    def process(self) -> GaussMarkov:
        """The fitted process. ValueError where none is shown."""
        if not self.sigma.shown:
            raise ValueError("the record shows no Gauss-Markov process")
        return GaussMarkov(sigma=self.sigma.value, correlation_time=self.correlation_time.value)


def fit_gauss_markov(x, fs, *, block=None, lags=32, detrend="mean", drift=None) -> GaussMarkovFit:
    """Fit white noise plus one first-order Gauss-Markov process to the autocovariance of a record.

    Parameters
    ----------
    x : array_like, shape (n,)
    fs : float
        Rate, Hz.
    block : int, optional
        Samples per block mean; default chosen as the module's docstring says. A block that is
        given is not searched for, so two standard errors are enough.
    lags : int
        Lags of the block means that are fitted.
    detrend : {"mean", "linear", "none"}
    drift : bool, optional
        Whether a random walk is fitted as well; default: where the record shows more slow variance
        than the fit.

    Notes
    -----
    Intervals are normal in the logarithm of sigma^2 and Tc. A process counts as shown when its
    variance is four
    standard errors above zero under the hypothesis of white noise: the search over blocks makes
    the usual two far
    too generous (the false-alarm rate is tested). Correlation times below 2.5 samples are left to
    the electronics'
    filter. A correlation time of the order of the record has an interval that is open above. Where
    nothing is shown the
    upper limit of sigma is the largest over the blocks, each for a process that remembers six of
    its blocks.

    Raises
    ------
    ValueError
        On a record of fewer than 48 blocks, or one that does not vary.
    """
    x = prepared(x, detrend)
    if x.size // (block or 1) < SMALLEST:
        raise ValueError(f"`x` has {x.size // (block or 1)} blocks, a fit takes {SMALLEST} or more")
    if not np.any(x != x[0]):
        raise ValueError("`x` does not vary: it has no autocorrelation")
    scale = x.std()
    return of_levels(block_levels(x / scale, lags, block), fs, scale, block=block, drift=drift)


def of_levels(levels, fs, scale, *, block=None, drift=None) -> GaussMarkovFit:
    """`fit_gauss_markov` on the block means of a record: `levels` (list of Level) in units of
    `scale`, the record's standard deviation.
    """
    peak = max(level.significance for level in levels)
    if peak <= _SHOWN and not block:
        return _absent(levels, fs, scale, peak)
    whole = None if drift else _best(levels, fit_whole, block)
    local = (
        None
        if drift is False
        else _best([lv for lv in levels if lv.n >= 2 * SEGMENT], fit_segments, block)
    )
    if whole and local and not _drifts(levels, *whole) and local[1].z < 1.5 * whole[1].z:
        local = None  # nothing slower than the process: the whole record knows more
    chosen = local or whole or _longest(levels)
    if chosen is None:
        return _absent(levels, fs, scale, peak)
    return _result(*chosen, fs, scale, peak)


def characterise(x, fs) -> dict[str, Estimate]:
    """sigma and correlation time of a channel, as `imu-lib characterise` reports them."""
    fit = fit_gauss_markov(x, fs)
    return {"sigma": fit.sigma, "correlation_time": fit.correlation_time}


def _best(levels, fit, block):
    """The most significant fit whose correlation time its block resolves, as (level, solution), or
    None.
    """
    found = []
    for level in levels:
        if block or level.significance > _SHOWN:
            solution = fit(level, anywhere=bool(block))
            if solution is not None and (block or _RESOLVED[0] <= solution.tc <= _RESOLVED[1]):
                found.append((level, solution))
    found = [pair for pair in found if pair[1].z > 2]
    return max(found, key=lambda pair: pair[1].z, default=None)


def _drifts(levels, level, solution):
    """Whether blocks much longer than the correlation time still vary more than the fit says."""
    coarse = [lv for lv in levels if lv.m > level.m * solution.tc]
    return any(excess(lv, solution, level) > _SHOWN for lv in coarse)


def _longest(levels):
    """The coarsest fit of a record whose correlation time no block resolves: open above."""
    solution = fit_whole(levels[-1], anywhere=True)
    return None if solution is None or solution.tc < _RESOLVED[1] else (levels[-1], solution)


def _result(level, solution, fs, scale, peak):
    theta, sd = solution.theta, np.sqrt(np.diag(solution.covariance))
    interval = level.m / fs
    drifts = theta.size == 4
    return GaussMarkovFit(
        sigma=_positive(np.exp(theta[0] / 2) * scale, sd[0] / 2),
        correlation_time=_positive(np.exp(theta[1]) * interval, sd[1]),
        N=_root(theta[2], sd[2], interval * scale**2),
        K=_root(theta[3], sd[3], scale**2 / interval) if drifts else Estimate.absent(),
        block=level.m,
        lag=np.arange(solution.gamma.size) * interval,
        autocovariance=solution.gamma * scale**2,
        fitted=solution.mean * scale**2,
        significance=float(peak),
    )


def _positive(value, relative_sd):
    """Log-normal interval; open above where the record bounds the quantity from below alone."""
    if relative_sd > 3:
        return Estimate(float(value), float(value * np.exp(-Z95 * min(relative_sd, 30.0))), np.inf)
    return Estimate.lognormal(value, relative_sd)


def _root(value, sd, unit):
    """Square root of a variance with a normal error; absent where its interval reaches zero."""
    low, high = (np.sqrt(max(value + s * Z95 * sd, 0.0) * unit) for s in (-1, 1))
    if low == 0:
        return Estimate.absent(float(np.sqrt(max(value + 1.645 * sd, 0.0) * unit)))
    return Estimate(float(np.sqrt(value * unit)), float(low), float(high))


def _absent(levels, fs, scale, peak):
    level = levels[0]
    interval = level.m / fs
    flat = np.full(level.gamma.size, -level.gamma[0] / level.n)
    flat[0] += level.gamma[0]
    return GaussMarkovFit(
        sigma=Estimate.absent(np.sqrt(max(lv.limit for lv in levels)) * scale),
        correlation_time=Estimate.absent(),
        N=Estimate.lognormal(
            float(np.sqrt(level.gamma[0] * interval) * scale), 1 / np.sqrt(2 * level.n)
        ),
        K=Estimate.absent(),
        block=level.m,
        lag=np.arange(level.gamma.size) * interval,
        autocovariance=level.gamma * scale**2,
        fitted=flat * scale**2,
        significance=float(peak),
    )
