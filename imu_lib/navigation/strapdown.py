"""Strapdown mechanization in north-east-down: increments of angle and velocity into position,
velocity, attitude.

One step uses the increments of the last two intervals for coning and sculling (two-sample form of
Savage 1998, as in
Groves 2013, section 5.5), Earth rate and transport rate at the middle of the interval, and normal
gravity there.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from . import attitude, earth


@dataclass(frozen=True)
class Navigation:
    """A navigation solution without uncertainties.

    time (n,) s; position (n, 3) rad, rad, m; velocity (n, 3) NED m/s; attitude (n, 3) roll, pitch,
    yaw rad.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray


@njit(cache=True)
def step(now, increments, before, dt):
    """One interval of dt s, in place on `now`: position, velocity, quaternion and its matrix.

    increments, before : of angle (rad) and velocity (m/s) in the body frame over this interval and
    the one before (zeros at the start: the correction is then of first order only)
    """
    p, v, q, c = now
    dtheta, dvel = increments
    dtheta_before, dvel_before = before
    a0, a1, a2 = dtheta[0], dtheta[1], dtheta[2]
    w0, w1, w2 = dvel[0], dvel[1], dvel[2]
    b0, b1, b2 = dtheta_before[0], dtheta_before[1], dtheta_before[2]
    u0, u1, u2 = dvel_before[0], dvel_before[1], dvel_before[2]
    # rotation to second order, x = dtheta x dvel and dtheta x x / 6; sculling, a twelfth of the
    # products with the interval before
    x0, x1, x2 = a1 * w2 - a2 * w1, a2 * w0 - a0 * w2, a0 * w1 - a1 * w0
    s0 = w0 + 0.5 * x0 + (a1 * x2 - a2 * x1) / 6.0 + (b1 * w2 - b2 * w1 + u1 * a2 - u2 * a1) / 12.0
    s1 = w1 + 0.5 * x1 + (a2 * x0 - a0 * x2) / 6.0 + (b2 * w0 - b0 * w2 + u2 * a0 - u0 * a2) / 12.0
    s2 = w2 + 0.5 * x2 + (a0 * x1 - a1 * x0) / 6.0 + (b0 * w1 - b1 * w0 + u0 * a1 - u1 * a0) / 12.0
    n0 = c[0, 0] * s0 + c[0, 1] * s1 + c[0, 2] * s2
    n1 = c[1, 0] * s0 + c[1, 1] * s1 + c[1, 2] * s2
    n2 = c[2, 0] * s0 + c[2, 1] * s1 + c[2, 2] * s2

    ie0, ie2 = earth.RATE * np.cos(p[0]), -earth.RATE * np.sin(p[0])
    meridian, transverse = earth.radii(p[0])
    height = p[2] - 0.5 * v[2] * dt
    latitude = p[0] + 0.5 * v[0] * dt / (meridian + height)
    g = earth.gravity(latitude, height)
    tan = np.tan(latitude)
    m0, m1, m2 = v[0], v[1], v[2]
    new0, new1, new2 = v[0], v[1], v[2]
    z0, z1, z2 = 0.0, 0.0, 0.0
    for _ in range(2):  # first with the velocity at the start, then with the one half way
        en0, en1, en2 = (
            m1 / (transverse + height),
            -m0 / (meridian + height),
            -m1 * tan / (transverse + height),
        )
        r0, r1, r2 = 2.0 * ie0 + en0, en1, 2.0 * ie2 + en2  # Coriolis and transport
        z0, z1, z2 = (ie0 + en0) * dt, en1 * dt, (ie2 + en2) * dt  # turn of the navigation frame
        new0 = v[0] + n0 - 0.5 * (z1 * n2 - z2 * n1) - (r1 * m2 - r2 * m1) * dt
        new1 = v[1] + n1 - 0.5 * (z2 * n0 - z0 * n2) - (r2 * m0 - r0 * m2) * dt
        new2 = v[2] + n2 - 0.5 * (z0 * n1 - z1 * n0) - (r0 * m1 - r1 * m0) * dt + g * dt
        m0, m1, m2 = 0.5 * (v[0] + new0), 0.5 * (v[1] + new1), 0.5 * (v[2] + new2)

    height = p[2] - 0.25 * (v[2] + new2) * dt
    p[2] -= 0.5 * (v[2] + new2) * dt
    meridian, transverse = earth.radii(latitude)
    p[0] += 0.5 * (v[0] + new0) * dt / (meridian + height)
    p[1] += 0.5 * (v[1] + new1) * dt / ((transverse + height) * np.cos(latitude))
    v[0], v[1], v[2] = new0, new1, new2

    # attitude: coning-corrected body turn, then the turn of the navigation frame
    turn = np.empty(3)
    turn[0] = a0 + (b1 * a2 - b2 * a1) / 12.0
    turn[1] = a1 + (b2 * a0 - b0 * a2) / 12.0
    turn[2] = a2 + (b0 * a1 - b1 * a0) / 12.0
    attitude.rotate_body(q, turn)
    attitude.rotate_frame(q, -z0, -z1, -z2)
    attitude.fill_matrix(q, c)


@njit(cache=True)
def _integrate(dt, dtheta, dvel, start, hold_height, out):
    """Into out, (n + 1, 3 and 4) of position, velocity and quaternion, from those at the start."""
    p, v, q = start
    position, velocity, quaternion = out
    c = np.empty((3, 3))
    attitude.fill_matrix(q, c)
    before_theta, before_vel = np.zeros(3), np.zeros(3)
    height = p[2]
    for k in range(dt.size):
        step((p, v, q, c), (dtheta[k], dvel[k]), (before_theta, before_vel), dt[k])
        if hold_height:
            p[2], v[2] = height, 0.0
        before_theta, before_vel = dtheta[k], dvel[k]
        position[k + 1] = p
        velocity[k + 1] = v
        quaternion[k + 1] = q


def integrate(time, dtheta, dvel, *, position, velocity, attitude_, hold_height=False):
    """Free inertial navigation from given initial values.

    Parameters
    ----------
    time : ndarray, shape (n+1,)
        Ends of the intervals, s, the first being the start.
    dtheta, dvel : ndarray, shape (n, 3)
        Increments over each interval, rad and m/s, body frame.
    position, velocity, attitude_ : ndarray, shape (3,)
        Initial latitude-longitude-height, velocity north-east-down, roll-pitch-yaw.
    hold_height : bool
        Keep height and vertical velocity at their start: the inertial height channel is unstable,
        an error grows by e in sqrt(R / 2g) = 570 s and hides everything else within hours.

    Returns
    -------
    Navigation
        With n+1 epochs.
    """
    time, dtheta, dvel = (np.ascontiguousarray(a, float) for a in (time, dtheta, dvel))
    if dtheta.shape != dvel.shape or dtheta.shape != (time.size - 1, 3):
        raise ValueError(
            f"`dtheta` and `dvel` must have shape ({time.size - 1}, 3), one row per interval of "
            f"`time`; got {dtheta.shape} and {dvel.shape}"
        )
    p, v = np.array(position, float), np.array(velocity, float)
    q = attitude.quaternion(attitude_)
    out = np.empty((time.size, 3)), np.empty((time.size, 3)), np.empty((time.size, 4))
    for array, first in zip(out, (p, v, q)):
        array[0] = first
    _integrate(np.diff(time), dtheta, dvel, (p, v, q), hold_height, out)
    return Navigation(time, out[0], out[1], attitude.euler(out[2]))
