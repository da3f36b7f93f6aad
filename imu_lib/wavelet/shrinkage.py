"""Threshold rules for wavelet coefficients, row by row.

All rules act on rows of coefficients, shape (r, n), and return one threshold per row. They follow
MATLAB's `wden` and `thselect`, which the 2013 paper used: `sure` is its 'rigrsure', `hybrid` its
'heursure', `universal` its 'sqtwolog'; the noise scale `per_level` is its 'mln', `first_level` its
'sln', `unit` its 'one'.
"""

from __future__ import annotations

import numpy as np
import pywt

RULES = ("sure", "hybrid", "universal", "approximation")
SCALES = ("per_level", "first_level", "unit")
#: Median of |z| for a standard normal z.
MAD_OF_NORMAL = 0.6744897501960817


def noise_scale(details: np.ndarray) -> np.ndarray:
    """Standard deviation of the noise in each row, from its median absolute value (Donoho and
    Johnstone).
    """
    return np.median(np.abs(details), axis=-1) / MAD_OF_NORMAL


def sure_threshold(z: np.ndarray) -> np.ndarray:
    """Threshold that minimises Stein's unbiased risk estimate of the soft threshold, for unit
    noise.

    With the squares s_1 <= ... <= s_n of a row, the risk at threshold sqrt(s_k) is
    n - 2 k + sum_{i<=k} s_i + (n - k) s_k (Donoho and Johnstone 1995, Eq. 11).
    """
    n = z.shape[-1]
    squares = np.sort(z * z, axis=-1)
    k = np.arange(1, n + 1)
    risk = n - 2 * k + np.cumsum(squares, axis=-1) + (n - k) * squares
    return np.sqrt(
        np.take_along_axis(squares, np.argmin(risk, axis=-1)[..., None], axis=-1)[..., 0]
    )


def hybrid_threshold(z: np.ndarray) -> np.ndarray:
    """SURE, but the universal threshold where the row has too little energy above the noise for
    SURE to see.

    Donoho and Johnstone 1995, Section 2.4, with the lesser of the two where SURE is used, as
    MATLAB does.
    """
    n = z.shape[-1]
    universal = np.sqrt(2 * np.log(n))
    sparse = np.mean(z * z, axis=-1) - 1 < np.log2(n) ** 1.5 / np.sqrt(n)
    return np.where(sparse, universal, np.minimum(sure_threshold(z), universal))


def row_thresholds(
    coefficients: list[np.ndarray], rule: str, scale: str
) -> tuple[np.ndarray, np.ndarray]:
    """Noise scale and threshold of every detail level.

    Parameters
    ----------
    coefficients : list of ndarray
        As `pywt.wavedec` gives them: approximation, then details from the deepest level to the
        first, each (r, n_j).

    Returns
    -------
    sigma, threshold : ndarray, shape (J, r)
        Level 1 first. The approximation-only form has infinite thresholds.
    """
    details = coefficients[:0:-1]
    rows = details[0].shape[0]
    if scale == "per_level":
        sigma = np.array([noise_scale(d) for d in details])
    elif scale == "first_level":
        sigma = np.repeat(noise_scale(details[0])[None], len(details), axis=0)
    else:
        sigma = np.ones((len(details), rows))
    if rule == "approximation":
        return sigma, np.full_like(sigma, np.inf)
    threshold = np.zeros_like(sigma)
    total = sum(c.shape[-1] for c in coefficients)
    for j, d in enumerate(details):
        if rule == "universal":
            threshold[j] = sigma[j] * np.sqrt(2 * np.log(total))
            continue
        # A level without any noise (a stuck sensor) is left alone instead of being divided by
        # zero.
        usable = sigma[j] > 1e-8 * np.max(np.abs(d), axis=-1)
        z = d / np.where(usable, sigma[j], 1.0)[:, None]
        chosen = sure_threshold(z) if rule == "sure" else hybrid_threshold(z)
        threshold[j] = np.where(usable, chosen * sigma[j], 0.0)
    return sigma, threshold


def shrink(coefficients: np.ndarray, threshold: np.ndarray, mode: str) -> np.ndarray:
    """Soft or hard threshold; `threshold` broadcasts against `coefficients` and may be infinite."""
    kept = np.abs(coefficients) > threshold
    if mode == "hard":
        return np.where(kept, coefficients, 0.0)
    finite = np.where(np.isfinite(threshold), threshold, 0.0)
    return np.where(kept, coefficients - np.sign(coefficients) * finite, 0.0)


def max_level(n: int, wavelet: str) -> int:
    """Deepest level at which at least one coefficient is free of the edges."""
    return pywt.dwt_max_level(n, pywt.Wavelet(wavelet).dec_len)
