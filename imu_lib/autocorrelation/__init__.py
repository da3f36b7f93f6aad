"""Autocorrelation, its confidence bands, and the Gauss-Markov process read from it.

* `autocorrelation`: sample autocorrelation with Bartlett's bands (equal to statsmodels' `acf`);
* `fit_gauss_markov`, `characterise`: sigma and correlation time of white noise plus a
  first-order Gauss-Markov process, with intervals that know that neighbouring lags are not
  independent;
* `read_off`: the same by eye, for comparison;
* `bartlett_covariance`, `expected_autocovariance`: covariance and exact mean of sample
  autocovariances;
* `variance_uncertainty`, `record_for`: the rule of 200 correlation times.
"""

from imu_lib.autocorrelation.correlation import (
    Autocorrelation,
    autocorrelation,
    autocovariance,
    bartlett_covariance,
    expected_autocovariance,
)
from imu_lib.autocorrelation.gauss_markov import GaussMarkovFit, characterise, fit_gauss_markov
from imu_lib.autocorrelation.record_length import read_off, record_for, variance_uncertainty

__all__ = [
    "Autocorrelation",
    "GaussMarkovFit",
    "autocorrelation",
    "autocovariance",
    "bartlett_covariance",
    "characterise",
    "expected_autocovariance",
    "fit_gauss_markov",
    "read_off",
    "record_for",
    "variance_uncertainty",
]
