"""A drive condensed to its fixes: how errors move from one fix to the next along a known path.

The nominal path is cut at nodes (every fix, and in between where fixes are rare). Over each
interval the strapdown runs from the nominal state at its begin, and what an error of the state, a
constant error of each channel, unit white noise of each channel and each parameter of `columns.IMU`
do by its end is accumulated (the error model is that of the filter, `navigation.covariance`). The
likelihood of the innovations (`linear`) then costs a step per fix and not one per IMU sample, and is
linear in the parameters (multiple shooting; Friedland 1969 for the separation of parameters from states).
"""

import numpy as np
from numba import njit

from imu_lib.navigation import attitude, covariance, earth, strapdown


@njit(cache=True)
def _error_to(q, p, v, p_to, v_to, q_to, out):
    """(p, v, q) minus (p_to, v_to, q_to) as the filter's error state, into out (9,)."""
    meridian, transverse = earth.radii(p_to[0])
    out[0] = (p[0] - p_to[0]) * (meridian + p_to[2])
    out[1] = (p[1] - p_to[1]) * (transverse + p_to[2]) * np.cos(p_to[0])
    out[2] = p_to[2] - p[2]
    for i in range(3):
        out[3 + i] = v[i] - v_to[i]
    c, d = np.empty((3, 3)), np.empty((3, 3))
    attitude.fill_matrix(q, c)
    attitude.fill_matrix(q_to, d)
    r = c @ d.T
    out[6] = 0.5 * (r[1, 2] - r[2, 1])
    out[7] = 0.5 * (r[2, 0] - r[0, 2])
    out[8] = 0.5 * (r[0, 1] - r[1, 0])


@njit(cache=True)
def _columns(w, f, warmth, speed, late, u):
    """Errors of the six channels (columns.IMU without the clock's path) into u (number, 6)."""
    u[:, :] = 0.0
    for i in range(3):
        u[i, 3 + i] = f[i]
        u[3 + i, i] = w[i]
    k = 0
    for i in range(3):
        for j in range(3):
            if i != j:
                u[6 + k, 3 + i] = f[j]
                u[12 + k, i] = w[j]
                k += 1
            u[18 + 3 * i + j, i] = f[j]
    for i in range(3):
        u[27, i] = w[i]
        u[27, 3 + i] = f[i]
    for i in range(6):
        u[28 + i, i] = 1.0
        u[34 + i, i] = warmth
        u[40 + i, i] = speed
        u[46 + i, i] = late


@njit(cache=True, nogil=True)
def intervals(epochs, pos, vel, quat, dt, dtheta, dvel, bias, extra, warmth, late, sub, columns):
    """Accumulate over the intervals between nodes.

    epochs (k,) into the stretch; pos, vel, quat at the nodes; dt, dtheta, dvel, extra the stretch;
    bias (6,) taken off the readings; warmth, late (n,) regressors; sub: samples per linear step.
    returns : phi (k-1, 9, 9), gain (k-1, 9, 6), noise (k-1, 6, 9, 9), force (k-1, columns, 9),
    jump (k-1, 9): nominal run on, minus nominal at the next node
    """
    k = epochs.size - 1
    phi, gain = np.zeros((k, 9, 9)), np.zeros((k, 9, 6))
    noise, force, jump = np.zeros((k, 6, 9, 9)), np.zeros((k, columns, 9)), np.zeros((k, 9))
    c, before, f, a = np.empty((3, 3)), np.empty((3, 3)), np.empty((9, 9)), np.empty((9, 9))
    d, f2, u = np.empty((9, 6)), np.empty((9, 9)), np.empty((columns, 6))
    fn, w, fb, mean_c = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    turn, push, turn0, push0 = np.empty(3), np.empty(3), np.zeros(3), np.zeros(3)
    for i in range(k):
        p, v, q = pos[i].copy(), vel[i].copy(), quat[i].copy()
        attitude.fill_matrix(q, c)
        x = np.eye(9)
        g, n, h = np.zeros((9, 6)), np.zeros((6, 9, 9)), np.zeros((columns, 9))
        e = epochs[i]
        while e < epochs[i + 1]:
            stop = min(e + sub, epochs[i + 1])
            step, scale = 0.0, 0.0
            w[:], fb[:], fn[:], mean_c[:, :] = 0.0, 0.0, 0.0, 0.0
            for j in range(e, stop):
                for r in range(3):
                    turn[r] = dtheta[j, r] - bias[r] * dt[j]
                    push[r] = dvel[j, r] - bias[3 + r] * dt[j]
                before[:, :] = c
                strapdown.step(p, v, q, c, turn, push, turn0, push0, dt[j])
                turn0[:], push0[:] = turn, push
                mid = 0.5 * (before + c)
                for r in range(3):
                    w[r] += turn[r]
                    fb[r] += push[r]
                    fn[r] += mid[r, 0] * push[0] + mid[r, 1] * push[1] + mid[r, 2] * push[2]
                mean_c += mid
                step += dt[j]
                scale += extra[j] * dt[j]
            mean_c /= stop - e
            w /= step
            fb /= step
            fn /= step
            covariance.fill_dynamics(p, v, fn, f)
            covariance.fill_transition(f, mean_c, step, a, d, f2)
            speed = np.sqrt(v[0] ** 2 + v[1] ** 2)
            _columns(w, fb, warmth[e], speed, late[e], u)
            x = a @ x
            g = a @ g + d
            h = h @ a.T + u @ d.T
            for r in range(3):
                h[27, r] += v[r] * step
            for ch in range(6):
                n[ch] = a @ n[ch] @ a.T
                for r in range(9):
                    for s in range(9):
                        n[ch, r, s] += d[r, ch] * d[s, ch] * scale / (step * step)
            e = stop
        phi[i], gain[i], noise[i], force[i] = x, g, n, h
        _error_to(q, p, v, pos[i + 1], vel[i + 1], quat[i + 1], jump[i])
    return phi, gain, noise, force, jump
