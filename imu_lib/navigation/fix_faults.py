"""What the positions of the fixes say against themselves: far off between their neighbours, jumping
for good, only repeating the last.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.drive import Drive

from . import earth

FAR_OFF = 12.0  # times the median distance of a fix from the middle of its neighbours
PASSES = 5
JUMP, STAYS, BESIDE = 10.0, 0.7, 5  # m; share of a jump that stays; fixes on either side
CREEPING = 1.0  # m/s: what repeats its position and creeps on the mean stands
REPEATED = 0.3  # share of the rows


def wild(drive: Drive) -> tuple[float, float] | None:
    """(share, standard deviation m) of positions that lie far off between their neighbours; None
    where there are hardly any, or so many that they are the receiver's usual ones.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1)
    apart, peak = _between(time[good], position[good])
    share = float(peak.mean()) if peak.size else 0.0
    if not 0.002 < share < 0.2:
        return None
    return share, float(np.sqrt(np.mean(apart[peak] ** 2) / 3.0))


def far_off(time: Array, position: Array) -> Array:
    """Which positions (m,) lie far off between their neighbours, those that were found so left
    out of them, and those that are not there; (m, 3) rad, rad, m.
    """
    good = kept = np.flatnonzero(np.isfinite(position).all(axis=1))
    for _ in range(PASSES):  # of two wild ones side by side the farther one hides the other
        _, peak = _between(time[kept], position[kept])
        if not peak.any():
            break
        kept = np.delete(kept, 1 + np.flatnonzero(_close(time[kept]))[peak])
    out = np.zeros(len(position), bool)
    out[np.setdiff1d(good, kept)] = True
    return out


def _close(time: Array) -> Array:
    """Which fixes but the first and last have both neighbours near in time."""
    return (time[2:] - time[:-2]) < 4.0 * np.median(np.diff(time))


def _between(time: Array, position: Array) -> tuple[Array, Array]:
    """(distance from the middle of its neighbours, m, whether it lies far off) of fixes that have
    them near in time; nothing where fixes are few.
    """
    if time.size < 50:
        return np.zeros(0), np.zeros(0, bool)
    ned = earth.meters(position, position[0])
    part = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], 1e-9)
    apart = ned[1:-1] - ned[:-2] - part[:, None] * (ned[2:] - ned[:-2])
    apart = np.linalg.norm(apart[_close(time)], axis=1)
    size = np.maximum(np.median(apart), 0.01)
    # a wild one moves the middle of its neighbours by half as much, and of two the farther counts
    return apart, (apart > FAR_OFF * size) & (apart >= maximum_filter1d(apart, 5))


def held(drive: Drive):
    """Which fixes (m,) only repeat the position of the one before while the drive goes on: of a
    receiver that gives its last solution until it has another.
    """
    position, time = np.asarray(drive.gnss_position, float), np.asarray(drive.gnss_time)
    out = np.zeros(len(position), bool)
    same = (position[1:] == position[:-1]).all(axis=1)
    if not same.any():
        return out
    standing = np.zeros_like(out)
    for first, last in zip(*timing.runs(same), strict=True):  # rows first to last are alike
        standing[first + 1 : last + 1] = True
        if last + 1 >= len(position):
            continue
        moved = float(earth.horizontal(position[last + 1 : last + 2], position[first])[0])
        if moved > CREEPING * (time[last + 1] - time[first]) and moved > 2.0:
            out[first + 1 : last + 1] = True
    # what repeats most of its rows on the way does so where it stands, too
    return out | standing if out.mean() > REPEATED else out


def jumps(drive: Drive):
    """Times (k,) s and sizes (k, 3) m, NED, of jumps of the positions that stay and that the fixes
    before and after, or their velocities, do not explain.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1) & ~held(drive)
    velocity = None if drive.gnss_velocity is None else np.asarray(drive.gnss_velocity, float)
    if velocity is not None and np.isfinite(velocity[good]).all(axis=1).mean() > 0.9:
        good &= np.isfinite(velocity).all(axis=1)
        velocity = velocity[good]
    else:
        velocity = None
    time, position = time[good], position[good]
    none = np.zeros(0), np.zeros((0, 3))
    if time.size < 50:
        return none
    step = np.diff(time)
    left = earth.meters(position[1:], position[:-1])
    if velocity is not None:
        left = left - 0.5 * (velocity[1:] + velocity[:-1]) * step[:, None]
    else:
        left = left - median_filter(left / step[:, None], (7, 1)) * step[:, None]
    size = np.linalg.norm(left, axis=1)
    usual = np.median(size) + 1e-3
    large = (size > np.maximum(JUMP, FAR_OFF * usual)) & (step < 4.0 * np.median(step))
    found = []
    for k in np.flatnonzero(large):
        near = left[max(k - BESIDE, 0) : k + BESIDE + 1].sum(axis=0)
        if near @ left[k] > STAYS * size[k] ** 2:
            found.append(k)
    return (time[1:][found], left[found]) if found else none
