"""Clipping at the ends of the range."""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import Saturation as Stage

from .base import Effect, Finding

#: Log-likelihood that the outermost level of a grid is fuller than its neighbours foretell, of some
#: two ends: noise exceeds it in one of 1e5 channels. Without a grid: visits to the end; no two
#: samples of a continuous noise agree, so that the second is one too many.
MIN_GAIN, MIN_VISITS = 12.0, 3
#: Samples that a level holds at least where anything is read off it.
MIN_LEVEL = 8
#: Visits to a rail from which on it is a fact, where it holds more samples than lie just inside it:
#: within this share of a standard deviation, and so many levels of a grid.
AGAIN, INSIDE, LEVELS = 20, 0.1, 2.5
#: Samples within one standard deviation of a rail per sample on it at the least: a signal that is
#: cut off comes up to its rail, one that drops out does not.
BESIDE = 0.1


def _piled(x: Array, step: float | None, side: float) -> float:
    """How far the outermost value is overfull, as a log-likelihood gain; 0 where it is not, and
    without bound where there is no grid on which values agree by chance.
    """
    y = side * x
    top = y.max()
    at = np.flatnonzero(y > top - 0.5 * step) if step else np.flatnonzero(y == top)
    visits = 1 + np.count_nonzero(np.diff(at) > 1)
    if visits < MIN_VISITS:  # one frozen value is no rail
        return 0.0
    if step is None:
        return np.inf
    k = np.rint((top - y) / step).astype(np.int64)
    h = np.bincount(k[k < 4], minlength=4).astype(float)
    if h[0] < MIN_LEVEL or k.max() < 2:  # of two levels each is an end
        return 0.0
    # the logarithm of a rounded normal's occupation is concave: the last level is below the line
    # of the two before it
    want = (h[1] + 0.5) ** 2 / (h[2] + 0.5)
    want = (
        min(
            want + 2 * want * np.sqrt(4 / (h[1] + 0.5) + 1 / (h[2] + 0.5)),
            h[1] + 3 * np.sqrt(h[1] + 1),
        )
        + 0.5
    )
    over = float(h[0] * np.log(h[0] / want) - (h[0] - want)) if h[0] > want else 0.0
    # coarse steps hide the pile in the level's own width: but the level beyond, foretold by a
    # parabola through the three before, is empty; three levels make no parabola where steps are
    # so coarse that one of them is
    if h[3] < MIN_LEVEL:
        return over
    log = np.log(h[1:] + 0.5)
    beyond = float(
        np.exp(
            6 * log[0]
            - 8 * log[1]
            + 3 * log[2]
            - 2 * np.sqrt(36 / (h[1] + 0.5) + 64 / (h[2] + 0.5) + 9 / (h[3] + 0.5))
        )
    )
    return max(over, beyond if beyond >= MIN_GAIN else 0.0)


class Saturation(Effect):
    name = "saturation"
    alters = True
    cause = "The signal leaves the range of an amplifier or converter and is clipped."
    domain = "distribution"

    def detect(self, x: Array, step: float | None, held: Stage | None) -> Finding | None:
        """`step` of the grid if the output is rounded, `held` the base model's stage."""
        high, low = _piled(x, step, 1.0), _piled(x, step, -1.0)
        tolerance = (step or 0.0) + 1e-6 * np.ptp(x)
        if held is not None:
            old_low = -held.limit if held.low is None else held.low
            high = 0.0 if abs(x.max() - held.limit) <= tolerance else high
            low = 0.0 if abs(x.min() - old_low) <= tolerance else low
        if max(high, low) < MIN_GAIN:
            return None
        top, bottom = float(x.max()), float(x.min())
        half = 0.5 * (step or 0.0)
        if high >= MIN_GAIN and low >= MIN_GAIN and abs(top + bottom) > tolerance:
            stage = Stage(limit=top, low=bottom)
        elif high >= MIN_GAIN:
            stage = (
                Stage(limit=top)
                if bottom > -top - half or low >= MIN_GAIN
                else Stage(limit=top, low=bottom - abs(top - bottom))
            )
        else:
            stage = (
                Stage(limit=-bottom)
                if -bottom >= top
                else Stage(limit=top + abs(top - bottom), low=bottom)
            )
        above = x >= top - 1e-9 * abs(top) if high >= MIN_GAIN else np.zeros(len(x), bool)
        below = x <= bottom + 1e-9 * abs(bottom) if low >= MIN_GAIN else np.zeros(len(x), bool)
        share = (above.sum() + below.sum()) / len(x)
        ends = " and ".join(
            f"{v:.5g}" for v, on in ((top, high >= MIN_GAIN), (bottom, low >= MIN_GAIN)) if on
        )
        found = Finding(
            self,
            stage,
            max(high, low) if np.isfinite(max(high, low)) else None,
            f"distribution of the samples: {100 * share:.3g} % of them sit exactly at the end of "
            f"the range, {ends}",
            {"limit": sorted([stage.limit - half, stage.limit + half])},
        )
        found.mask = np.where(above, 1, np.where(below, -1, 0)).astype(np.int8)
        found.counted = all(_rail(x, on, step) for on in (above, below) if on.any())
        return found


def _rail(x: Array, on: Array, step: float | None) -> bool:
    """Whether the samples marked `on`, at one end of the range, show by themselves that the signal
    goes on beyond it.
    """
    visits = np.count_nonzero(np.diff(on.astype(np.int8)) == 1) + bool(on[0])
    sd = 0.7413 * float(np.subtract(*np.quantile(x[~on], [0.75, 0.25])))
    apart = np.abs(x[~on] - x[on][0])
    inside = max(INSIDE * sd, LEVELS * (step or 0.0))
    held, near = np.count_nonzero(on), np.count_nonzero(apart < inside)
    return bool(visits >= AGAIN and near < held and np.count_nonzero(apart < sd) > BESIDE * held)


EFFECTS = (Saturation(),)
