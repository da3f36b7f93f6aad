"""The vehicle constraint, compiled: no velocity across the vehicle's forward axis.

The forward axis is that of a known mounting, or what the accepted fixes have shown in the body
frame.
"""

import numpy as np
from numba import njit

from . import attitude, covariance, measurement
from .structures import MOUNTING


@njit(cache=True)
def _speed(nav):
    return np.sqrt(nav[3] ** 2 + nav[4] ** 2 + nav[5] ** 2)


@njit(cache=True)
def learn(live, how):
    """Adds the unit velocity in the body frame to live.road (4,), after a fix."""
    nav, c, road = live.nav, live.c, live.road
    if how.constraint[0] <= 0.0 or how.known:
        return
    speed = _speed(nav)
    if speed > how.constraint[2]:
        for i in range(3):
            road[i] += (c[0, i] * nav[3] + c[1, i] * nav[4] + c[2, i] * nav[5]) / speed
        road[3] += 1.0


@njit(cache=True, inline="always")
def due(nav, how, road, epoch):
    """Whether the constraint is to be used at this epoch."""
    return (
        how.constraint[0] > 0.0
        and epoch % int(how.constraint[1]) == 0
        and (how.known or road[3] >= how.constraint[3])
        and _speed(nav) > how.constraint[2]
    )


@njit(cache=True)
def use(live, how, spin, room):
    """Two measurements of no velocity, sideways and up; the correction is made and left in
    room.dx (n,).

    spin (3,) rad/s: the standard deviation grows by the turn rate times a metre.
    """
    nav, x, c, h, dx = live.nav, live.x, live.c, room.h, room.dx
    sd = how.constraint[0] + abs(spin[2])
    at = how.at[MOUNTING]
    cv, nudged, angles = np.empty((3, 3)), np.empty((3, 3)), how.mounting.copy()
    if at >= 0:
        for i in range(3):
            angles[i] += x[at + i]
    measurement.fill_mounting(angles[0], angles[1], angles[2], cv)
    if not how.known:
        fill_learnt(live.road, cv)
    v = np.empty(3)
    for i in range(dx.size):
        dx[i] = 0.0
    for i in range(3):
        v[i] = c[0, i] * nav[3] + c[1, i] * nav[4] + c[2, i] * nav[5]
    for side in range(1, 3):
        for j in range(h.size):
            h[j] = 0.0
        w = np.empty(3)
        for i in range(3):
            w[i] = c[i, 0] * cv[side, 0] + c[i, 1] * cv[side, 1] + c[i, 2] * cv[side, 2]
            h[3 + i] = w[i]
        h[6] = -(w[1] * nav[5] - w[2] * nav[4])
        h[7] = -(w[2] * nav[3] - w[0] * nav[5])
        h[8] = -(w[0] * nav[4] - w[1] * nav[3])
        if at >= 0:
            for i in range(3):
                # states of the mounting are truth minus estimate: the slope with its sign turned
                angles[i] += 1e-6
                measurement.fill_mounting(angles[0], angles[1], angles[2], nudged)
                angles[i] -= 1e-6
                slope = 0.0
                for j in range(3):
                    slope += (nudged[side, j] - cv[side, j]) * 1e6 * v[j]
                h[9 + at + i] = -slope
        residual = w[0] * nav[3] + w[1] * nav[4] + w[2] * nav[5]
        for j in range(h.size):
            residual -= h[j] * dx[j]
        covariance.update(live.pieces, h, room.tail, sd * sd, room.gain, room.ph)
        for j in range(dx.size):
            dx[j] += room.gain[j] * residual
    measurement.apply(nav, x, dx)
    attitude.fill_matrix(nav[6:10], c)


@njit(cache=True)
def fill_learnt(road, cv):
    """Axes of the vehicle in the case's, forward as learnt and sideways level, into cv (3, 3)."""
    size = np.sqrt(road[0] ** 2 + road[1] ** 2 + road[2] ** 2)
    u0, u1, u2 = road[0] / size, road[1] / size, road[2] / size
    level = np.sqrt(u0 * u0 + u1 * u1)
    cv[0, 0], cv[0, 1], cv[0, 2] = u0, u1, u2
    cv[1, 0], cv[1, 1], cv[1, 2] = u1 / level, -u0 / level, 0.0  # u x z
    # u x (u x z)
    cv[2, 0], cv[2, 1], cv[2, 2] = u0 * u2 / level, u1 * u2 / level, -level
