"""De-noising of a whole record, and the door to the causal forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pywt

from imu_lib.wavelet import causal as causal_forms
from imu_lib.wavelet.shrinkage import RULES, SCALES, max_level, row_thresholds, shrink


@dataclass(frozen=True)
class Thresholds:
    """What a threshold rule does at each level; level 1 (the highest band) first.

    Parameters
    ----------
    sigma, threshold : ndarray, shape (J,)
        Noise scale and threshold, in the unit of the signal.
    kept : ndarray, shape (J,)
        Share of the coefficients above the threshold.
    energy_kept : ndarray, shape (J,)
        Share of the level's energy that is left after shrinking.
    """

    sigma: np.ndarray
    threshold: np.ndarray
    kept: np.ndarray
    energy_kept: np.ndarray


def denoise(
    x,
    level,
    *,
    wavelet="db4",
    threshold="sure",
    noise="per_level",
    mode="soft",
    causal=False,
    window=None,
    refresh=None,
    block=None,
):
    """De-noise a signal by shrinking its wavelet details.

    Parameters
    ----------
    x : array_like, shape (n,) or (n, k)
        The signal, equally spaced; columns are de-noised one by one.
    level : int
        Levels of decomposition; 0 returns a copy.
    wavelet : str
        A discrete wavelet of PyWavelets.
    threshold : {"sure", "hybrid", "universal", "approximation"}
        Rule of the threshold; "approximation" drops all details: a pure low-pass.
    noise : {"per_level", "first_level", "unit"}
        Where the noise scale comes from. "per_level" suits coloured noise, such as an IMU's
        filtered output.
    mode : {"soft", "hard"}
    causal : {False, True, "sliding", "block"}
        False: the whole record at once, half-point symmetric at both ends; every sample uses the
        future. True or "sliding": sample k uses samples up to k alone, as if the last `window` of
        them were de-noised as a record of their own and the last one taken; no delay. "block": the
        same, `block` samples at a time: a sample is up to `block` samples late and sees the future
        within its own block.
    window : int, optional
        Past that a causal form looks at, samples; default 32 * 2^level. Records start with shorter
        windows and fewer levels, doubling until the window is full.
    refresh, block : int, optional
        After how many samples the sliding form computes its thresholds anew; samples of a block.
        Default 2^level.

    Returns
    -------
    ndarray, the shape of `x`

    Raises
    ------
    ValueError
        On a level that the record or the window is too short for, non-finite samples, or an
        unknown option.
    """
    x = np.asarray(x, dtype=float)
    _check(x, level, threshold, noise, mode, causal)
    rows, lengths = (level, wavelet, threshold, noise, mode), (window, refresh, block)
    if x.ndim == 2:
        return np.stack([_denoised(column, rows, causal, *lengths) for column in x.T], axis=1)
    return _denoised(x, rows, causal, *lengths)


def _denoised(x, rows, causal, window, refresh, block):
    """One signal; `rows` as `denoise_rows` takes them."""
    level, wavelet = rows[:2]
    if level == 0:
        return x.copy()
    if not causal:
        _check_length(x.size, level, wavelet, "`x`")
        return denoise_rows(x[None], *rows)[0]
    window = 32 * 2**level if window is None else int(window)
    _check_length(window, level, wavelet, "`window`")
    if causal == "block":
        return causal_forms.by_blocks(x, denoise_rows, rows, window, int(block or 2**level))
    return causal_forms.sliding(x, *rows, window=window, refresh=int(refresh or 2**level))


def denoise_rows(rows, level, wavelet, threshold, noise, mode):
    """De-noise each row of `rows`, shape (r, n), as a record of its own."""
    coefficients = pywt.wavedec(rows, wavelet, mode="symmetric", level=level, axis=-1)
    _, limits = row_thresholds(coefficients, threshold, noise)
    for j in range(level):
        coefficients[level - j] = shrink(coefficients[level - j], limits[j][:, None], mode)
    return pywt.waverec(coefficients, wavelet, mode="symmetric", axis=-1)[:, : rows.shape[1]]


def thresholds(
    x, level, *, wavelet="db4", threshold="sure", noise="per_level", mode="soft"
) -> Thresholds:
    """The thresholds that `denoise` would use on the whole record `x`, shape (n,), and what they
    leave.
    """
    x = np.asarray(x, dtype=float)
    _check(x, level, threshold, noise, mode, False)
    _check_length(x.size, level, wavelet, "`x`")
    coefficients = pywt.wavedec(x[None], wavelet, mode="symmetric", level=level, axis=-1)
    sigma, limits = row_thresholds(coefficients, threshold, noise)
    details = [c[0] for c in coefficients[:0:-1]]
    after = [shrink(d, t, mode) for d, t in zip(details, limits[:, 0])]
    return Thresholds(
        sigma=sigma[:, 0],
        threshold=limits[:, 0],
        kept=np.array([np.mean(a != 0) for a in after]),
        energy_kept=np.array(
            [
                np.sum(a * a) / max(np.sum(d * d), np.finfo(float).tiny)
                for a, d in zip(after, details)
            ]
        ),
    )


def _check(x, level, threshold, noise, mode, causal):
    for value, allowed, name in (
        (threshold, RULES, "threshold"),
        (noise, SCALES, "noise"),
        (mode, ("soft", "hard"), "mode"),
        (causal, (False, True, "sliding", "block"), "causal"),
    ):
        if value not in allowed:
            raise ValueError(
                f"`{name}` must be one of {', '.join(map(str, allowed))}, not {value!r}"
            )
    if int(level) != level or level < 0:
        raise ValueError(f"`level` must be a whole number, 0 or more, not {level!r}")
    if x.ndim not in (1, 2) or x.shape[0] == 0:
        raise ValueError(f"`x` must have shape (n,) or (n, k) with n > 0, not {x.shape}")
    if not np.all(np.isfinite(x)):
        raise ValueError(
            "`x` holds samples that are not finite: remove or fill them before de-noising"
        )


def _check_length(n, level, wavelet, name):
    if max_level(n, wavelet) < level:
        raise ValueError(
            f"{name} has {n} samples, too few for `level` {level} of {wavelet}: "
            f"its deepest level is {max_level(n, wavelet)}"
        )
