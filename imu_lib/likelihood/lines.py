"""Spectral lines that are left out of the statistics of a smooth spectrum."""

from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from .layout import Stretch

LINE_TAIL = 1e-9


def without_lines(s: Stretch, fs: float) -> tuple[Stretch, list[tuple[float, float]]]:
    """The stretch without the ordinates beyond the LINE_TAIL point of their band's median level,
    and the lines.
    """
    limit = ndtri(LINE_TAIL / 2) ** 2
    ordinates = s.coefficients**2
    top = np.maximum.reduceat(ordinates[: s.edges[-1] - 1], s.edges[:-1] - 1)
    dropped, lines = [], []
    for b in np.flatnonzero((s.count >= 12) & (top > limit / 3 * s.sums(ordinates) / s.count)):
        inside = ordinates[s.edges[b] - 1 : s.edges[b + 1] - 1]
        out = np.flatnonzero(inside > limit * np.median(inside) / 0.454936)
        if len(out) and len(out) < len(inside) / 4:
            dropped.append(s.edges[b] - 1 + out)
            # neighbours are one line; ordinates 2 c^2/fs sum to the mean square times 2 n/fs
            for group in np.split(out, np.flatnonzero(np.diff(out) > 3) + 1):
                peak = s.edges[b] + group[np.argmax(inside[group])]
                lines.append(
                    (peak * fs / (2 * s.n), float(np.sqrt(inside[group].sum() * fs / 2 / s.n)))
                )
    if not dropped:
        return s, []
    gone = np.concatenate(dropped)
    kept = s.coefficients.copy()
    kept[gone] = 0.0
    return replace(s, coefficients=kept, dropped=gone), lines
