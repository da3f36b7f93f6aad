"""Is the noise normal: skewness and tails of the innovations, and whether they matter."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.stats import norm

from imu_lib.arrays import Array
from imu_lib.gap.check import Check

#: Domain of the test of skewness.
SKEW = "skewness"
#: Relative error of the innovations' quantiles at three standard deviations from which on it
#: matters. A gate there lets 1 - erf(2.85 / sqrt(2)), 0.44 % of the samples, pass for outliers
#: where 0.27 % are expected; a standard deviation that is 5 % off does the same, which is no more
#: than the half of a unit in the second digit of a datasheet's 0.010 deg/sqrt(h).
TAIL = 0.05
#: Share of normal samples below minus three standard deviations.
BEYOND = float(norm.cdf(-3.0))


def tail_error(u: Array) -> float:
    """Relative error at the most of the quantiles at plus and minus three standard deviations of
    samples `u` with mean 0 and variance 1, where they are taken for normal.

    The larger of what is counted and of what skewness and excess promise (Cornish and Fisher 1938):
    the quantile at z moves by (z^2 - 1) / 6 times the first and (z^3 - 3 z) / 24 times the second.
    """
    skew, excess = np.mean(u**3), np.mean(u**4) - 3.0
    promised = (8.0 / 6.0 * abs(skew) + 18.0 / 24.0 * abs(excess)) / 3.0
    counted = np.abs(np.abs(np.quantile(u, [BEYOND, 1.0 - BEYOND])) - 3.0).max() / 3.0
    return float(max(promised, counted))


#: Standard deviations within which the bulk of the samples lies, and share of the skewness that it
#: keeps where all of the distribution leans.
BULK, LEANS = 3.0, 0.4


def _uneven(u: Array, skew: float) -> str:
    """What makes samples `u` of mean 0 and variance 1 uneven: a few far ones, or all of them."""
    above, below = np.count_nonzero(u > 4), np.count_nonzero(u < -4)
    bulk = u[np.abs(u) < BULK]
    kept = float(np.mean(((bulk - bulk.mean()) / bulk.std()) ** 3))
    text = f"{above} samples beyond +4 standard deviations and {below} beyond -4"
    if kept / skew < LEANS:
        share = 100 * (1 - len(bulk) / len(u))
        return (
            f"{text}: single deviations to one side; without the {share:.2g} % beyond {BULK:.0f} "
            f"standard deviations it is {kept:+.2g}"
        )
    return f"{text}: all of the distribution leans to one side"


def distribution(y: Array, independent: float = 1.0, *, rounded: bool = False) -> list[Check]:
    """Skewness and excess of the whitened fast noise, a share of whose samples is `independent`."""
    n = len(y) * independent
    u = (y - y.mean()) / y.std()
    skew, excess = np.mean(u**3), np.mean(u**4) - 3
    size = tail_error(u) / TAIL
    if rounded:  # differenced rounding errors are flatter than normal ones
        excess = max(excess, 0.0)
    return [
        Check(
            SKEW,
            float(log10_normal(skew / np.sqrt(6 / n))),
            f"distribution of the innovations: skewness {skew:+.3g}, {_uneven(u, skew)}",
            size,
        ),
        Check(
            "distribution",
            float(log10_normal(excess / np.sqrt(24 / n))),
            f"distribution of the innovations: excess kurtosis {excess:+.3g}",
            size,
        ),
    ]


def log10_normal(z: Array | float) -> Any:
    """log10 of the two-sided p-value of a normal number, far into the tails."""
    return (norm.logsf(np.abs(z)) + np.log(2)) / np.log(10)
