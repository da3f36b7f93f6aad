"""Welch's estimate of the one-sided power spectral density, and frequency averaging, with
chi-square intervals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal, stats


@dataclass(frozen=True)
class Spectrum:
    """A one-sided power spectral density.

    Attributes
    ----------
    f : ndarray, shape (k,)
        Frequencies, Hz, above zero.
    psd : ndarray, shape (k,)
        unit^2/Hz.
    low, high : ndarray, shape (k,)
        95 % chi-square interval.
    dof : ndarray, shape (k,)
        Equivalent degrees of freedom.
    start, stop : ndarray, shape (k,)
        Band that each value stands for, Hz.
    fs : float
        Sampling rate, Hz.
    segment : int
        Samples of one Fourier transform.
    count : int
        Transforms averaged.
    window : str
    """

    f: np.ndarray
    psd: np.ndarray
    low: np.ndarray
    high: np.ndarray
    dof: np.ndarray
    start: np.ndarray
    stop: np.ndarray
    fs: float
    segment: int
    count: int
    window: str

    @property
    def asd(self):
        """Amplitude spectral density, unit/sqrt(Hz), shape (k,)."""
        return np.sqrt(self.psd)

    def at(self, f):
        """Index of the frequency nearest to f (Hz) on the logarithmic axis."""
        return int(np.argmin(np.abs(np.log(self.f / f))))


def _intervals(psd, dof):
    few, which = np.unique(dof, return_inverse=True)  # one number for nearly all frequencies
    low, high = (few / stats.chi2.ppf(q, few) for q in (0.975, 0.025))
    return psd * low[which], psd * high[which]


def default_segment(n):
    """The longest power of two that fits at least twice (seven hours at 100 Hz: 2^20, as in the
    2013 paper).
    """
    return 1 << max(3, int(np.floor(np.log2(max(n // 2, 8)))))


def welch(x, fs, *, segment=None, window="hann", detrend="constant"):
    """Welch's estimate with half-overlapping segments; scipy.signal.welch where nothing is
    missing.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples; values that are not finite are missing. Segments are then laid in each unbroken
        stretch.
    fs : float
        Sampling rate, Hz.
    segment : int or None
        Samples to a segment, by default the longest power of two that fits twice (into the longest
        stretch).
    window : str
        A window of scipy.signal.
    detrend : str or False
        What is removed from each segment, as in scipy.signal.welch.

    Returns
    -------
    Spectrum
        Without the frequency zero.

    Raises
    ------
    ValueError
        For an `x` that is no series or has no stretch of 8 samples, or a `segment` that does not
        fit.
    """
    x = np.asarray(x, dtype=float)
    if x.ndim != 1 or x.size < 8:
        raise ValueError(f"`x` must be a series of at least 8 samples, not of shape {x.shape}")
    if not np.isfinite(fs) or fs <= 0:
        raise ValueError(f"`fs` must be a positive rate in Hz, not {fs}")
    stretches = _stretches(x)
    longest = max((b - a for a, b in stretches), default=0)
    segment = default_segment(longest) if segment is None else int(segment)
    if longest < max(segment, 8) or segment < 8:
        raise ValueError(
            f"`segment` of {segment} samples does not fit: the longest stretch without a missing "
            f"sample has {longest}"
        )
    step = segment - segment // 2
    total, count = 0.0, 0
    for a, b in stretches:
        here = (b - a - segment // 2) // step
        if here > 0:
            f, psd = signal.welch(x[a:b], fs, window=window, nperseg=segment, detrend=detrend)
            total, count = total + here * psd, count + here
    return from_power(total / count, float(fs), segment, count, window=window)


def from_power(power, fs, segment, count, *, window="hann") -> Spectrum:
    """The spectrum, with its intervals, from the mean density of `count` half-overlapping segments.

    Parameters
    ----------
    power : ndarray, shape (segment // 2 + 1,)
        One-sided, the frequency zero included, unit^2/Hz.
    fs : float, Hz
    segment, count : int
    window : str
    """
    step = segment - segment // 2
    taper = signal.get_window(window, segment)
    shared = _overlap(taper, step)
    lag = np.arange(1, len(shared) + 1)
    each = 2 * count / (1 + 2 * np.sum(np.clip(1 - lag / count, 0, None) * shared**2))
    dof = np.full(power.size - 1, each)
    if segment % 2 == 0:
        dof[-1] /= 2  # the highest frequency has no imaginary part
    psd = power[1:]
    f = np.fft.rfftfreq(segment, 1 / fs)
    low, high = _intervals(psd, dof)
    half = 0.5 * fs / segment
    return Spectrum(
        f[1:], psd, low, high, dof, f[1:] - half, f[1:] + half, fs, segment, count, window
    )


def _stretches(x):
    good = np.isfinite(x)
    if good.all():
        return [(0, x.size)]
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _overlap(taper, step):
    """Correlation of tapered segments that share samples (Percival and Walden 1993, Sec. 6.17)."""
    norm = np.sum(taper**2)
    return np.array([np.sum(taper[k:] * taper[:-k]) / norm for k in range(step, taper.size, step)])


def average(spectrum, *, per_decade=20, keep=4):
    """Frequency averaging (IEEE Std 1293-1998; 2013 Sec. 5.4, 2011 Sec. 3): means over ever wider
    bands.

    Parameters
    ----------
    spectrum : Spectrum
        As `welch` gives it.
    per_decade : int
        Bands to a decade where they are wider than the resolution.
    keep : int
        Lowest frequencies that are left as they are. The first two are dropped: the removal of the
        mean and the window's main lobe bias them.

    Returns
    -------
    Spectrum
        `f` the middle of each band on the logarithmic axis.
    """
    resolution = spectrum.fs / spectrum.segment
    k = np.rint(spectrum.f / resolution).astype(int)
    edges = [3 + i for i in range(keep)]
    while edges[-1] < k[-1]:
        edges.append(max(edges[-1] + 1, int(round(edges[-1] * 10 ** (1 / per_decade)))))
    starts = np.array(edges[:-1])
    stops = np.minimum(np.array(edges[1:]), k[-1] + 1)
    starts, stops = starts[starts < stops], stops[starts < stops]
    running = np.concatenate([[0.0], np.cumsum(spectrum.psd)])
    size = stops - starts
    psd = (running[stops - 1] - running[starts - 1]) / size
    # neighbouring frequencies of a tapered transform are correlated, which costs degrees of
    # freedom
    taper = signal.get_window(spectrum.window, min(spectrum.segment, 1024))
    shared = np.abs(np.fft.rfft(taper**2)[1:4] / np.sum(taper**2)) ** 2
    lag = np.arange(1, 4)
    loss = 1 + 2 * np.sum(np.clip(1 - lag / size[:, None], 0, None) * shared, axis=1)
    dof = spectrum.dof[starts - 1] * size / loss
    low, high = _intervals(psd, dof)
    start, stop = (starts - 0.5) * resolution, (stops - 0.5) * resolution
    return Spectrum(
        np.sqrt(start * stop),
        psd,
        low,
        high,
        dof,
        start,
        stop,
        spectrum.fs,
        spectrum.segment,
        spectrum.count,
        spectrum.window,
    )
