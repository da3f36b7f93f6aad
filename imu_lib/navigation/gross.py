"""Before the filter: wrong axes, and fixes seconds away from their time, from the fixes' own motion.

A vehicle that keeps its nose along its path feels (dv/dt, v dc/dt, -g) and turns at (0, 0, dc/dt)
with speed v and course c. Both follow from the fixes alone, smoothed, and are held against the
readings under every order and sign of the axes.
"""

from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import detrend

from imu_lib.drive import Drive

from . import earth

STEP = 0.2  # s of the common grid
WIDTH = 2.0  # s of smoothing
FORCE_SD, RATE_SD = 0.5, 0.05  # m/s^2 and rad/s by which a real vehicle departs from the above
LATEST, FURTHEST = 12.0, 90.0  # s: where a match is looked for, and where else if there is none
MATCHED = 2.0  # nats: chance alone, of one shift, exceeds them once in twenty
SURE_MATCH = 0.7  # correlation that a match further away needs
LEANING = 2.5  # m/s^2: a case tilted by 15 degrees
FAR_OFF = 12.0  # times the median distance of a fix from the middle of its neighbours
ROLLING, OPPOSED = 1.0, -0.7  # m of heights that tell, and a correlation that no road has
IDENTITY = ("+x", "+y", "+z")
CLEAR = 6.0  # least gain of other axes, after tempering, nats
MIRRORED = 3.0  # nats against left-handed axes: no sensor has them, a wrong sign in a file does


@dataclass(frozen=True)
class Motion:
    """On a grid: time, expected force and rate (n, 3), smoothed readings (n, 6), moving (n,)."""

    time: np.ndarray
    expected: np.ndarray
    readings: np.ndarray
    moving: np.ndarray


def motion(drive: Drive) -> Motion | None:
    """What the fixes say of the motion, beside the readings; None where there is too little."""
    position = np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1)
    if good.sum() < 30:
        return None
    fix_time = np.asarray(drive.gnss_time)[good]
    low, high = max(drive.time[0], fix_time[0]), min(drive.time[-1], fix_time[-1])
    grid = np.arange(low + WIDTH, high - WIDTH, STEP)
    if grid.size < 100:
        return None
    width = int(WIDTH / STEP)
    velocity = None
    if drive.gnss_velocity is not None:
        v = np.asarray(drive.gnss_velocity, float)
        fine = np.isfinite(v).all(axis=1) & ~contradicted(drive)
        if fine.sum() > 0.5 * good.sum():
            t = np.asarray(drive.gnss_time)[fine]
            velocity = np.column_stack([np.interp(grid, t, c) for c in v[fine].T])
            velocity = uniform_filter1d(velocity, width + 1, axis=0)
    if velocity is None:
        ned = earth.meters(position[good], position[good][0])
        ned = np.column_stack([np.interp(grid, fix_time, c) for c in ned.T])
        ned = uniform_filter1d(ned, width + 1, axis=0)
        velocity = np.gradient(ned, STEP, axis=0)
        velocity = uniform_filter1d(velocity, width + 1, axis=0)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    acceleration = np.gradient(velocity, STEP, axis=0)
    course = np.arctan2(velocity[:, 1], velocity[:, 0])
    ahead = acceleration[:, 0] * np.cos(course) + acceleration[:, 1] * np.sin(course)
    aside = -acceleration[:, 0] * np.sin(course) + acceleration[:, 1] * np.cos(course)
    moving = uniform_filter1d((speed > 3.0).astype(float), width + 1) > 0.99
    turn = np.where(moving, aside / np.maximum(speed, 1.0), 0.0)
    g = earth.gravity(position[good][0, 0], position[good][0, 2])
    zero = np.zeros_like(speed)
    expected = np.column_stack([zero, zero, turn, ahead, aside, zero - g])
    window = max(int(WIDTH * drive.rate), 1)
    both = np.column_stack([drive.gyro, drive.accel])
    smooth = uniform_filter1d(both, window, axis=0)
    readings = np.column_stack([np.interp(grid, drive.time, c) for c in smooth.T])
    hole = np.interp(grid, drive.time[:-1], np.diff(drive.time)) < 0.5
    return Motion(grid, expected, readings, moving & hole)


def contradicted(drive: Drive):
    """Which velocities (m,) are not those at which the positions move: another solution's, or with
    axes that change from fix to fix.
    """
    time, v = np.asarray(drive.gnss_time), np.asarray(drive.gnss_velocity, float)
    position = np.asarray(drive.gnss_position, float)
    out = np.zeros(time.size, bool)
    before = np.searchsorted(time, time - 0.5 * WIDTH)
    after = np.minimum(np.searchsorted(time, time + 0.5 * WIDTH), time.size - 1)
    span = time[after] - time[before]
    known = np.isfinite(position[before] + position[after]).all(axis=1)
    k = np.flatnonzero(known & (span > 0.5 * WIDTH) & (span < 2.0 * WIDTH))
    moved = earth.meters(position[after[k]], position[before[k]])[:, :2] / span[k, None]
    apart = np.linalg.norm(moved - v[k, :2], axis=1)
    usual = np.nanmedian(apart) if k.size else 0.0  # noise of the positions, late stamps
    out[k] = apart > max(4.0, 4.0 * min(usual, 2.0)) + 0.2 * np.linalg.norm(moved, axis=1)
    return out


def late(drive: Drive) -> tuple[float, float]:
    """Time by which the fixes' stamps are late, s, and the correlation there, of turn rates and of
    accelerations; 0 where the drive does not say, or agrees nearly as well as it stands.
    """
    offset, likeness, here = best_match(drive)
    if likeness >= here + 0.05 or _gain(drive, likeness, here) > MATCHED:
        return offset, likeness
    return 0.0, likeness


def _gain(drive, likeness, here):
    """Nats by which one correlation explains more than another, of samples WIDTH seconds apart."""
    m = motion(drive)
    if m is None or not -1.0 < here < likeness < 1.0:
        return 0.0
    left = (1.0 - here**2) / (1.0 - likeness**2)
    return 0.5 * m.moving.sum() * STEP / WIDTH * float(np.log(max(left, 1.0)))


def best_match(drive: Drive) -> tuple[float, float, float]:
    """Time by which the fixes are late where their turns and accelerations match those felt best,
    s, the correlation there, and as the stamps stand; 0 where nothing matches. A few hundredths of a second
    are what smoothing does differently to the two.
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 200:
        return 0.0, 0.0, 0.0
    seen = [k for k, least in ((2, 0.015), (3, 0.15)) if np.std(m.expected[m.moving, k]) > least]
    if not seen:
        return 0.0, 0.0, 0.0
    found = None
    for furthest, least in ((LATEST, 0.5), (FURTHEST, SURE_MATCH)):
        if furthest > LATEST and (found is not None or m.time.size * STEP < 2.0 * furthest):
            break
        steps = int(furthest / STEP)
        shifts = np.arange(-steps, steps + 1)
        values = np.array([np.mean([_alike(m, c, k) for c in seen]) for k in shifts])
        k = int(np.argmax(values))
        if values[k] >= least and k not in (0, values.size - 1):
            found = k
            break
    if found is None:
        return 0.0, float(values[k]), float(values[steps])
    left, mid, right = values[k - 1 : k + 2]
    curve = left - 2 * mid + right
    peak = shifts[k] + (0.5 * (left - right) / curve if curve < 0 else 0.0)
    return float(peak * STEP), float(values[k]), float(values[steps])


def _alike(m, column, shift):
    """Correlation of what the fixes say with what was felt `shift` steps before."""
    n = m.time.size
    a = slice(max(shift, 0), n + min(shift, 0))
    b = slice(max(-shift, 0), n - max(shift, 0))
    keep = m.moving[a]
    if keep.sum() < 100:
        return 0.0
    return float(np.corrcoef(m.expected[a, column][keep], m.readings[b, column][keep])[0, 1])


def to_body(permutation):
    """Matrix from the file's axes into the body's: column i is where the file's axis i points."""
    c = np.zeros((3, 3))
    for i, entry in enumerate(permutation):
        c["xyz".index(entry[1]), i] = 1.0 if entry[0] == "+" else -1.0
    return c


def forces_reversed(drive: Drive) -> bool:
    """Whether the accelerometers, all their signs turned, fit the gyros and the fixes clearly better
    than under any order and sign of the axes.
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 50:
        return False
    turned = replace(m, readings=m.readings * np.repeat([1.0, -1.0], 3))
    rigid = (p for p in everything() if not mirrored(p))
    there = min(_costs(turned, rigid, LEANING).values())
    here = min(_costs(m, everything(), LEANING).values())
    return (here - there) / _temper(m, there) > CLEAR


def _costs(m, tried, leaning=0.0):
    """{permutation: misfit, nats as if samples were independent, at the best of a few seconds};
    leaning: m/s^2 by which a tilted case or a bias may move each force.
    """
    shifts = sorted((int(s / STEP) for s in np.arange(-6.0, 6.1, 0.4)), key=abs)
    readings = m.readings.copy()
    if (~m.moving).sum() > 50:
        readings[:, :3] -= np.median(readings[:, :3][~m.moving], axis=0)
    out = {}
    for permutation in tried:
        c = to_body(permutation)
        body = np.column_stack([readings[:, :3] @ c.T, readings[:, 3:] @ c.T])
        out[permutation] = min(_cost(m, body, k, leaning) for k in shifts)
    return out


def _temper(m, least):
    """By how much less than independent ones the samples count: smoothed readings repeat themselves
    for WIDTH seconds.
    """
    return WIDTH / STEP * 5.0 * max(1.0, least / max(m.moving.sum() * 3.0, 1.0))


def mirrored(permutation) -> bool:
    """Whether the axes are left-handed."""
    return bool(np.linalg.det(to_body(permutation)) < 0.0)


def axes(drive: Drive):
    """The order and signs of the axes: (permutation, confidence, runner-up, gain in nats,
    indistinguishable).
    """
    m = motion(drive)
    if m is None or m.moving.sum() < 50:
        return IDENTITY, 0.0, IDENTITY, 0.0, ()
    costs = _costs(m, everything())
    temper = _temper(m, min(costs.values()))
    for permutation in costs:
        if mirrored(permutation):
            costs[permutation] += MIRRORED * temper
    order = sorted(costs, key=costs.get)
    first = order[0]
    if not mirrored(first):  # no case can be turned into its mirror image: that is no rival
        order = [p for p in order if not mirrored(p)]
    second = order[1]
    here = costs[IDENTITY]
    gain = (here - costs[first]) / temper
    if first == IDENTITY or gain < CLEAR:
        return IDENTITY, 0.0, first, gain, ()
    apart = (costs[second] - costs[first]) / temper
    alike = tuple(p for p in order[1:] if (costs[p] - costs[first]) / temper < 3.0)
    return first, float(1.0 / (1.0 + np.exp(-apart))), second, float(gain), alike


def everything():
    """All 48 orders and signs of three axes."""
    for order in permutations("xyz"):
        for signs in product("+-", repeat=3):
            yield tuple(s + a for s, a in zip(signs, order))


def _cost(m, body, shift, leaning=0.0):
    n = m.time.size
    a = slice(max(shift, 0), n + min(shift, 0))
    b = slice(max(-shift, 0), n - max(shift, 0))
    keep = m.moving[a]
    apart = (m.expected[a] - body[b])[keep]
    if leaning and len(apart):
        apart[:, 3:] -= np.clip(np.median(apart[:, 3:], axis=0), -leaning, leaning)
    z = apart / np.repeat([RATE_SD, FORCE_SD], 3)
    z = np.abs(z)
    huber = np.where(z < 3.0, 0.5 * z**2, 3.0 * z - 4.5)
    return float(huber.sum() * (m.moving.sum() / max(keep.sum(), 1)))


def wild(drive: Drive):
    """(share, standard deviation m) of positions that lie far off between their neighbours; None
    where there are hardly any, or so many that they are the receiver's usual ones.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1)
    time, position = time[good], position[good]
    if time.size < 50:
        return None
    ned = earth.meters(position, position[0])
    part = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], 1e-9)
    apart = ned[1:-1] - ned[:-2] - part[:, None] * (ned[2:] - ned[:-2])
    apart = np.linalg.norm(apart[(time[2:] - time[:-2]) < 4.0 * np.median(np.diff(time))], axis=1)
    size = np.maximum(np.median(apart), 0.01)
    # a wild one moves the middle of its two neighbours by half as much
    peak = (apart > FAR_OFF * size) & (apart >= np.maximum(np.roll(apart, 1), np.roll(apart, -1)))
    share = float(peak.mean())
    if not 0.002 < share < 0.2:
        return None
    return share, float(np.sqrt(np.mean(apart[peak] ** 2) / 3.0))


def upside_down(drive: Drive) -> bool:
    """Whether the fixes' heights rise where their velocities fall."""
    if drive.gnss_velocity is None:
        return False
    time = np.asarray(drive.gnss_time)
    height, down = np.asarray(drive.gnss_position)[:, 2], np.asarray(drive.gnss_velocity)[:, 2]
    good = np.isfinite(height) & np.isfinite(down)
    time, height, down = time[good], height[good], down[good]
    if time.size < 50:
        return False
    sunk = detrend(-height)
    gone = detrend(np.append(0.0, np.cumsum(0.5 * (down[1:] + down[:-1]) * np.diff(time))))
    return np.std(gone) > ROLLING and np.corrcoef(sunk, gone)[0, 1] < OPPOSED


def velocities_swapped(drive: Drive) -> bool:
    """Whether the fixes' velocities fit their own positions as east, north and not as north, east."""
    if drive.gnss_velocity is None:
        return False
    time = np.asarray(drive.gnss_time)
    position, velocity = np.asarray(drive.gnss_position), np.asarray(drive.gnss_velocity)
    later = np.searchsorted(time, time + 2.0)
    k = np.flatnonzero(later < time.size)
    later = later[k]
    k, later = k[time[later] - time[k] < 4.0], later[time[later] - time[k] < 4.0]
    moved = earth.meters(position[later], position[k])[:, :2] / (time[later] - time[k])[:, None]
    went = 0.5 * (velocity[k] + velocity[later])[:, :2]
    fast = np.linalg.norm(went, axis=1) > 3.0
    if fast.sum() < 50:
        return False
    straight = np.median(np.linalg.norm((moved - went)[fast], axis=1))
    swapped = np.median(np.linalg.norm((moved - went[:, ::-1])[fast], axis=1))
    return bool(swapped < 0.5 * straight and straight > 2.0)
