"""Straight segments of given slopes in a log-log curve, found by least cost instead of by eye.

A curve of Allan deviation or of spectral density is cut into stretches that a line of one of the
expected slopes describes within its uncertainty, and into transitions between them. The cheapest
cut is found exactly, by dynamic programming: a point in a segment costs its squared standardised
distance from the segment's line, a point in a transition costs `miss`, every segment costs
`change`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from imu_lib.arrays import Array, ArrayLike


@dataclass(frozen=True)
class Segment:
    """A stretch of one slope: y = 10^intercept * x^slope for x from `start` to `stop`.

    Attributes
    ----------
    slope : float
    first, last : int
        Indices of its end points in the curve.
    start, stop : float
        Abscissae of these (s or Hz).
    intercept : float
        log10 of the line at x = 1.
    scatter : float
        Root mean square distance of the points from the line, relative.
    """

    slope: float
    first: int
    last: int
    start: float
    stop: float
    intercept: float
    scatter: float

    @property
    def decades(self) -> float:
        """Length on the logarithmic axis."""
        return float(np.log10(self.stop / self.start))

    def at(self, x: ArrayLike) -> Array:
        """The line at x."""
        return 10**self.intercept * np.asarray(x, dtype=float) ** self.slope


def segments(
    x: Array,
    y: Array,
    relative_sd: Array,
    slopes: Sequence[float],
    *,
    least: float = 0.3,
    floor: float = 0.03,
    miss: float = 4.0,
    change: float = 12.0,
) -> tuple[Segment, ...]:
    """Cut a log-log curve into segments of given slopes.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        The curve, positive; x increasing.
    relative_sd : ndarray, shape (n,)
        Relative standard error of y.
    slopes : sequence of float
    least : float
        Shortest segment, decades of x.
    floor : float
        Relative distance from a line that counts as one standard error even where y is known
        better: two noises side by side bend the curve a little everywhere.
    miss, change : float
        Cost of a point outside of all segments, and of a segment.

    Returns
    -------
    tuple of Segment
    """
    u, v = np.log10(x), np.log10(y)
    sd = np.maximum(relative_sd, floor) / np.log(10)
    w = 1 / sd**2
    n = u.size
    total = {}
    for s in slopes:
        r = v - s * u
        total[s] = [np.concatenate([[0.0], np.cumsum(t)]) for t in (w, w * r, w * r * r)]
    best = np.zeros(n + 1)
    step: list[tuple[int, float] | None] = [None] * (n + 1)
    for j in range(1, n + 1):
        best[j], step[j] = best[j - 1] + miss, None
        starts = np.flatnonzero(u[j - 1] - u[:j] >= least - 1e-9)
        starts = starts[starts <= j - 3]
        if starts.size == 0:
            continue
        for s in slopes:
            a, b, c = (t[j] - t[starts] for t in total[s])
            cost = best[starts] + np.maximum(c - b * b / a, 0.0) + change
            k = int(np.argmin(cost))
            if cost[k] < best[j]:
                best[j], step[j] = cost[k], (int(starts[k]), s)
    found, j = [], n
    while j > 0:
        last = step[j]
        if last is None:
            j -= 1
            continue
        i, s = last
        weight, line = w[i:j], v[i:j] - s * u[i:j]
        level = float(np.average(line, weights=weight))
        scatter = float(np.sqrt(np.average((line - level) ** 2, weights=weight)) * np.log(10))
        found.append(Segment(float(s), i, j - 1, float(x[i]), float(x[j - 1]), level, scatter))
        j = i
    return tuple(reversed(found))


def rising(found: Sequence[Segment]) -> tuple[Segment, ...]:
    """The longest chain (in decades) of segments whose slopes do not fall: what slow noises follow
    fast ones in.

    A Gauss-Markov bump or scatter at long averaging times gives stretches out of this order; they
    are stretches, but no noise of their own is read from them.
    """
    best: list[tuple[float, tuple[Segment, ...]]] = []
    for i, segment in enumerate(found):
        no_segment: tuple[float, tuple[Segment, ...]] = (0.0, ())
        before = max(
            [no_segment, *(best[k] for k in range(i) if found[k].slope <= segment.slope)],
            key=lambda b: b[0],
        )
        best.append((before[0] + segment.decades, before[1] + (segment,)))
    return max(best, key=lambda b: b[0])[1] if best else ()
