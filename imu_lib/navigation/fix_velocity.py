"""Velocities at the fixes for the filter's start: as received, or of the positions, without fixes
that are far off those beside them.
"""

import numpy as np
from scipy.ndimage import median_filter

from . import earth, fix_faults
from .preparation import Fixes

MOVING = 3.0  # m/s: above this the course is a heading
SHORTEST = 1.0  # s before and after a fix over which its speed is taken where it has none
FEWEST = 10  # positions of which some can be told to lie far off
SPIKE = 3.0  # m/s by which a velocity lies apart from the median of the five about it


def velocity_of(fixes: Fixes, *, span=None):
    """NED velocity at each fix, (m, 3): as received, or the slope of the positions over `span` s
    where there is none (NaN at the ends; None: as long as their scatter asks for).
    """
    has = (fixes.use & 2) > 0
    if has.any():
        of = np.full((int(fixes.index.max()) + 1, 3), np.nan)
        of[fixes.index[has]] = fixes.value[has, 3:]
        return of[fixes.index]
    span = span_of(fixes) if span is None else span
    out = np.full((fixes.time.size, 3), np.nan)
    after = np.searchsorted(fixes.time, fixes.time + span)
    before = np.searchsorted(fixes.time, fixes.time - span, side="right") - 1
    for i in np.flatnonzero((after < fixes.time.size) & (before >= 0)):
        part = slice(before[i], after[i] + 1)
        time = fixes.time[part] - fixes.time[part].mean()
        if fixes.time[after[i]] - fixes.time[before[i]] < 6.0 * span:
            moved = earth.meters(fixes.value[part, :3], fixes.value[before[i], :3])
            out[i] = time @ moved / (time @ time)
    return out


def _scatter(fixes: Fixes):
    """Horizontal scatter of the positions from one fix to the next, m: of their second differences,
    which hardly move with the vehicle where fixes are dense.
    """
    p = fixes.value[(fixes.use & 1) > 0, :3]
    if len(p) < 10:
        return 0.0
    moved = earth.meters(p, p[0])[:, :2]
    return float(np.median(np.abs(np.diff(moved, 2, axis=0))) * 1.48 / np.sqrt(6.0))


def slope_sd(fixes: Fixes, span):
    """Standard deviation of a velocity that `velocity_of` takes from positions, m/s."""
    if ((fixes.use & 2) > 0).any():
        return 0.0
    interval = max(float(np.median(np.diff(np.unique(fixes.time)))), 1e-3)
    count = 2.0 * span / interval + 1.0
    return _scatter(fixes) / (span * np.sqrt(max(count, 2.0) / 3.0))


def span_of(fixes: Fixes):
    """Half of the time over which positions are made a velocity, s: the shortest that does not make
    a standing car move.
    """
    return next((s for s in (SHORTEST, 1.5, 2.0) if 8.0 * slope_sd(fixes, s) < MOVING), 3.0)


def without_spikes(velocity):
    """Velocities (k, 3), NaN where one lies far from those beside it: no vehicle goes so for one
    fix.
    """
    out, good = velocity.copy(), np.flatnonzero(np.isfinite(velocity).all(axis=1))
    if good.size < 5:
        return out
    usual = median_filter(velocity[good], (5, 1), mode="mirror")
    out[good[np.linalg.norm(velocity[good] - usual, axis=1) > SPIKE]] = np.nan
    return out


def sound(time, position):
    """Which positions (k, 3) at times (k,) do not lie far off those beside them, the first ones
    too; all where they are few.
    """
    out = np.ones(time.size, bool)
    if time.size < FEWEST:
        return out
    ned = earth.meters(position, position[-1])
    apart = np.linalg.norm(ned[:-2] - 2.0 * ned[1:-1] + ned[2:], axis=1)
    usual = max(float(np.median(apart)), 0.02)
    # the first ones lie far off the line of the two after them
    begin = int(np.argmin(np.append(apart > fix_faults.FAR_OFF * usual, False)))
    out[:begin] = False
    out[begin:] = ~fix_faults.far_off(time[begin:], position[begin:])
    return out
