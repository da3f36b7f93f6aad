"""What a fix says to the filter, compiled: the antenna predicted at the time of the fix, its
innovation, the covariance of it, and the correction.

A fix is taken `delay` s before the epoch at which it is used, more by what the states of time
offset and clock say. Position and velocity of an epoch are carried back by velocity and
acceleration. An error of navigation is estimate minus truth, one of the other states truth minus
estimate.
"""

import numpy as np
from numba import njit

from . import attitude, covariance, earth
from .structures import CLOCK, CORRELATED, LEVER, MOUNTING, OFFSET, SPEED, VELOCITY_OFFSET

POSITION, VELOCITY = 1, 2  # bits of a fix's accepted parts
REJECTED_POSITION, REJECTED_VELOCITY, RECOVERED = 4, 8, 16
WILD = 32  # a position taken as wild by the model of outliers
LOG_2_PI = np.log(2.0 * np.pi)


@njit(cache=True)
def fill_mounting(roll, pitch, yaw, c):
    """Rz(yaw) Ry(pitch) Rx(roll) into c (3, 3): turns the case's axes into the vehicle's."""
    cr, sr = np.cos(roll), np.sin(roll)
    cp, sp = np.cos(pitch), np.sin(pitch)
    cy, sy = np.cos(yaw), np.sin(yaw)
    c[0, 0], c[0, 1], c[0, 2] = cp * cy, -cr * sy + sr * sp * cy, sr * sy + cr * sp * cy
    c[1, 0], c[1, 1], c[1, 2] = cp * sy, cr * cy + sr * sp * sy, -sr * cy + cr * sp * sy
    c[2, 0], c[2, 1], c[2, 2] = -sp, sr * cp, cr * cp


@njit(cache=True)
def fill_mounting_now(how, x, c):
    """The mounting as held and as its states say, into c."""
    at = how.at[MOUNTING]
    r, p, y = how.mounting[0], how.mounting[1], how.mounting[2]
    if at >= 0:
        r, p, y = r + x[at], p + x[at + 1], y + x[at + 2]
    fill_mounting(r, p, y, c)


@njit(cache=True)
def delays(how, x, delay, time):
    """(position s, velocity s) from the taking of a fix to its epoch."""
    at = how.at
    extra = x[at[OFFSET]] if at[OFFSET] >= 0 else 0.0
    clock = x[at[CLOCK]] * time if at[CLOCK] >= 0 else 0.0
    extra_v = x[at[VELOCITY_OFFSET]] if at[VELOCITY_OFFSET] >= 0 else extra
    return extra - clock, extra_v - clock


@njit(cache=True)
def innovation(live, how, body, fixes, f, y, arm):
    """Predicted minus measured antenna position (m) and velocity (m/s) at the fix's own time into
    y (6,); the lever arm in the case's axes into arm (3,). body : `structures.Body`
    """
    nav, x, c, cv = live.nav, live.x, live.c, live.cv
    spin, motion = body.spin, body.motion
    late, late_v = delays(how, x, fixes.delay[f], fixes.time[f])
    delay = fixes.delay[f] + late
    at = how.at[LEVER]
    l0, l1, l2 = how.lever[0], how.lever[1], how.lever[2]
    if at >= 0:
        l0, l1, l2 = l0 + x[at], l1 + x[at + 1], l2 + x[at + 2]
    for i in range(3):
        arm[i] = cv[0, i] * l0 + cv[1, i] * l1 + cv[2, i] * l2
    meridian, transverse = earth.radii(nav[0])
    fix = fixes.value[f]
    y[0] = (nav[0] - fix[0]) * (meridian + nav[2])
    y[1] = (nav[1] - fix[1]) * (transverse + nav[2]) * np.cos(nav[0])
    y[2] = fix[2] - nav[2]
    # velocity of the antenna about the sensor: omega x arm, turned
    t0 = spin[1] * arm[2] - spin[2] * arm[1]
    t1 = spin[2] * arm[0] - spin[0] * arm[2]
    t2 = spin[0] * arm[1] - spin[1] * arm[0]
    half, own = 0.5 * delay * delay, fixes.delay[f]
    for i in range(3):
        mean = motion[0, i] if late == 0.0 else motion[1, i]
        y[i] += c[i, 0] * arm[0] + c[i, 1] * arm[1] + c[i, 2] * arm[2]
        y[i] += -nav[3 + i] * delay + mean * half
        y[3 + i] = (
            nav[3 + i]
            + c[i, 0] * t0
            + c[i, 1] * t1
            + c[i, 2] * t2
            - fix[3 + i]
            - motion[0, i] * own
            - motion[1, i] * late_v
        )
    at = how.at[CORRELATED]
    if at >= 0:
        for i in range(3):
            y[i] += x[at + i]


@njit(cache=True)
def fill_rows(h, live, how, motion, arm, delay, time):
    """The six rows (6, n) of the measurement matrix: position with [arm x] on the attitude error
    and the delay on the velocity error, and the states of the measurements.
    """
    nav, x, c, cv = live.nav, live.x, live.c, live.cv
    late, _ = delays(how, x, delay, time)
    delay = delay + late
    for i in range(6):
        for j in range(h.shape[1]):
            h[i, j] = 0.0
    for i in range(3):
        h[i, i] = 1.0
        h[i, 3 + i] = -delay
        h[3 + i, 3 + i] = 1.0
    a0 = c[0, 0] * arm[0] + c[0, 1] * arm[1] + c[0, 2] * arm[2]
    a1 = c[1, 0] * arm[0] + c[1, 1] * arm[1] + c[1, 2] * arm[2]
    a2 = c[2, 0] * arm[0] + c[2, 1] * arm[1] + c[2, 2] * arm[2]
    h[0, 7], h[0, 8] = -a2, a1
    h[1, 6], h[1, 8] = a2, -a0
    h[2, 6], h[2, 7] = -a1, a0
    at = how.at
    separate = at[VELOCITY_OFFSET] >= 0
    for i in range(3):
        back = nav[3 + i] - motion[1, i] * delay
        if at[OFFSET] >= 0:
            h[i, 9 + at[OFFSET]] = back
            if not separate:
                h[3 + i, 9 + at[OFFSET]] = motion[1, i]
        if separate:
            h[3 + i, 9 + at[VELOCITY_OFFSET]] = motion[1, i]
        if at[CLOCK] >= 0:
            h[i, 9 + at[CLOCK]] = -back * time
            h[3 + i, 9 + at[CLOCK]] = -motion[1, i] * time
        if at[CORRELATED] >= 0:
            h[i, 9 + at[CORRELATED] + i] = -1.0
        if at[LEVER] >= 0:
            # C_nb and C_nb [omega x], each times the turn from the vehicle's axes to the case's; a
            # turn rate whose noise is in the innovation too would pull the arm towards nothing
            w0, w1, w2 = motion[2, 0], motion[2, 1], motion[2, 2]
            u0 = c[i, 1] * w2 - c[i, 2] * w1
            u1 = c[i, 2] * w0 - c[i, 0] * w2
            u2 = c[i, 0] * w1 - c[i, 1] * w0
            for j in range(3):
                h[i, 9 + at[LEVER] + j] = -(
                    c[i, 0] * cv[j, 0] + c[i, 1] * cv[j, 1] + c[i, 2] * cv[j, 2]
                )
                h[3 + i, 9 + at[LEVER] + j] = -(u0 * cv[j, 0] + u1 * cv[j, 1] + u2 * cv[j, 2])


@njit(cache=True)
def fill_variance(given, c, arm, white, step, variance):
    """Variances of a fix, and what the gyros' white noise of one interval, N^2 / dt, adds to the
    antenna's velocity about the sensor.
    """
    for i in range(3):
        m0 = c[i, 2] * arm[1] - c[i, 1] * arm[2]  # row of C [arm x]
        m1 = c[i, 0] * arm[2] - c[i, 2] * arm[0]
        m2 = c[i, 1] * arm[0] - c[i, 0] * arm[1]
        variance[i] = given[i]
        variance[3 + i] = (
            given[3 + i] + (m0 * m0 * white[0] + m1 * m1 * white[1] + m2 * m2 * white[2]) / step
        )


@njit(cache=True)
def fill_covariance(pieces, h, tail, variance, ph, s):
    """Covariance (6, 6) of the innovation into s."""
    n = h.shape[1]
    for i in range(6):
        covariance.project(pieces, h[i], tail, ph)
        for j in range(i + 1):
            total = 0.0
            for k in range(9):
                total += h[j, k] * ph[k]
            for k in range(9 + tail, n):
                total += h[j, k] * ph[k]
            s[i, j] = total
            s[j, i] = total
        s[i, i] += variance[i]


@njit(cache=True)
def distance(s, y, start, extra):
    """(squared Mahalanobis distance, logarithm of the determinant) of three innovations that begin
    at `start`, `extra` added to their variances.
    """
    a, b, c = s[start, start] + extra, s[start + 1, start + 1] + extra, 0.0
    c = s[start + 2, start + 2] + extra
    d, e, f = s[start, start + 1], s[start, start + 2], s[start + 1, start + 2]
    det = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    x, z, w = y[start], y[start + 1], y[start + 2]
    square = (
        x * x * (b * c - f * f)
        + z * z * (a * c - e * e)
        + w * w * (a * b - d * d)
        + 2.0 * (x * z * (e * f - d * c) + x * w * (d * f - b * e) + z * w * (d * e - a * f))
    ) / det
    return square, np.log(det)


@njit(cache=True)
def wild_probability(s, y, outliers):
    """(probability that the position is wild, log density of the mixture)."""
    near, log_near = distance(s, y, 0, 0.0)
    far, log_far = distance(s, y, 0, outliers[1] * outliers[1])
    inlier = np.log(1.0 - outliers[0]) - 0.5 * (near + log_near + 3.0 * LOG_2_PI)
    outlier = np.log(outliers[0]) - 0.5 * (far + log_far + 3.0 * LOG_2_PI)
    top = max(inlier, outlier)
    total = top + np.log(np.exp(inlier - top) + np.exp(outlier - top))
    return np.exp(outlier - total), total


@njit(cache=True)
def apply(nav, x, dx):
    """Closed loop: takes the estimated errors out of the navigation solution and puts the sensor
    states right.
    """
    meridian, transverse = earth.radii(nav[0])
    nav[0] -= dx[0] / (meridian + nav[2])
    nav[1] -= dx[1] / ((transverse + nav[2]) * np.cos(nav[0]))
    nav[2] += dx[2]
    for i in range(3, 6):
        nav[i] -= dx[i]
    attitude.rotate_frame(nav[6:10], dx[6], dx[7], dx[8])
    for j in range(x.size):
        x[j] += dx[9 + j]


@njit(cache=True)
def take_speed(live, how, speeds, f, room):
    """Speed over ground of the wheels: (1 + scale) |v|, at an epoch; room.dx (n,) receives the
    correction, which is made.
    """
    nav, x, h, dx = live.nav, live.x, room.h, room.dx
    v = np.sqrt(nav[3] ** 2 + nav[4] ** 2 + nav[5] ** 2)
    if v < 1.0:
        return
    at = how.at[SPEED]
    scale = 1.0 + (x[at] if at >= 0 else 0.0)
    for j in range(h.size):
        h[j] = 0.0
        dx[j] = 0.0
    for i in range(3):
        h[3 + i] = scale * nav[3 + i] / v
    if at >= 0:
        h[9 + at] = -v
    covariance.update(live.pieces, h, room.tail, speeds.variance[f], room.gain, room.ph)
    residual = scale * v - speeds.value[f]
    for j in range(dx.size):
        dx[j] = room.gain[j] * residual
    apply(nav, x, dx)
