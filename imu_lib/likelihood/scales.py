"""The statistics of a long record from two scales: the slow end of the whole transform, the fast
end from tapered segments.

Segments under Hann's window, half overlapping, keep 97 per cent of what the whole transform knows
of a smooth spectrum, and unlike those of a bare transform their edges do not fill the nulls of a
filter.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import get_window
from scipy.stats import chi2

from imu_lib.arrays import Array

from .layout import WIDTH, Stretch, edges_of
from .lines import LINE_TAIL, without_lines
from .statistics import Statistics

#: Ordinates that the level around one is taken from where lines are looked for.
_AROUND = 31


def of_scales(
    slow: Any,
    fast: Any,
    fs: float,
    seam: float,
    *,
    exclude_lines: bool = False,
    width: float = WIDTH,
) -> Statistics:
    """The statistics of long stretches.

    Parameters
    ----------
    slow : sequence of (int, ndarray)
        Samples n of each stretch and its first cosine coefficients p = 1, 2, ... (orthonormal), up
        to `seam` or beyond.
    fast : sequence of (int, int, ndarray)
        Samples of a segment (even), number of half-overlapping segments in the stretch, and the
        mean over them of their one-sided density under Hann's window, as of `numpy.fft.rfft`.
    fs : float, Hz
    seam : float, Hz
        Below it the slow coefficients count, from there on the fast ones.
    exclude_lines, width
        As for `Statistics.of`.
    """
    stretches, lines = [], []
    for n, c in slow:
        stretch = Stretch(0, n, c * np.sqrt(2 / fs), edges_of(n, fs, (0.0, seam), width))
        if exclude_lines:
            stretch, found = without_lines(stretch, fs)
            lines += found
        stretches.append(stretch)
    for size, count, power in fast:
        own, together = freedom(size, count)
        power = power[1:-1]
        dropped = np.zeros(0, int)
        edges = edges_of(size // 2, fs, (seam, fs / 2), width)
        if exclude_lines:
            dropped, found = _lines(power, own, edges, fs / size, size)
            lines += found
        kept = np.sqrt(power * together)
        kept[dropped] = 0.0
        stretches.append(Stretch(0, size // 2, kept, edges, dropped, times=together, tapered=True))
    return Statistics.assembled(fs, tuple(stretches), 0.0, lines)


def freedom(size: int, count: int) -> tuple[float, float]:
    """Degrees of freedom of one ordinate of `count` half-overlapping segments, and how many each
    has in a sum over many neighbours (Percival and Walden 1993, Sec. 6.17).
    """
    window = get_window("hann", min(size, 1 << 12))
    norm, half = np.sum(window**2), window.size // 2
    shared = (np.sum(window[half:] * window[:-half]) / norm) ** 2
    own = 2 * count / (1 + 2 * (1 - 1 / count) * shared)
    near = np.abs(np.fft.rfft(window**2)[1:4] / norm) ** 2
    return float(own), float(own / (1 + 2 * near.sum()))


def _lines(
    power: Array, own: float, edges: Any, step: float, size: int
) -> tuple[Array, list[tuple[float, float]]]:
    """Places of the ordinates that stand out of their surroundings as one in 1e9 would, and the
    lines that they are: (frequency, rms).
    """
    level = median_filter(power, _AROUND, mode="nearest") * own / chi2.median(own)
    out = np.flatnonzero(power * own > chi2.isf(LINE_TAIL, own) * level)
    out = out[(out >= edges[0] - 1) & (out < edges[-1] - 1)]
    if not out.size:
        return out, []
    found = []
    for group in np.split(out, np.flatnonzero(np.diff(out) > 3) + 1):
        peak = group[np.argmax(power[group])]
        around = slice(max(peak - 2, 0), peak + 3)  # the window's main lobe
        square = (power[around] - level[around] / own * chi2.median(own)).sum() * step
        found.append(((peak + 1) * step, float(np.sqrt(max(square, 0.0)))))
    return out, found
