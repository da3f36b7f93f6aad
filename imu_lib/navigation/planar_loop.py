"""The planar filter's loop over the epochs, compiled: see `planar`."""

from typing import NamedTuple

import numpy as np
from numba import njit


class Setup(NamedTuple):
    """What runs share: p0 (n, n) covariance at the start, gnss (2,) variances of a fix every
    `every` steps, dt s, half: dt^2 / 2, or 0 at first order; output and block: sensor states to
    errors and over a step, as (rows, columns, values) of what is not zero; noise (k, k), direct
    (3,) of the sensors.
    """

    p0: np.ndarray
    gnss: np.ndarray
    every: int
    dt: float
    half: float
    output: tuple
    block: tuple
    noise: np.ndarray
    direct: np.ndarray


class Out(NamedTuple):
    """Written after each step: position, sd (n, 2) and nees (n,)."""

    position: np.ndarray
    sd: np.ndarray
    nees: np.ndarray


@njit(cache=True)
def mechanize(state, forward, right, rate, dt):
    """One step of Eq. (1), in place: `state` (n, e, vn, ve, heading); heading at the middle of the
    step.

    Returns the north and east specific force.
    """
    middle = state[4] + 0.5 * rate * dt
    c, s = np.cos(middle), np.sin(middle)
    an, ae = c * forward - s * right, s * forward + c * right
    state[0] += dt * (state[2] + 0.5 * dt * an)
    state[1] += dt * (state[3] + 0.5 * dt * ae)
    state[2] += dt * an
    state[3] += dt * ae
    state[4] += rate * dt
    return an, ae


@njit(cache=True, fastmath=True)
def _apply(p, way, how, sensor, work):
    """work = Phi p with what is zero in Phi left out; way: cosine and sine of the heading and
    specific force north and east; `sensor` (3, n) scratch.
    """
    n = p.shape[0]
    c, s, an, ae = way
    output, block, dt, half = how.output, how.block, how.dt, how.half
    sensor[:] = 0.0
    for m in range(len(output[0])):
        for j in range(n):
            sensor[output[0][m], j] += output[2][m] * p[5 + output[1][m], j]
    for j in range(n):
        north = -ae * p[4, j] + c * sensor[0, j] - s * sensor[1, j]
        east = an * p[4, j] + s * sensor[0, j] + c * sensor[1, j]
        work[0, j] = p[0, j] + dt * p[2, j] + half * north
        work[1, j] = p[1, j] + dt * p[3, j] + half * east
        work[2, j] = p[2, j] + dt * north
        work[3, j] = p[3, j] + dt * east
        work[4, j] = p[4, j] + dt * sensor[2, j]
    work[5:] = 0.0
    for m in range(len(block[0])):
        for j in range(n):
            work[5 + block[0][m], j] += block[2][m] * p[5 + block[1][m], j]


@njit(cache=True)
def _spread(p, way, how, sensor, work, turned):
    """The covariance over one step, in place."""
    n = p.shape[0]
    c, s, _, _ = way
    _apply(p, way, how, sensor, work)
    for i in range(n):
        for j in range(n):
            turned[i, j] = work[j, i]
    _apply(turned, way, how, sensor, p)
    dt, direct = how.dt, how.direct
    p[2, 2] += dt * (c * c * direct[0] + s * s * direct[1])
    p[3, 3] += dt * (s * s * direct[0] + c * c * direct[1])
    p[2, 3] += dt * c * s * (direct[0] - direct[1])
    p[3, 2] = p[2, 3]
    p[4, 4] += dt * direct[2]
    for i in range(n - 5):
        for j in range(n - 5):
            p[5 + i, 5 + j] += how.noise[i, j]


@njit(cache=True)
def _take(x, b, p, fix, gnss):
    """The two numbers of a fix, one after the other, into navigation x, sensor states b and p."""
    n = p.shape[0]
    for axis in range(2):
        gain = p[:, axis] / (p[axis, axis] + gnss[axis])
        miss = x[axis] - fix[axis]
        row = p[axis].copy()
        for i in range(n):
            for j in range(n):
                p[i, j] -= gain[i] * row[j]
        for i in range(5):
            x[i] -= gain[i] * miss
        for i in range(5, n):
            b[i - 5] += gain[i] * miss  # the state is truth minus estimate here
    for i in range(n):
        for j in range(i):
            p[i, j] = p[j, i] = 0.5 * (p[i, j] + p[j, i])


@njit(cache=True)
def run(readings, fixes, start, how, out, truth):
    """One run of the filter from the navigation state `start`, into out; see `planar.run`."""
    n = how.p0.shape[0]
    x, b, p = start.copy(), np.zeros(n - 5), how.p0.copy()
    work, turned, sensor = np.empty((n, n)), np.empty((n, n)), np.empty((3, n))
    error = np.zeros(3)
    next_fix = 0
    for k in range(len(readings)):
        error[:] = 0.0
        for m in range(len(how.output[0])):
            error[how.output[0][m]] += how.output[2][m] * b[how.output[1][m]]
        rate = readings[k, 2] - error[2]
        middle = x[4] + 0.5 * rate * how.dt
        an, ae = mechanize(x, readings[k, 0] - error[0], readings[k, 1] - error[1], rate, how.dt)
        _spread(p, (np.cos(middle), np.sin(middle), an, ae), how, sensor, work, turned)
        old = b.copy()
        b[:] = 0.0
        for m in range(len(how.block[0])):
            b[how.block[0][m]] += how.block[2][m] * old[how.block[1][m]]
        if (k + 1) % how.every == 0 and next_fix < len(fixes):
            _take(x, b, p, fixes[next_fix], how.gnss)
            next_fix += 1
        out.position[k, 0], out.position[k, 1] = x[0], x[1]
        out.sd[k, 0], out.sd[k, 1] = np.sqrt(p[0, 0]), np.sqrt(p[1, 1])
        if truth.shape[0]:
            d0, d1 = x[0] - truth[k, 0], x[1] - truth[k, 1]
            det = p[0, 0] * p[1, 1] - p[0, 1] * p[0, 1]
            out.nees[k] = (d0 * d0 * p[1, 1] - 2 * d0 * d1 * p[0, 1] + d1 * d1 * p[0, 0]) / det
