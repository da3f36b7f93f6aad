"""The sample autocorrelation and what scatters it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft, signal, stats

#: Up to this many lags, dot products are quicker than the Fourier transform of a long record.
_FEW_LAGS = 64


@dataclass(frozen=True)
class Autocorrelation:
    """Sample autocorrelation of a record.

    Parameters
    ----------
    lag : ndarray, shape (m + 1,), s
    rho : ndarray, shape (m + 1,)
        Autocorrelation, `rho[0]` = 1; the sum of products is divided by n at every lag.
    sd : ndarray, shape (m + 1,)
        Bartlett's standard deviation of `rho[k]` if the true autocorrelation ended before lag k,
        sqrt((1 + 2 sum_{i<k} rho_i^2) / n), as statsmodels has it.
    variance : float
        Sample variance, signal unit squared.
    n : int
    """

    lag: np.ndarray
    rho: np.ndarray
    sd: np.ndarray
    variance: float
    n: int

    def white_band(self, confidence: float = 0.95) -> float:
        """Half width of the band that holds `confidence` of the lags of white noise."""
        return float(stats.norm.ppf(0.5 + confidence / 2) / np.sqrt(self.n))

    def interval(self, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper end of `rho` by Bartlett's standard deviation, each (m + 1,)."""
        half = stats.norm.ppf(0.5 + confidence / 2) * self.sd
        return self.rho - half, self.rho + half

    @property
    def share_outside(self) -> float:
        """Share of the lags beyond 0 that lie outside the 95 % band of white noise; 0.05 for white
        noise.
        """
        return float(np.mean(np.abs(self.rho[1:]) > self.white_band()))


def autocorrelation(x, fs, *, max_lag=None, detrend="mean") -> Autocorrelation:
    """Sample autocorrelation by the Fourier transform.

    Parameters
    ----------
    x : array_like, shape (n,)
    fs : float
        Rate, Hz.
    max_lag : float, optional
        Longest lag, s; default a tenth of the record.
    detrend : {"mean", "linear", "none"}
        What is taken off first.

    Raises
    ------
    ValueError
        On too short or non-finite records, an unknown option, or a record without variance.
    """
    x = prepared(x, detrend)
    lags = int(round(max_lag * fs)) if max_lag is not None else x.size // 10
    if not 1 <= lags < x.size:
        raise ValueError(
            f"`max_lag` must lie between one sample and the record's length, {x.size / fs:g} s, "
            f"not {max_lag} s"
        )
    gamma = autocovariance(x, lags)
    if gamma[0] <= 0:
        raise ValueError("`x` does not vary: its autocorrelation does not exist")
    rho = gamma / gamma[0]
    sd = np.sqrt((1 + 2 * np.concatenate([[0.0, 0.0], np.cumsum(rho[1:-1] ** 2)])) / x.size)
    sd[0] = 0.0
    return Autocorrelation(
        lag=np.arange(lags + 1) / fs, rho=rho, sd=sd, variance=float(gamma[0]), n=x.size
    )


def autocovariance(x: np.ndarray, lags: int) -> np.ndarray:
    """Sums of products over n, lags 0 to `lags`, shape (lags + 1,); the mean is not removed
    here.
    """
    n = x.size
    if lags <= _FEW_LAGS:
        return np.array([x[: n - k] @ x[k:] for k in range(lags + 1)]) / n
    spectrum = fft.rfft(x, fft.next_fast_len(n + lags, real=True))
    power = spectrum.real**2 + spectrum.imag**2
    return fft.irfft(power, fft.next_fast_len(n + lags, real=True))[: lags + 1] / n


def prepared(x, detrend="mean") -> np.ndarray:
    """The record as floats, checked, with its mean or line taken off."""
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or x.size < 4:
        raise ValueError(f"`x` must have shape (n,) with n of 4 or more, not {x.shape}")
    if not np.all(np.isfinite(x)):
        raise ValueError("`x` holds samples that are not finite: take a gap-free stretch")
    if detrend not in ("mean", "linear", "none"):
        raise ValueError(f"`detrend` must be mean, linear or none, not {detrend!r}")
    if detrend == "linear":
        return signal.detrend(x)
    return x - x.mean() if detrend == "mean" else x


def bartlett_covariance(gamma, n, lags) -> np.ndarray:
    """Covariance of the sample autocovariances of a Gaussian process, shape (lags + 1, lags + 1).

    Bartlett's formula: cov(g_h, g_k) = sum over all m of (gamma_m gamma_{m+h-k} + gamma_{m+k}
    gamma_{m-h}) / n, which is (S(h - k) + S(h + k)) / n with S the autocovariance sequence
    convolved with itself.

    Parameters
    ----------
    gamma : array_like, shape (L,)
        True autocovariance at lags 0, 1, ...; long enough to have died out.
    n : int
        Samples of the record.
    """
    gamma = np.asarray(gamma, dtype=float)
    two_sided = np.concatenate([gamma[:0:-1], gamma])
    size = fft.next_fast_len(2 * two_sided.size + 2 * lags, real=True)
    s = fft.irfft(np.abs(fft.rfft(two_sided, size)) ** 2, size)[: 2 * lags + 1]
    h = np.arange(lags + 1)
    return (s[np.abs(h[:, None] - h)] + s[h[:, None] + h]) / n


def expected_autocovariance(gamma, n, lags) -> np.ndarray:
    """Exact mean of the sample autocovariances once the sample mean is removed, shape (lags + 1,).

    Removing the mean and dividing by n pull the whole curve down, by about the variance of the
    mean; a fit that ignores it reads a correlation time that is too short.

    Parameters
    ----------
    gamma : array_like, shape (n,)
        True autocovariance at lags 0 ... n - 1.
    """
    gamma = np.asarray(gamma, dtype=float)
    h = np.arange(lags + 1)
    sums = np.cumsum(gamma)
    with_mean = (sums + sums[::-1] - gamma[0]) / n  # covariance of sample t with the mean
    mean_variance = with_mean.mean()
    head = np.concatenate([[0.0], np.cumsum(with_mean)])
    cross = head[n - h] + (head[n] - head[h])
    return (1 - h / n) * gamma[h] + ((n - h) * mean_variance - cross) / n
