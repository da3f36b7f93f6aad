"""Initial alignment: roll and pitch from gravity, heading from the direction of motion.

A car's heading cannot be felt by sensors of this class (Earth rate is below their bias), so it is
taken from the GNSS course once the car moves, and carried back to the start by the gyros.
"""

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError
from imu_lib.units import DEG

from . import attitude, fix_velocity
from .fix_velocity import MOVING
from .preparation import Fixes
from .stretch import Stretch

STANDING = 0.3  # m/s: below this a fix says the car stands
TURNING = 0.1  # rad/s: below this turn rate
SEVERAL = 20  # fixes in straight motion that the heading is taken from
WITHIN = 10.0  # s of motion that it is taken from where the car never stood: the gyros' bias counts
AGREE = 20.0 * DEG  # of a course with the heading of several


@dataclass(frozen=True)
class Alignment:
    """Where and how the filter starts.

    epoch : index into the stretch's `time`; position, velocity, attitude : (3,) each
    sd : (9,) position m, velocity m/s, attitude rad
    gyro_offset : (3,) rad/s, mean rate at standstill (zeros without one); standstill : s used for
    it; used : s, time of the fix whose position it took (the filter goes on with later ones)
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


def align(
    stretch: Stretch, fixes: Fixes, *, heading=None, heading_sd=10.0 * DEG, tilt_sd=1.5 * DEG
) -> Alignment:
    """Align at the start of a stretch, or as soon after it as the fixes allow.

    Standing at first: level over the standstill, heading from the first straight motion, carried
    back by the gyros. Moving from the first moment: start at the first fix in straight motion,
    level with the acceleration that the fixes show.

    heading : rad at the start, where it is known; heading_sd, tilt_sd : rad
    Raises InputError where no fix moves and no heading is given.
    """
    inside = (
        (fixes.time >= stretch.time[0]) & (fixes.time <= stretch.time[-1]) & ((fixes.use & 1) > 0)
    )
    index = np.flatnonzero(inside)
    if not index.size:
        raise InputError(
            f"no GNSS position between {stretch.time[0]:.1f} and {stretch.time[-1]:.1f} s to "
            "start the filter from"
        )
    wild = index[~fix_velocity.sound(fixes.time[index], fixes.value[index, :3])]
    kept = np.setdiff1d(np.arange(fixes.time.size), wild)
    fixes, index = fixes.take(kept), np.searchsorted(kept, np.setdiff1d(index, wild))
    seen = _seen(stretch, fixes, index)
    if heading is None and not seen.straight:
        raise InputError(
            f"the heading cannot be found: no fix between {stretch.time[0]:.1f} and "
            f"{stretch.time[-1]:.1f} s moves faster than "
            f"{MOVING:g} m/s on a straight; give the initial heading (--heading DEG)"
        )
    if seen.standstill >= 2.0:
        return _standing(stretch, fixes, seen, heading, (heading_sd, tilt_sd))
    return _moving(stretch, fixes, seen, heading, (heading_sd, tilt_sd))


@dataclass(frozen=True)
class _Seen:
    """Of the fixes `index` (k,) in a stretch: time, velocity (k, 3) and epoch; straight: those in
    quick straight motion; begin, leaves: epochs of the standstill, s long; first: fix with a
    velocity.
    """

    index: np.ndarray
    time: np.ndarray
    velocity: np.ndarray
    epochs: np.ndarray
    straight: list
    begin: int
    leaves: int
    standstill: float
    first: int


def _seen(stretch, fixes, index):
    span = fix_velocity.span_of(fixes)
    noise = 0.0 if span == fix_velocity.SHORTEST else fix_velocity.slope_sd(fixes, span)
    velocity = fix_velocity.without_spikes(fix_velocity.velocity_of(fixes)[index])
    time = fixes.time[index]
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    epochs = np.minimum(np.searchsorted(stretch.time, time), stretch.time.size - 1)
    with np.errstate(invalid="ignore"):
        first = int(np.argmax(np.isfinite(speed))) if np.isfinite(speed).any() else 0
        moved = np.flatnonzero(speed > max(STANDING, 4.0 * noise))
        quick = np.flatnonzero(speed > max(MOVING, 8.0 * noise))
    begin = 0 if time[0] - stretch.time[0] < 2.0 else int(epochs[0])
    leaves = int(epochs[max(moved[0] - 1, 0)]) if moved.size else int(epochs[-1])
    stands = leaves > begin and not (moved.size and moved[0] <= first)
    standstill = float(stretch.time[leaves] - stretch.time[begin]) if stands else 0.0
    yaw_rate = stretch.dtheta[:, 2] / stretch.dt
    around = _around(stretch)
    turned = np.concatenate([[0.0], np.cumsum(yaw_rate)])
    low = np.maximum(epochs - around, 0)
    high = np.minimum(epochs + around, len(yaw_rate))
    mean = (turned[high] - turned[low]) / np.maximum(high - low, 1)
    straight = [int(i) for i in quick if high[i] > low[i] and abs(mean[i]) < TURNING]
    return _Seen(index, time, velocity, epochs, straight, begin, leaves, standstill, first)


def _around(stretch):
    """Samples in half a second."""
    return max(int(round(0.5 / np.median(stretch.dt))), 1)


def _standing(stretch, fixes, seen, heading, sds):
    """The alignment at the begin of a standstill; sds: of heading and tilt, rad."""
    rate = stretch.dtheta / stretch.dt[:, None]
    still = slice(seen.begin, seen.leaves)
    roll, pitch = level((stretch.dvel / stretch.dt[:, None])[still].mean(axis=0))
    offset = rate[still].mean(axis=0)
    angles = np.array([roll, pitch, 0.0 if heading is None else heading])
    if heading is None:
        some = seen.straight[:SEVERAL]
        until = slice(seen.begin, seen.epochs[some[-1]] + 1)
        turned = _yaw_since(
            angles, rate[until] - offset, stretch.dt[until], seen.epochs[some] - seen.begin
        )
        angles[2] = _common(np.arctan2(seen.velocity[some, 1], seen.velocity[some, 0]) - turned)
    position_sd = np.sqrt(fixes.variance[seen.index[0], :3])
    return Alignment(
        seen.begin,
        fixes.value[seen.index[0], :3].copy(),
        np.zeros(3),
        angles,
        np.concatenate([position_sd, np.full(3, 0.1), [sds[1], sds[1], sds[0]]]),
        offset,
        seen.standstill,
        float(seen.time[0]),
    )


def _moving(stretch, fixes, seen, heading, sds):
    """The alignment at the first fix in straight motion whose course goes with that of several;
    sds: of heading and tilt, rad.
    """
    k, yaw = _course(stretch, seen) if seen.straight else (seen.first, heading)
    e = int(seen.epochs[k])
    now = seen.velocity[k] if np.isfinite(seen.velocity[k]).all() else np.zeros(3)
    yaw = yaw if heading is None else heading
    acceleration = _slope(seen.time, seen.velocity, k)
    span = _around(stretch)
    force = stretch.dvel / stretch.dt[:, None]
    around = force[max(e - span, 0) : e + span].mean(axis=0)
    ahead, aside = (
        np.cos(yaw) * acceleration[0] + np.sin(yaw) * acceleration[1],
        -np.sin(yaw) * acceleration[0] + np.cos(yaw) * acceleration[1],
    )
    roll, pitch = level(around - np.array([ahead, aside, acceleration[2]]))
    sd = np.sqrt(fixes.variance[seen.index[0]])
    tilts = [2 * sds[1], 2 * sds[1], sds[0]]
    return Alignment(
        e,
        fixes.value[seen.index[k], :3].copy(),
        now,
        np.array([roll, pitch, yaw]),
        np.concatenate([sd[:3], np.maximum(sd[3:], 0.5), tilts]),
        np.zeros(3),
        0.0,
        float(seen.time[k]),
    )


def _course(stretch, seen):
    """(k, heading): the first fix in straight motion that goes where several do, the gyros' turns
    since the first of them taken out, and the heading there by all of them.
    """
    begin = seen.straight[0]
    some = [i for i in seen.straight[:SEVERAL] if seen.time[i] - seen.time[begin] <= WITHIN]
    start = min(int(seen.epochs[begin]), len(stretch.dt) - 1)
    since = slice(start, int(seen.epochs[some[-1]]) + 1)
    tilts = level((stretch.dvel / stretch.dt[:, None])[since].mean(axis=0))
    turned = _yaw_since(
        np.array([*tilts, 0.0]),
        (stretch.dtheta / stretch.dt[:, None])[since],
        stretch.dt[since],
        seen.epochs[some] - start,
    )
    course = np.arctan2(seen.velocity[some, 1], seen.velocity[some, 0])
    first = _common(course - turned)
    near = int(np.argmax(np.abs(attitude.wrap(course - turned - first)) < AGREE))
    return some[near], float(attitude.wrap(first + turned[near]))


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
