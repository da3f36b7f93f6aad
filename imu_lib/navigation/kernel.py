"""The loosely coupled filter's loop over the epochs, compiled.

One call runs from one epoch to another, so that a stored moment can be run on alone: an outage is
that moment run on
without fixes. All the filter knows at a moment is in four arrays, changed in place:
nav (16,) position 3, velocity 3, quaternion 4, the increments of the interval before 6; x (m,)
sensor states;
p (9 + m, 9 + m) covariance; road (4,) sum of the unit velocity in the body frame and its count.
"""

import numpy as np
from numba import njit

from . import attitude, covariance, earth, strapdown

POSITION, VELOCITY = 1, 2  # bits of a fix's accepted parts
REJECTED_POSITION, REJECTED_VELOCITY, RECOVERED = 4, 8, 16


@njit(cache=True)
def _zero(v):
    for i in range(v.size):
        v[i] = 0.0


@njit(cache=True)
def _add(total, v):
    for i in range(v.size):
        total[i] += v[i]


@njit(cache=True)
def _innovation(nav, c, lever, spin, delay, acceleration, fix, y):
    """Predicted minus measured antenna position (m) and velocity (m/s) at the fix's own time, into
    y (6,).
    """
    meridian, transverse = earth.radii(nav[0])
    arm0 = c[0, 0] * lever[0] + c[0, 1] * lever[1] + c[0, 2] * lever[2]
    arm1 = c[1, 0] * lever[0] + c[1, 1] * lever[1] + c[1, 2] * lever[2]
    arm2 = c[2, 0] * lever[0] + c[2, 1] * lever[1] + c[2, 2] * lever[2]
    back = 0.5 * delay * delay
    y[0] = (nav[0] - fix[0]) * (meridian + nav[2]) + arm0 - nav[3] * delay + acceleration[0] * back
    y[1] = (
        (nav[1] - fix[1]) * (transverse + nav[2]) * np.cos(nav[0])
        + arm1
        - nav[4] * delay
        + acceleration[1] * back
    )
    y[2] = fix[2] - nav[2] + arm2 - nav[5] * delay + acceleration[2] * back
    # velocity of the antenna about the sensor: omega x lever, turned
    t0, t1, t2 = (
        spin[1] * lever[2] - spin[2] * lever[1],
        spin[2] * lever[0] - spin[0] * lever[2],
        spin[0] * lever[1] - spin[1] * lever[0],
    )
    for i in range(3):
        y[3 + i] = (
            nav[3 + i]
            + c[i, 0] * t0
            + c[i, 1] * t1
            + c[i, 2] * t2
            - fix[3 + i]
            - acceleration[i] * delay
        )
    return arm0, arm1, arm2


@njit(cache=True)
def _variance(given, c, lever, white, step, variance):
    """Variances of a fix, and what the gyros' white noise of one interval, N^2 / dt, adds to the
    antenna's velocity about the sensor.
    """
    for i in range(3):
        m0 = c[i, 2] * lever[1] - c[i, 1] * lever[2]  # row of C [lever x]
        m1 = c[i, 0] * lever[2] - c[i, 2] * lever[0]
        m2 = c[i, 1] * lever[0] - c[i, 0] * lever[1]
        variance[i] = given[i]
        variance[3 + i] = (
            given[3 + i] + (m0 * m0 * white[0] + m1 * m1 * white[1] + m2 * m2 * white[2]) / step
        )


@njit(cache=True)
def _row(i, arm0, arm1, arm2, delay, h):
    """Row i of the measurement matrix: position with [arm x] on the attitude error and the delay
    on the velocity error.
    """
    _zero(h)
    if i < 3:
        h[i] = 1.0
        h[3 + i] = -delay
        if i == 0:
            h[7], h[8] = -arm2, arm1
        elif i == 1:
            h[6], h[8] = arm2, -arm0
        else:
            h[6], h[7] = -arm1, arm0
    else:
        h[i] = 1.0


@njit(cache=True)
def _distance(nn, y, variance, start):
    """Squared Mahalanobis distance of three innovations whose states begin at `start` (the lever
    arm's share is small and left out).
    """
    a, b, c = (
        nn[start, start] + variance[start],
        nn[start + 1, start + 1] + variance[start + 1],
        nn[start + 2, start + 2] + variance[start + 2],
    )
    d, e, f = nn[start, start + 1], nn[start, start + 2], nn[start + 1, start + 2]
    det = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    x, z, w = y[start], y[start + 1], y[start + 2]
    return (
        x * x * (b * c - f * f)
        + z * z * (a * c - e * e)
        + w * w * (a * b - d * d)
        + 2.0 * (x * z * (e * f - d * c) + x * w * (d * f - b * e) + z * w * (d * e - a * f))
    ) / det


@njit(cache=True)
def _apply(nav, x, dx):
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
def run(
    begin,
    end,
    nav,
    x,
    p,
    road,
    dt,
    dtheta,
    dvel,
    s,
    q,
    output,
    first,
    white,
    scale,
    extra_noise,
    fix_epoch,
    fix_delay,
    fix_value,
    fix_variance,
    fix_use,
    lever,
    gates,
    patience,
    constraint,
    log,
    sd_log,
    fix_log,
    node_epoch,
    node_x,
    node_p,
    node_prior,
    node_phi,
    node_dx,
    node_road,
    smooth,
):
    """Epochs begin+1 .. end (epoch k ends interval k-1 of dt, dtheta, dvel); epoch `begin` is the
    state given.

    extra_noise (n,) multiplies the white densities of an interval (bridged gaps); fix_* are sorted
    by epoch, fix_use has bits
    POSITION and VELOCITY; gates (2,) limits of the squared distances; patience: rejected fixes in
    a row before the
    filter widens its covariance and takes the next; constraint (4,): sd m/s (0: off), epochs
    between uses, least speed m/s,
    fixes that must have shown the vehicle's forward axis.
    Writes log (end-begin, 16), sd_log (end-begin, 10: nine standard deviations and the north-east
    covariance), fix_log
    (fixes, 9: six normalised innovations, squared norm, its degrees of freedom, bits), and at
    node_epoch the state after (node_x,
    node_p, node_road) and, for the smoother, the covariance before the update, the transition
    since the last node, the correction made.
    """
    m = x.size
    n = 9 + m
    c, before = np.empty((3, 3)), np.empty((3, 3))
    f, a, d, f2 = np.empty((9, 9)), np.empty((9, 9)), np.empty((9, 6)), np.empty((9, 9))
    w9, vs, es, vh, ts = (
        np.empty((9, 9)),
        np.empty((9, m)),
        np.empty((6, m)),
        np.empty((9, 6)),
        np.empty((m, m)),
    )
    nn, ns, ss = np.empty((9, 9)), np.empty((9, m)), np.empty((m, m))
    _unpack(p, nn, ns, ss)
    h9, gain, ph, dx, total, weight = (
        np.empty(9),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        output.copy(),
    )
    turn, push, force, spin, acceleration, y = (
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(6),
    )
    v_before, x_new, variance = np.empty(3), np.empty(m), np.empty(6)
    phi = np.eye(n)
    fix = np.searchsorted(fix_epoch, begin, side="right")
    node = np.searchsorted(node_epoch, begin, side="right")
    rejected_position, rejected_velocity = 0, 0
    attitude.fill_matrix(nav[6:10], c)
    for k in range(begin, end):
        step = dt[k]
        for i in range(3):  # the channels' errors as estimated, taken out of the readings
            gyro_error, accel_error = 0.0, 0.0
            for j in range(first[i], first[i + 1]):
                if scale[j]:
                    weight[j] = output[j] * dtheta[k, i] / step
                gyro_error += weight[j] * x[j]
            for j in range(first[3 + i], first[4 + i]):
                if scale[j]:
                    weight[j] = output[j] * dvel[k, i] / step
                accel_error += weight[j] * x[j]
            turn[i] = dtheta[k, i] - gyro_error * step
            push[i] = dvel[k, i] - accel_error * step
        for i in range(3):
            v_before[i] = nav[3 + i]
            for j in range(3):
                before[i, j] = c[i, j]
        strapdown.step(nav[0:3], nav[3:6], nav[6:10], c, turn, push, nav[10:13], nav[13:16], step)
        for i in range(3):
            nav[10 + i], nav[13 + i] = turn[i], push[i]
            acceleration[i] = (nav[3 + i] - v_before[i]) / step
            spin[i] = turn[i] / step
            for j in range(3):
                before[i, j] = 0.5 * (before[i, j] + c[i, j])
        for i in range(3):
            force[i] = (
                before[i, 0] * push[0] + before[i, 1] * push[1] + before[i, 2] * push[2]
            ) / step
        covariance.fill_dynamics(nav[0:3], nav[3:6], force, f)
        covariance.fill_transition(f, before, step, a, d, f2)
        noise = 0.5 * step * extra_noise[k]
        covariance.add_white(nn, before, white, noise)
        covariance.propagate(nn, ns, ss, a, d, weight, first, s, q, w9, vs, es, vh, ts)
        covariance.add_white(nn, before, white, noise)
        for ch in range(6):
            for i in range(first[ch], first[ch + 1]):
                x_new[i] = 0.0
                for j in range(first[ch], first[ch + 1]):
                    x_new[i] += s[i, j] * x[j]
        _copy(x_new, x)
        epoch = k + 1
        if smooth:
            _accumulate(phi, a, d, weight, first, s)
            _zero(total)
            if node < node_epoch.size and node_epoch[node] == epoch:
                _pack(nn, ns, ss, node_prior[node])
        while fix < fix_epoch.size and fix_epoch[fix] <= epoch:
            arm0, arm1, arm2 = _innovation(
                nav, c, lever, spin, fix_delay[fix], acceleration, fix_value[fix], y
            )
            use, bits = fix_use[fix], 0
            _variance(fix_variance[fix], c, lever, white, step, variance)
            if use & POSITION:
                distance = _distance(nn, y, variance, 0)
                if distance > gates[0]:
                    rejected_position += 1
                    bits |= REJECTED_POSITION
                    if (
                        rejected_position > patience
                    ):  # the fixes agree among themselves, so it is the filter that is lost
                        for i in range(3):
                            nn[i, i] += y[i] * y[i]
                        bits |= RECOVERED | POSITION
                        rejected_position = 0
                else:
                    rejected_position = 0
                    bits |= POSITION
            if use & VELOCITY:
                distance = _distance(nn, y, variance, 3)
                if distance > gates[1]:
                    rejected_velocity += 1
                    bits |= REJECTED_VELOCITY
                    if rejected_velocity > patience:
                        for i in range(3, 6):
                            nn[i, i] += y[i] * y[i]
                        bits |= RECOVERED | VELOCITY
                        rejected_velocity = 0
                else:
                    rejected_velocity = 0
                    bits |= VELOCITY
            _zero(dx)
            nis, freedom = 0.0, 0
            for i in range(6):
                fix_log[fix, i] = np.nan
                if (i < 3 and bits & POSITION) or (i >= 3 and bits & VELOCITY):
                    _row(i, arm0, arm1, arm2, fix_delay[fix], h9)
                    residual = y[i]
                    for j in range(9):
                        residual -= h9[j] * dx[j]
                    sigma2 = covariance.update(nn, ns, ss, h9, variance[i], gain, ph)
                    for j in range(n):
                        dx[j] += gain[j] * residual
                    nis += residual * residual / sigma2
                    freedom += 1
                    fix_log[fix, i] = residual / np.sqrt(sigma2)
            fix_log[fix, 6], fix_log[fix, 7], fix_log[fix, 8] = nis, freedom, bits
            if freedom:
                _apply(nav, x, dx)
                attitude.fill_matrix(nav[6:10], c)
                if smooth:
                    _add(total, dx)
                speed = np.sqrt(nav[3] ** 2 + nav[4] ** 2 + nav[5] ** 2)
                if constraint[0] > 0.0 and speed > constraint[2]:
                    for i in range(3):
                        road[i] += (c[0, i] * nav[3] + c[1, i] * nav[4] + c[2, i] * nav[5]) / speed
                    road[3] += 1.0
            fix += 1
        if constraint[0] > 0.0 and epoch % int(constraint[1]) == 0 and road[3] >= constraint[3]:
            if np.sqrt(nav[3] ** 2 + nav[4] ** 2 + nav[5] ** 2) > constraint[2]:
                _constrain(
                    nav, x, c, nn, ns, ss, road, constraint[0] + abs(spin[2]), h9, gain, ph, dx
                )
                if smooth:
                    _add(total, dx)
        row = k - begin
        _copy(nav, log[row])
        for i in range(9):
            sd_log[row, i] = np.sqrt(nn[i, i])
        sd_log[row, 9] = nn[0, 1]
        if node < node_epoch.size and node_epoch[node] == epoch:
            _copy(x, node_x[node])
            _copy(road, node_road[node])
            _pack(nn, ns, ss, node_p[node])
            if smooth:
                _copy(total, node_dx[node])
                for i in range(n):
                    for j in range(n):
                        node_phi[node, i, j] = phi[i, j]
                        phi[i, j] = 1.0 if i == j else 0.0
            node += 1
    _pack(nn, ns, ss, p)


@njit(cache=True)
def _copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


@njit(cache=True)
def _unpack(p, nn, ns, ss):
    m = ns.shape[1]
    for i in range(9):
        for j in range(9):
            nn[i, j] = p[i, j]
        for j in range(m):
            ns[i, j] = p[i, 9 + j]
    for i in range(m):
        for j in range(m):
            ss[i, j] = p[9 + i, 9 + j]


@njit(cache=True)
def _pack(nn, ns, ss, p):
    """The three pieces of the covariance into one matrix."""
    m = ns.shape[1]
    for i in range(9):
        for j in range(9):
            p[i, j] = nn[i, j]
        for j in range(m):
            p[i, 9 + j] = ns[i, j]
            p[9 + j, i] = ns[i, j]
    for i in range(m):
        for j in range(m):
            p[9 + i, 9 + j] = ss[i, j]


@njit(cache=True)
def _constrain(nav, x, c, nn, ns, ss, road, sd, h9, gain, ph, dx):
    """Vehicle constraint: no velocity across the forward axis that the accepted fixes have shown
    in the body frame.
    """
    u = road[:3] / np.sqrt(road[0] ** 2 + road[1] ** 2 + road[2] ** 2)
    _zero(dx)
    across = np.empty(3)
    for turn in range(2):
        if turn == 0:  # u x z, sideways
            across[0], across[1], across[2] = u[1], -u[0], 0.0
        else:  # u x (u x z), up and down
            across[0], across[1], across[2] = u[0] * u[2], u[1] * u[2], -(u[0] ** 2 + u[1] ** 2)
        length = np.sqrt(across[0] ** 2 + across[1] ** 2 + across[2] ** 2)
        w0 = (c[0, 0] * across[0] + c[0, 1] * across[1] + c[0, 2] * across[2]) / length
        w1 = (c[1, 0] * across[0] + c[1, 1] * across[1] + c[1, 2] * across[2]) / length
        w2 = (c[2, 0] * across[0] + c[2, 1] * across[1] + c[2, 2] * across[2]) / length
        residual = w0 * nav[3] + w1 * nav[4] + w2 * nav[5]
        _zero(h9)
        h9[3], h9[4], h9[5] = w0, w1, w2
        h9[6], h9[7], h9[8] = (
            -(w1 * nav[5] - w2 * nav[4]),
            -(w2 * nav[3] - w0 * nav[5]),
            -(w0 * nav[4] - w1 * nav[3]),
        )
        for j in range(9):
            residual -= h9[j] * dx[j]
        covariance.update(nn, ns, ss, h9, sd * sd, gain, ph)
        for j in range(dx.size):
            dx[j] += gain[j] * residual
    _apply(nav, x, dx)
    attitude.fill_matrix(nav[6:10], c)


@njit(cache=True)
def _accumulate(phi, a, d, weight, first, s):
    """phi becomes the transition of this interval times phi."""
    n = phi.shape[0]
    new = np.zeros((n, n))
    for i in range(9):
        for k in range(9):
            for j in range(n):
                new[i, j] += a[i, k] * phi[k, j]
    for ch in range(6):
        for k in range(first[ch], first[ch + 1]):
            for i in range(9):
                for j in range(n):
                    new[i, j] += d[i, ch] * weight[k] * phi[9 + k, j]
            for i in range(first[ch], first[ch + 1]):
                for j in range(n):
                    new[9 + i, j] += s[i, k] * phi[9 + k, j]
    for i in range(n):
        _copy(new[i], phi[i])
