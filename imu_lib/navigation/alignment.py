"""Initial alignment: roll and pitch from gravity, heading from the direction of motion.

A car's heading cannot be felt by sensors of this class (Earth rate is below their bias), so it is
taken from the GNSS
course once the car moves, and carried back to the start by the gyros.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
from imu_lib.units import DEG

from . import attitude, earth
from .preparation import Fixes, Stretch

STANDING = 0.3  # m/s: below this a fix says the car stands
MOVING = 3.0  # m/s: above this the course is a heading
TURNING = 0.1  # rad/s: below this turn rate
SHORTEST = 1.0  # s before and after a fix over which its speed is taken where it has none
SEVERAL = 20  # fixes in straight motion that the heading is taken from


@dataclass(frozen=True)
class Alignment:
    """Where and how the filter starts.

    epoch : index into the stretch's `time`; position, velocity, attitude : (3,) each
    sd : (9,) position m, velocity m/s, attitude rad
    gyro_offset : (3,) rad/s, mean rate at standstill (zeros without one); standstill : s used for
    it; used : s, time of the fix whose
    position it took (the filter goes on with later ones)
    """

    epoch: int
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    sd: np.ndarray
    gyro_offset: np.ndarray
    standstill: float = 0.0
    used: float = -np.inf


def level(force):
    """Roll and pitch (rad) of a body at rest that feels `force` (3,), m/s^2 (Groves 2013, Eq.
    5.101).
    """
    return np.arctan2(-force[1], -force[2]), np.arctan2(force[0], np.hypot(force[1], force[2]))


def velocity_of(fixes: Fixes, *, span=None):
    """NED velocity at each fix, (m, 3): as received, or the slope of the positions over `span` s
    where there is none (NaN at the ends; None: as long as their scatter asks for).
    """
    has = (fixes.use & 2) > 0
    if has.any():
        of = np.full((int(fixes.index.max()) + 1, 3), np.nan)
        of[fixes.index[has]] = fixes.value[has, 3:]
        return of[fixes.index]
    span = _span(fixes) if span is None else span
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


def _slope_sd(fixes: Fixes, span):
    """Standard deviation of a velocity that `velocity_of` takes from positions, m/s."""
    if ((fixes.use & 2) > 0).any():
        return 0.0
    interval = max(float(np.median(np.diff(np.unique(fixes.time)))), 1e-3)
    count = 2.0 * span / interval + 1.0
    return _scatter(fixes) / (span * np.sqrt(max(count, 2.0) / 3.0))


def _span(fixes: Fixes):
    """Half of the time over which positions are made a velocity, s: the shortest that does not make
    a standing car move.
    """
    return next((s for s in (SHORTEST, 1.5, 2.0) if 8.0 * _slope_sd(fixes, s) < MOVING), 3.0)


def align(
    stretch: Stretch, fixes: Fixes, *, heading=None, heading_sd=10.0 * DEG, tilt_sd=1.5 * DEG
) -> Alignment:
    """Align at the start of a stretch, or as soon after it as the fixes allow.

    Standing at first: level over the standstill, heading from the first straight motion, carried
    back by the gyros. Moving from
    the first moment: start at the first fix in straight motion, level with the acceleration that
    the fixes show.

    heading : rad at the start, where it is known; heading_sd, tilt_sd : rad
    Raises InputError where no fix moves and no heading is given.
    """
    inside = (
        (fixes.time >= stretch.time[0]) & (fixes.time <= stretch.time[-1]) & ((fixes.use & 1) > 0)
    )
    index = np.flatnonzero(inside)
    if not index.size:
        raise InputError(
            f"no GNSS position between {stretch.time[0]:.1f} and {stretch.time[-1]:.1f} s to start the filter from"
        )
    span = _span(fixes)
    noise = 0.0 if span == SHORTEST else _slope_sd(fixes, span)
    velocity = velocity_of(fixes)[index]
    time = fixes.time[index]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    epochs = np.minimum(np.searchsorted(stretch.time, time), stretch.time.size - 1)
    rate = stretch.dtheta / stretch.dt[:, None]
    force = stretch.dvel / stretch.dt[:, None]
    span = max(int(round(0.5 / np.median(stretch.dt))), 1)
    with np.errstate(invalid="ignore"):
        first_known = int(np.argmax(np.isfinite(speed))) if np.isfinite(speed).any() else 0
        moved = np.flatnonzero(speed > max(STANDING, 4.0 * noise))
        quick = np.flatnonzero(speed > max(MOVING, 8.0 * noise))
    begin = 0 if time[0] - stretch.time[0] < 2.0 else int(epochs[0])
    leaves = int(epochs[max(moved[0] - 1, 0)]) if moved.size else int(epochs[-1])
    standstill = (
        float(stretch.time[leaves] - stretch.time[begin])
        if leaves > begin and not (moved.size and moved[0] <= first_known)
        else 0.0
    )
    turned = np.concatenate([[0.0], np.cumsum(rate[:, 2])])
    low, high = np.maximum(epochs - span, 0), np.minimum(epochs + span, len(rate))
    mean = (turned[high] - turned[low]) / np.maximum(high - low, 1)
    straight = [int(i) for i in quick if high[i] > low[i] and abs(mean[i]) < TURNING]
    if heading is None and not straight:
        raise InputError(
            f"the heading cannot be found: no fix between {stretch.time[0]:.1f} and {stretch.time[-1]:.1f} s moves faster than "
            f"{MOVING:g} m/s on a straight; give the initial heading (--heading DEG)"
        )
    position_sd, velocity_sd = (
        np.sqrt(fixes.variance[index[0], :3]),
        np.sqrt(fixes.variance[index[0], 3:]),
    )
    if standstill >= 2.0:
        still = slice(begin, leaves)
        mean = force[still].mean(axis=0)
        roll, pitch = level(mean)
        offset = rate[still].mean(axis=0)
        angles = np.array([roll, pitch, 0.0 if heading is None else heading])
        if heading is None:
            some = straight[:SEVERAL]
            turned = _yaw_since(
                angles,
                rate[begin : epochs[some[-1]] + 1] - offset,
                stretch.dt[begin : epochs[some[-1]] + 1],
                epochs[some] - begin,
            )
            angles[2] = _common(np.arctan2(velocity[some, 1], velocity[some, 0]) - turned)
        return Alignment(
            begin,
            fixes.value[index[0], :3].copy(),
            np.zeros(3),
            angles,
            np.concatenate([position_sd, np.full(3, 0.1), [tilt_sd, tilt_sd, heading_sd]]),
            offset,
            standstill,
            float(time[0]),
        )
    k = straight[0] if straight else first_known
    e = int(epochs[k])
    now = velocity[k] if np.isfinite(velocity[k]).all() else np.zeros(3)
    yaw = np.arctan2(now[1], now[0]) if heading is None else heading
    acceleration = _slope(time, velocity, k)
    around = force[max(e - span, 0) : e + span].mean(axis=0)
    ahead, aside = (
        np.cos(yaw) * acceleration[0] + np.sin(yaw) * acceleration[1],
        -np.sin(yaw) * acceleration[0] + np.cos(yaw) * acceleration[1],
    )
    roll, pitch = level(around - np.array([ahead, aside, acceleration[2]]))
    return Alignment(
        e,
        fixes.value[index[k], :3].copy(),
        now,
        np.array([roll, pitch, yaw]),
        np.concatenate(
            [position_sd, np.maximum(velocity_sd, 0.5), [2 * tilt_sd, 2 * tilt_sd, heading_sd]]
        ),
        np.zeros(3),
        0.0,
        float(time[k]),
    )


def _slope(time, velocity, k, width=1.0):
    """Acceleration at fix k, (3,): of the velocities within `width` s, or of its neighbours."""
    near = np.flatnonzero(np.abs(time - time[k]) <= width)
    if near.size < 3:
        near = np.arange(max(k - 1, 0), min(k + 2, time.size))
    near = near[np.isfinite(velocity[near]).all(axis=1)]
    if near.size < 2:
        return np.zeros(3)
    t = time[near] - time[near].mean()
    return t @ velocity[near] / (t @ t)


def _yaw_since(angles, rate, dt, marks):
    """Yaw that the gyros add between the start and each mark (indices), rad, from a start of yaw
    zero.
    """
    q, out = attitude.quaternion(angles), []
    for k, turn in enumerate(rate * dt[:, None]):
        while len(out) < len(marks) and marks[len(out)] <= k:
            out.append(attitude.euler(q)[2])
        attitude.rotate_body(q, turn)
    return np.array(out + [attitude.euler(q)[2]] * (len(marks) - len(out)))


def _common(headings):
    """The heading that most of several agree on: a wild course, or one driven backwards, does not
    move it.
    """
    apart = np.abs(attitude.wrap(headings[:, None] - headings[None, :]))
    return float(attitude.wrap(headings[np.argmin(np.median(apart, axis=1))]))
