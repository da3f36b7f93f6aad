"""De-noising without the future.

The last sample of a de-noised window is a sum over few coefficients: those whose synthesis
function reaches the window's end. Each of them is a fixed linear combination of the window's
samples, the mirrored edge included. So the sliding form needs no transform per sample: one FIR
filter per contributing coefficient, run over the whole record by FFT, a threshold, and a sum. Only
the thresholds need the other coefficients, once per `refresh` samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pywt
from scipy.signal import oaconvolve

from imu_lib.wavelet.shrinkage import max_level, row_thresholds, shrink

#: Windows de-noised in one call when thresholds are computed (bounds the memory).
_SAMPLES_AT_ONCE = 2_000_000


@dataclass(frozen=True)
class EdgeBank:
    """FIR filters that give the contributing coefficients of a window from its samples, and their
    weights.

    `filters[j]` has shape (m_j, window) and `weights[j]` (m_j,) for detail level j + 1;
    `approximation` (window,) is the whole contribution of the approximation. Filters run along
    time: the last column meets the newest sample.
    """

    filters: tuple[np.ndarray, ...]
    weights: tuple[np.ndarray, ...]
    approximation: np.ndarray


@lru_cache(maxsize=64)
def edge_bank(level: int, window: int, wavelet: str) -> EdgeBank:
    """The bank for windows of `window` samples, half-point symmetric at both ends as `pywt.dwt`
    has them.
    """
    w = pywt.Wavelet(wavelet)
    taps = w.dec_len
    lengths = [window]
    for _ in range(level):
        lengths.append((lengths[-1] + taps - 1) // 2)
    memo: dict[tuple[int, int], np.ndarray] = {}

    def approximation_row(
        j, i
    ):  # coefficient i of approximation level j as a combination of the window's samples
        if j == 0:
            row = np.zeros(window)
            row[i] = 1.0
            return row
        if (j, i) not in memo:
            memo[j, i] = analysis_row(j, i, w.dec_lo)
        return memo[j, i]

    def analysis_row(j, i, filter_):
        n = lengths[j - 1]
        row = np.zeros(window)
        for k, f in enumerate(filter_):
            t = (2 * i + 1 - k) % (2 * n)  # half-point symmetric extension, of period 2 n
            row += f * approximation_row(j - 1, t if t < n else 2 * n - 1 - t)
        return row

    filters, weights = [], []
    need = {window - 1: 1.0}  # weights of the level's approximations in the last sample
    for j in range(1, level + 1):
        deeper: dict[int, float] = {}
        details: dict[int, float] = {}
        for t, weight in need.items():
            for i in range(max(0, (t - 1) // 2), min(lengths[j], (t + taps - 2) // 2 + 1)):
                k = t + taps - 2 - 2 * i
                if 0 <= k < taps:
                    details[i] = details.get(i, 0.0) + weight * w.rec_hi[k]
                    deeper[i] = deeper.get(i, 0.0) + weight * w.rec_lo[k]
        filters.append(np.array([analysis_row(j, i, w.dec_hi) for i in details]))
        weights.append(np.array(list(details.values())))
        need = deeper
    approximation = sum(weight * approximation_row(level, i) for i, weight in need.items())
    return EdgeBank(tuple(filters), tuple(weights), approximation)


@dataclass(frozen=True)
class EdgeResponse:
    """What the newest sample of the sliding low-pass is worth.

    Parameters
    ----------
    noise_gain : float
        Standard deviation that unit white noise keeps (mid-record: 2^(-level/2) on average).
    delay : float
        Lag behind a steady ramp, samples.
    """

    noise_gain: float
    delay: float


def edge_response(level: int, *, window: int | None = None, wavelet: str = "db4") -> EdgeResponse:
    """Noise and lag of the newest sample, approximation only.

    Both depend on where the grid of the decimation falls against the window's end, which the
    length of the window modulo 2^level decides: a window that ends well for the noise lags more.
    """
    h = edge_bank(level, 32 * 2**level if window is None else window, wavelet).approximation
    return EdgeResponse(float(np.linalg.norm(h)), float(h @ np.arange(h.size)[::-1]))


def sliding(x, level, wavelet, threshold, noise, mode, *, window, refresh):
    """Sliding form; see `imu_lib.wavelet.denoise`. `x` is (n,)."""
    out = x.copy()  # the first samples, too few for one level, pass as they are
    size = min(2 * pywt.Wavelet(wavelet).dec_len, window)
    while size <= x.size:
        # A window of `size` samples serves until one of twice the length is full.
        following = min(2 * size, window)
        stop = x.size if size == window else min(x.size, following - 1)
        depth = min(level, max_level(size, wavelet))
        if depth >= 1:
            out[size - 1 : stop] = _slide(
                x[:stop], depth, wavelet, threshold, noise, mode, size, refresh
            )
        if size == window:
            break
        size = following
    return out


def _slide(x, level, wavelet, threshold, noise, mode, window, refresh):
    """Outputs for samples window - 1 ... n - 1 of `x`."""
    bank = edge_bank(level, window, wavelet)
    out = _filter(x, bank.approximation[None])[0]
    if threshold == "approximation":
        return out
    limits = np.repeat(
        _recent_thresholds(x, level, wavelet, threshold, noise, window, refresh), refresh, axis=1
    )
    for j in range(level):
        coefficients = _filter(x, bank.filters[j])
        out += bank.weights[j] @ shrink(coefficients, limits[j, : out.size], mode)
    return out


def _filter(x, filters):
    first = np.flatnonzero(np.any(filters != 0, axis=0))[0]
    short = filters[:, first:]
    return oaconvolve(x[None, first:], short[:, ::-1], mode="valid", axes=1)


def _recent_thresholds(x, level, wavelet, threshold, noise, window, refresh):
    """Thresholds, shape (J, r), from the windows that end at samples window - 1, + refresh, + 2
    refresh, ...
    """
    windows = np.lib.stride_tricks.sliding_window_view(x, window)[::refresh]
    step = max(1, _SAMPLES_AT_ONCE // window)
    parts = []
    for k in range(0, len(windows), step):
        coefficients = pywt.wavedec(
            windows[k : k + step], wavelet, mode="symmetric", level=level, axis=-1
        )
        parts.append(row_thresholds(coefficients, threshold, noise)[1])
    return np.concatenate(parts, axis=1)


def by_blocks(x, denoise_rows, options, window, block):
    """Block form; see `imu_lib.wavelet.denoise`. The first window is delivered as one block."""
    if x.size <= window:
        depth = min(options[0], max_level(x.size, options[1]))
        return denoise_rows(x[None], depth, *options[1:])[0] if depth else x.copy()
    out = np.empty_like(x)
    out[:window] = denoise_rows(x[None, :window], *options)[0]
    ends = np.arange(window + block, x.size + 1, block)
    step = max(1, _SAMPLES_AT_ONCE // window)
    view = np.lib.stride_tricks.sliding_window_view(x, window)
    for k in range(0, ends.size, step):
        e = ends[k : k + step]
        done = denoise_rows(view[e - window], *options)[:, -block:]
        out[e[0] - block : e[-1]] = done.reshape(-1)
    rest = x.size - (ends[-1] if ends.size else window)
    if rest:
        out[-rest:] = denoise_rows(x[None, -window:], *options)[0, -rest:]
    return out
