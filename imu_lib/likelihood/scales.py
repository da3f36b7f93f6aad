"""The statistics of a long record from two scales: the slow end of the whole transform, the fast
end from segments.
"""

import numpy as np

from .statistics import WIDTH, Statistics, Stretch, _edges, _without_lines


def of_scales(slow, fast, fs, seam, *, exclude_lines=False, width=WIDTH) -> Statistics:
    """The statistics of long stretches.

    Parameters
    ----------
    slow : sequence of (int, ndarray)
        Samples n of each stretch and its first cosine coefficients p = 1, 2, ... (orthonormal), up
        to `seam` or beyond.
    fast : sequence of (int, int, ndarray)
        Samples n of a segment, number of segments in the stretch, and the sum over them of their
        squared coefficients p = 1 ... n - 1.
    fs : float, Hz
    seam : float, Hz
        Below it the slow coefficients count, from there on the fast ones.
    exclude_lines, width
        As for `Statistics.of`.
    """
    stretches, lines = [], []
    scaled = [(n, 1, c * np.sqrt(2 / fs), (0.0, seam)) for n, c in slow]
    scaled += [(n, k, np.sqrt(p * (2 / fs)), (seam, fs / 2)) for n, k, p in fast]
    for n, times, coefficients, band in scaled:
        edges = _edges(n, fs, band, width)
        stretch = Stretch(0, n, coefficients, edges, times=times)
        if exclude_lines:
            stretch, found = _without_lines(stretch, fs)
            lines += found
        stretches.append(stretch)
    return Statistics._assemble(fs, tuple(stretches), 0.0, lines)
