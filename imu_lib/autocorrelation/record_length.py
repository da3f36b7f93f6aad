"""How long a record the autocorrelation needs, and the reading by eye."""

from __future__ import annotations

import numpy as np

from imu_lib.autocorrelation.correlation import Autocorrelation


def variance_uncertainty(duration, correlation_time):
    """Relative standard deviation of the sample variance of a Gauss-Markov process, sqrt(2 Tc /
    T).

    The rule that the 2011 paper quotes: 200 correlation times for 10 %. It speaks of the
    autocovariance at lag 0 (Brown and Hwang), sigma^2; sigma itself is twice as good, the
    correlation time just as bad, and white noise on top makes all of them worse.
    """
    return np.sqrt(2 * np.asarray(correlation_time) / np.asarray(duration))


def record_for(correlation_time, relative_sd=0.1):
    """Length of record, s, at which the variance of a Gauss-Markov process is known to
    `relative_sd`.
    """
    return 2 * np.asarray(correlation_time) / relative_sd**2


def read_off(curve: Autocorrelation) -> tuple[float, float]:
    """sigma and correlation time as read from the curve: root of lag 0, and the first lag below
    1/e.

    What the papers' Fig. 4 suggests; it takes white noise for part of the process. `nan` where the
    curve does not come down to 1/e.
    """
    below = np.flatnonzero(curve.rho < np.exp(-1))
    if below.size == 0:
        return float(np.sqrt(curve.variance)), float("nan")
    k = below[0]
    share = (curve.rho[k - 1] - np.exp(-1)) / (curve.rho[k - 1] - curve.rho[k])
    return float(np.sqrt(curve.variance)), float(
        curve.lag[k - 1] + share * (curve.lag[k] - curve.lag[k - 1])
    )
