"""The loosely coupled filter's loop over the epochs, compiled.

One call runs from one epoch to another, so that a stored moment can be run on alone: an outage is
that moment run on without fixes. All the filter knows at a moment is in `structures.State`, changed
in place.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from . import attitude, constraint, covariance, measurement, propagation, strapdown
from .fix_update import take_fix
from .pieces import accumulate, add, copy, copy_matrix, pack, unpack, zero
from .structures import MOUNTING, Body, Correction, Live, Pieces, Room

AVERAGE = 0.2  # s over which motion is averaged for the rows of the measurements' states


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
def run(span, state, sensors, how, given, written, smooth, several):
    """Epochs span[0]+1 .. span[1] (epoch k ends interval k-1 of the IMU); epoch span[0] is the
    state given. several : the sensors over so many intervals, and how many, over which the
    covariance goes at once where no fix and no node comes between (1: never).

    The arguments are those of `structures`, `written` included; prior, phi and dx of its nodes are
    for the smoother.
    """
    begin, end = span
    imu, fixes, speeds = given
    logs, nodes = written
    m, n = state.x.size, 9 + state.x.size
    pieces = Pieces(np.empty((9, 9)), np.empty((9, m)), np.empty((m, m)))
    unpack(state.p, pieces)
    live = Live(state.nav, state.x, state.road, pieces, np.empty((3, 3)), np.empty((3, 3)))
    nav, x, c = live.nav, live.x, live.c
    body, mean, work, room = _body(), _body(), _work(m, sensors), _correction(n, sensors.first[6])
    coarse, every = several
    left, size, length, extra = 0, 1, 0.0, 0.0  # of the intervals that go at once
    turn, push, dx = np.empty(3), np.empty(3), room.dx
    total, phi, rejected = np.zeros(n), np.eye(n), np.zeros(2, np.int64)
    driven, moving = (sensors.driver >= 0).any(), (sensors.white_speed > 0.0).any()
    fix = np.searchsorted(fixes.epoch, begin, side="right")
    speed_fix = np.searchsorted(speeds.epoch, begin, side="right")
    node = np.searchsorted(nodes.epoch, begin, side="right")
    attitude.fill_matrix(nav[6:10], c)
    measurement.fill_mounting_now(how, x, live.cv)
    for k in range(begin, end):
        step, epoch = imu.dt[k], k + 1
        reading = imu.dtheta[k], imu.dvel[k], step
        correct(reading, x, sensors, driven, work.weight, turn, push)
        _move(nav, c, turn, push, step, body)
        if left == 0:
            size = every if _free(k + every, end, fixes.epoch, fix, nodes.epoch, node) else 1
            left, length, extra = size, 0.0, 0.0
        left -= 1
        if size == 1:
            _spread(nav, x, pieces, body, (step, imu.extra_noise[k], moving), sensors, work)
        else:
            length += step
            extra += step * imu.extra_noise[k]
            _gather(mean, body, step / length)
            if left == 0:
                _spread(nav, x, pieces, mean, (length, extra / length, moving), coarse, work)
        at_node = node < nodes.epoch.size and nodes.epoch[node] == epoch
        if smooth:
            accumulate(phi, work.a, work.d, work.weight, sensors)
            zero(total)
            if at_node:
                pack(pieces, nodes.prior[node])
        while fix < fixes.epoch.size and fixes.epoch[fix] <= epoch:
            if take_fix(live, how, fixes, fix, (body, work.white, step), rejected, room, logs):
                measurement.apply(nav, x, dx)
                attitude.fill_matrix(nav[6:10], c)
                if how.at[MOUNTING] >= 0:
                    measurement.fill_mounting_now(how, x, live.cv)
                add(total, dx)
                constraint.learn(live, how)
            fix += 1
        while speed_fix < speeds.epoch.size and speeds.epoch[speed_fix] <= epoch:
            measurement.take_speed(live, how, speeds, speed_fix, room)
            attitude.fill_matrix(nav[6:10], c)
            add(total, dx)
            speed_fix += 1
        if constraint.due(nav, how, live.road, epoch):
            constraint.use(live, how, body.spin, room)
            add(total, dx)
        _log(nav, pieces.nn, logs, k - begin)
        if at_node:
            _keep(live, total, phi, nodes, node, smooth)
            node += 1
    pack(pieces, state.p)


@njit(cache=True)
def _free(until, end, fixes, fix, nodes, node):
    """Whether no fix and no node comes before an epoch of the run."""
    free = until <= end
    if fix < fixes.size:
        free = free and fixes[fix] >= until
    if node < nodes.size:
        free = free and nodes[node] >= until
    return free


@njit(cache=True)
def _gather(mean, body, share):
    """Attitude and force of an interval into their means over several; share : of the time until
    now that it is: 1 for the first, before which there is nothing.
    """
    for i in range(3):
        old = mean.force[i] if share < 1.0 else 0.0
        mean.force[i] = old + share * (body.force[i] - old)
        for j in range(3):
            old = mean.middle[i, j] if share < 1.0 else 0.0
            mean.middle[i, j] = old + share * (body.middle[i, j] - old)


@njit(cache=True)
def _body():
    return Body(np.empty(3), np.empty((3, 3)), np.empty(3), np.zeros(3), np.zeros((3, 3)))


@njit(cache=True)
def _correction(n, tail):
    dx = np.empty(n)
    return Correction(dx, np.empty(n), np.empty((6, n)), np.empty(n), np.empty(n), tail)


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
    now, last = (nav[0:3], nav[3:6], nav[6:10], c), (nav[10:13], nav[13:16])
    strapdown.step(now, (turn, push), last, step)
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
    propagation.propagate(pieces, work.room, work.a, work.d, work.weight, sensors)
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
def _keep(live, total, phi, nodes, node, smooth):
    """What the filter knows at a node."""
    copy(live.x, nodes.x[node])
    copy(live.road, nodes.road[node])
    pack(live.pieces, nodes.p[node])
    if smooth:
        copy(total, nodes.dx[node])
        copy_matrix(phi, nodes.phi[node])
        for i in range(phi.shape[0]):
            for j in range(phi.shape[0]):
                phi[i, j] = 1.0 if i == j else 0.0


@njit(cache=True, inline="always")
def correct(reading, x, sensors, driven, weight, turn, push):
    """The channels' errors as estimated, taken out of a reading (increments of angle and velocity
    (3,) over a step, s), into turn and push (3,); the weights of the states that multiply
    readings, into weight (m,).

    With states that multiply readings twice: the second time they multiply what is left.
    """
    dtheta, dvel, step = reading
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
