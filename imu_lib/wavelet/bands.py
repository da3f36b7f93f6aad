"""The bands of the wavelet transform, and the level at which to stop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pywt
from scipy import stats

from imu_lib.wavelet.shrinkage import max_level


@dataclass(frozen=True)
class Band:
    """Nominal band of one set of coefficients, Hz."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class LevelChoice:
    """The level that spares the motion, and what it was chosen from.

    Parameters
    ----------
    level : int
        Deepest level at which all dropped bands hold less motion than noise.
    motion_variance, noise_variance : ndarray, shape (J,)
        Variance of each detail band in the moving record, beyond the noise (not below 0), and at
        rest.
    p_value : ndarray, shape (J,)
        Probability that noise alone has the moving record's variance in the band.
    limit : float
        Upper end of the approximation's band at `level`, Hz (Table 7 of the 2013 paper).
    """

    level: int
    motion_variance: np.ndarray
    noise_variance: np.ndarray
    p_value: np.ndarray
    limit: float


def bands(fs, level) -> list[Band]:
    """Nominal bands D_1 ... D_J and A_J (Fig. 8 of the 2013 paper: A_J ends at fs / 2^(J+1))."""
    details = [Band(f"D{j}", fs / 2 ** (j + 1), fs / 2**j) for j in range(1, level + 1)]
    return [*details, Band(f"A{level}", 0.0, fs / 2 ** (level + 1))]


def gain(f, fs, level, *, wavelet="db4"):
    """Gain of each band's reconstruction at the frequencies `f`, Hz: shape (J + 1, len(f)), D_1
    ... D_J, A_J.

    The share of white noise that the band passes at a frequency, and the amplitude at which it
    returns a sine there (averaged over the phase of the decimation; the rest comes back as an
    alias at another frequency). The rows add up to one.
    """
    w = pywt.Wavelet(wavelet)
    f = np.atleast_1d(np.asarray(f, dtype=float))
    low = np.ones(f.size)
    rows = []
    for j in range(level):
        angle = 2 * np.pi * f / fs * 2**j
        response = np.exp(-1j * np.outer(angle, np.arange(w.dec_len)))
        rows.append(low * np.abs(response @ np.array(w.dec_hi)) ** 2 / 2)
        low = low * np.abs(response @ np.array(w.dec_lo)) ** 2 / 2
    return np.array([*rows, low])


def span(fs, level, *, wavelet="db4") -> float:
    """Memory of the transform at `level`, seconds: (taps - 1) (2^level - 1) samples."""
    return (pywt.Wavelet(wavelet).dec_len - 1) * (2**level - 1) / fs


def band_variance(x, level, *, wavelet="db4"):
    """Variance of `x`, shape (n,), in each band: shape (J + 1,), D_1 ... D_J, A_J; they add up to
    the variance.

    Periodised transform, so that the coefficients' energy is the samples'.
    """
    x = np.asarray(x, dtype=float)
    n = x.size - x.size % 2**level
    if max_level(n, wavelet) < level:
        raise ValueError(f"`x` has {x.size} samples, too few for `level` {level} of {wavelet}")
    x = x[:n] - x[:n].mean()
    coefficients = pywt.wavedec(x, wavelet, mode="periodization", level=level)
    return np.array([np.sum(c * c) / n for c in coefficients[::-1]])


def level_for_band(motion_band, fs) -> int:
    """Deepest level whose approximation still holds motion up to `motion_band`, Hz (2013, Section
    5.6).

    At 100 Hz a band of 5 Hz gives level 3 (A_3 ends at 6.25 Hz).
    """
    if not 0 < motion_band <= fs / 2:
        raise ValueError(
            f"`motion_band` must lie between 0 and half the rate, {fs / 2} Hz, not {motion_band}"
        )
    return max(0, int(np.floor(np.log2(fs / (2 * motion_band)))))


def choose_level(motion, static, fs, *, wavelet="db4", max_level=8, ratio=1.0) -> LevelChoice:
    """Level from the data: stop before the first band in which the vehicle moves more than the
    sensor's noise.

    Parameters
    ----------
    motion, static : array_like, shapes (n,), (m,)
        One channel while driving and at rest.
    fs : float
        Rate, Hz.
    ratio : float
        A band may be dropped while its motion variance is below `ratio` times its noise variance.

    Notes
    -----
    Dropping a band takes away its noise and its motion: it pays while the motion there is the
    smaller of the two.
    The first band that fails ends the search, whatever lies deeper. The p-value is that of the
    ratio of variances
    with a coefficient per 2^j samples counted as independent, good for the nearly white
    coefficients of db4.
    """
    moving = band_variance(motion, max_level, wavelet=wavelet)[:-1]
    still = band_variance(static, max_level, wavelet=wavelet)[:-1]
    excess = np.maximum(moving - still, 0.0)
    level = int(np.argmin(np.append(excess < ratio * still, False)))
    counts = [
        np.maximum(np.size(a) // 2 ** np.arange(1, max_level + 1), 1) for a in (motion, static)
    ]
    p_value = stats.f.sf(moving / np.maximum(still, np.finfo(float).tiny), *counts)
    return LevelChoice(
        level=level,
        motion_variance=excess,
        noise_variance=still,
        p_value=p_value,
        limit=fs / 2 ** (level + 1),
    )
