"""The loosely coupled filter's loop over the epochs, compiled.

One call runs from one epoch to another, so that a stored moment can be run on alone: an outage is
that moment run on without fixes. All the filter knows at a moment is in `structures.State`, changed
in place.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from . import attitude, constraint, covariance, measurement, strapdown
from .measurement import POSITION, RECOVERED, REJECTED_POSITION, REJECTED_VELOCITY, VELOCITY, WILD
from .pieces import accumulate, add, copy, pack, unpack, zero
from .structures import MOUNTING, Pieces, Room

__all__ = ["POSITION", "RECOVERED", "REJECTED_POSITION", "REJECTED_VELOCITY", "VELOCITY", "WILD"]
AVERAGE = 0.2  # s over which motion is averaged for the rows of the measurements' states


class Body(NamedTuple):
    """Motion over an interval: before (3,) velocity at its begin, middle (3, 3) mean attitude,
    force (3,) specific force NED, spin (3,) turn rate, motion (3, 3) acceleration of the interval,
    its average and the turn rate's over the last tenths of a second.
    """

    before: np.ndarray
    middle: np.ndarray
    force: np.ndarray
    spin: np.ndarray
    motion: np.ndarray


class Work(NamedTuple):
    """Of an interval: f, a, f2 (9, 9), d (9, 6) of `covariance.fill_transition`, weight (m,) of
    the sensor states, white (6,) densities, x_new (m,); room to propagate in.
    """

    f: np.ndarray
    a: np.ndarray
    d: np.ndarray
    f2: np.ndarray
    weight: np.ndarray
    white: np.ndarray
    x_new: np.ndarray
    room: Room


@njit(cache=True, nogil=True)
def run(begin, end, state, imu, sensors, fixes, speeds, how, logs, nodes, smooth):
    """Epochs begin+1 .. end (epoch k ends interval k-1 of `imu`); epoch `begin` is the state given.

    The arguments are those of `structures`, fixes and speeds sorted by epoch; logs and nodes are
    written. nodes' prior, phi and dx are for the smoother.
    """
    nav, x, p, road = state
    m, n = x.size, 9 + x.size
    c, cv, turn, push = np.empty((3, 3)), np.empty((3, 3)), np.empty(3), np.empty(3)
    body, work = _body(), _work(m, sensors)
    pieces = Pieces(np.empty((9, 9)), np.empty((9, m)), np.empty((m, m)))
    unpack(p, pieces)
    h, h6 = np.empty(n), np.empty((6, n))
    gain, ph, dx, total, phi = np.empty(n), np.empty(n), np.empty(n), np.zeros(n), np.eye(n)
    rejected, tail = np.zeros(2, np.int64), sensors.first[6]
    driven, moving = (sensors.driver >= 0).any(), (sensors.white_speed > 0.0).any()
    fix = np.searchsorted(fixes.epoch, begin, side="right")
    speed_fix = np.searchsorted(speeds.epoch, begin, side="right")
    node = np.searchsorted(nodes.epoch, begin, side="right")
    attitude.fill_matrix(nav[6:10], c)
    measurement.fill_mounting_now(how, x, cv)
    for k in range(begin, end):
        step, epoch = imu.dt[k], k + 1
        correct(imu.dtheta[k], imu.dvel[k], step, x, sensors, driven, work.weight, turn, push)
        _move(nav, c, turn, push, step, body)
        _spread(nav, x, pieces, body, (step, imu.extra_noise[k], moving), sensors, work)
        at_node = node < nodes.epoch.size and nodes.epoch[node] == epoch
        if smooth:
            accumulate(phi, work.a, work.d, work.weight, sensors)
            zero(total)
            if at_node:
                pack(pieces, nodes.prior[node])
        while fix < fixes.epoch.size and fixes.epoch[fix] <= epoch:
            moment = (c, cv, body.spin, body.motion, work.white, step)
            if take_fix(
                nav, x, pieces, how, tail, fixes, fix, moment, rejected, h6, gain, ph, dx, logs
            ):
                measurement.apply(nav, x, dx)
                attitude.fill_matrix(nav[6:10], c)
                if how.at[MOUNTING] >= 0:
                    measurement.fill_mounting_now(how, x, cv)
                add(total, dx)
                constraint.learn(nav, c, how, road)
            fix += 1
        while speed_fix < speeds.epoch.size and speeds.epoch[speed_fix] <= epoch:
            measurement.take_speed(nav, x, pieces, how, tail, speeds, speed_fix, h, gain, ph, dx)
            attitude.fill_matrix(nav[6:10], c)
            add(total, dx)
            speed_fix += 1
        if constraint.due(nav, how, road, epoch):
            constraint.use(nav, x, c, pieces, how, tail, road, body.spin, h, gain, ph, dx)
            add(total, dx)
        _log(nav, pieces.nn, logs, k - begin)
        if at_node:
            _keep(x, road, pieces, total, phi, nodes, node, smooth)
            node += 1
    pack(pieces, p)


@njit(cache=True)
def _body():
    return Body(np.empty(3), np.empty((3, 3)), np.empty(3), np.zeros(3), np.zeros((3, 3)))


@njit(cache=True)
def _work(m, sensors):
    room = Room(
        np.empty((9, 9)), np.empty((9, m)), np.empty((6, m)), np.empty((9, 6)), np.empty((m, m))
    )
    return Work(
        np.empty((9, 9)), np.empty((9, 9)), np.empty((9, 6)), np.empty((9, 9)),
        sensors.output.copy(), sensors.white.copy(), np.empty(m), room,
    )  # fmt: skip


@njit(cache=True)
def _move(nav, c, turn, push, step, body):
    """The strapdown over one interval, and what the measurements take of the motion."""
    middle, spin, motion = body.middle, body.spin, body.motion
    for i in range(3):
        body.before[i] = nav[3 + i]
        for j in range(3):
            middle[i, j] = c[i, j]
    strapdown.step(nav[0:3], nav[3:6], nav[6:10], c, turn, push, nav[10:13], nav[13:16], step)
    share = min(step / AVERAGE, 1.0)
    for i in range(3):
        nav[10 + i], nav[13 + i] = turn[i], push[i]
        motion[0, i] = (nav[3 + i] - body.before[i]) / step
        motion[1, i] += share * (motion[0, i] - motion[1, i])
        motion[2, i] += share * (spin[i] - motion[2, i])  # without the noise of this interval
        spin[i] = turn[i] / step
        for j in range(3):
            middle[i, j] = 0.5 * (middle[i, j] + c[i, j])
    for i in range(3):
        body.force[i] = (
            middle[i, 0] * push[0] + middle[i, 1] * push[1] + middle[i, 2] * push[2]
        ) / step


@njit(cache=True)
def _spread(nav, x, pieces, body, interval, sensors, work):
    """Covariance and sensor states over one interval: its length s, the factor of its noise, and
    whether some of that follows the speed.
    """
    step, extra, moving = interval
    covariance.fill_dynamics(nav[0:3], nav[3:6], body.force, work.f)
    covariance.fill_transition(work.f, body.middle, step, work.a, work.d, work.f2)
    if moving:
        square = nav[3] ** 2 + nav[4] ** 2 + nav[5] ** 2
        for i in range(6):
            work.white[i] = sensors.white[i] + sensors.white_speed[i] * square
    noise = 0.5 * step * extra
    covariance.add_white(pieces.nn, body.middle, work.white, noise)
    covariance.propagate(pieces, work.room, work.a, work.d, work.weight, sensors)
    covariance.add_white(pieces.nn, body.middle, work.white, noise)
    carry(x, work.x_new, sensors)


@njit(cache=True)
def _log(nav, nn, logs, row):
    """What the filter says at an epoch."""
    copy(nav, logs.nav[row])
    for i in range(9):
        logs.sd[row, i] = np.sqrt(nn[i, i])
    logs.sd[row, 9] = nn[0, 1]


@njit(cache=True)
def _keep(x, road, pieces, total, phi, nodes, node, smooth):
    """What the filter knows at a node."""
    copy(x, nodes.x[node])
    copy(road, nodes.road[node])
    pack(pieces, nodes.p[node])
    if smooth:
        copy(total, nodes.dx[node])
        copy_square(phi, nodes.phi[node])
        for i in range(phi.shape[0]):
            for j in range(phi.shape[0]):
                phi[i, j] = 1.0 if i == j else 0.0


@njit(cache=True)
def copy_square(given, out):
    """A square matrix into another."""
    for i in range(given.shape[0]):
        for j in range(given.shape[0]):
            out[i, j] = given[i, j]


@njit(cache=True, inline="always")
def correct(dtheta, dvel, step, x, sensors, driven, weight, turn, push):
    """The channels' errors as estimated, taken out of the increments, into turn and push (3,); the
    weights of the states that multiply readings, into weight (m,).

    With states that multiply readings twice: the second time they multiply what is left.
    """
    first, output, driver = sensors.first, sensors.output, sensors.driver
    for i in range(3):
        turn[i], push[i] = dtheta[i], dvel[i]
    for _ in range(2 if driven else 1):
        if driven:
            for j in range(first[6]):
                if driver[j] >= 3:
                    weight[j] = output[j] * push[driver[j] - 3] / step
                elif driver[j] >= 0:
                    weight[j] = output[j] * turn[driver[j]] / step
        for i in range(3):
            gyro_error, accel_error = 0.0, 0.0
            for j in range(first[i], first[i + 1]):
                gyro_error += weight[j] * x[j]
            for j in range(first[3 + i], first[4 + i]):
                accel_error += weight[j] * x[j]
            turn[i] = dtheta[i] - gyro_error * step
            push[i] = dvel[i] - accel_error * step


@njit(cache=True, inline="always")
def carry(x, x_new, sensors):
    """The sensor states over one interval, in place."""
    first, static, s = sensors.first, sensors.static, sensors.transition
    for ch in range(7):
        for i in range(first[ch], static[ch]):
            x_new[i] = 0.0
            for j in range(first[ch], static[ch]):
                x_new[i] += s[i, j] * x[j]
        for i in range(first[ch], static[ch]):
            x[i] = x_new[i]


@njit(cache=True)
def take_fix(nav, x, pieces, how, tail, fixes, f, moment, rejected, h6, gain, ph, dx, logs):
    """One fix: tests, then the updates with what passed, one number after the other. The correction
    goes into dx (n,); whether there is one is returned.
    """
    c, cv, spin, motion, white, step = moment
    y, arm, variance = logs.innovation[f], np.empty(3), np.empty(6)
    s, use = logs.covariance[f], fixes.use[f]
    measurement.innovation(nav, x, c, cv, how, spin, motion, fixes, f, y, arm)
    measurement.fill_rows(h6, nav, x, c, cv, how, motion, arm, fixes.delay[f], fixes.time[f])
    measurement.fill_variance(fixes.variance[f], c, arm, white, step, variance)
    measurement.fill_covariance(pieces, h6, tail, variance, ph, s)
    copy(nav[3:6], logs.velocity[f])
    bits, likelihood = 0, 0.0
    for part in range(2):
        if not use & (POSITION << part):
            continue
        if part == 0 and how.outliers[0] > 0.0:
            wild, density = measurement.wild_probability(s, y, how.outliers)
            bits |= POSITION
            likelihood += density
            if wild > 0.5:
                bits |= WILD
                for i in range(3):
                    variance[i] += how.outliers[1] ** 2
            continue
        square, _ = measurement.distance(s, y, 3 * part, 0.0)
        if square > how.gates[part]:
            rejected[part] += 1
            bits |= REJECTED_POSITION << part
            # the fixes agree among themselves, so it is the filter that is lost
            if rejected[part] > how.patience:
                for i in range(3 * part, 3 * part + 3):
                    pieces.nn[i, i] += y[i] * y[i]
                bits |= RECOVERED | (POSITION << part)
                rejected[part] = 0
        else:
            rejected[part] = 0
            bits |= POSITION << part
    zero(dx)
    nis, freedom = 0.0, 0
    for i in range(6):
        if (i < 3 and bits & POSITION) or (i >= 3 and bits & VELOCITY):
            residual = y[i]
            for j in range(dx.size):
                residual -= h6[i, j] * dx[j]
            sigma2 = covariance.update(pieces, h6[i], tail, variance[i], gain, ph)
            for j in range(dx.size):
                dx[j] += gain[j] * residual
            nis += residual * residual / sigma2
            freedom += 1
            logs.normalised[f, i] = residual / np.sqrt(sigma2)
            if i >= 3 or how.outliers[0] == 0.0:
                likelihood -= 0.5 * (
                    residual * residual / sigma2 + np.log(sigma2) + measurement.LOG_2_PI
                )
    logs.nis[f], logs.freedom[f], logs.bits[f] = nis, freedom, bits
    logs.likelihood[f] = likelihood
    return freedom > 0
