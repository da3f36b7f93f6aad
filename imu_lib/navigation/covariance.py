"""Error dynamics of the navigation states and the propagation of the filter's covariance,
compiled.

Navigation errors x_n = (position m, velocity m/s, attitude rad), NED, estimate minus truth, with
the estimated matrix C_hat = (I - [phi x]) C. Continuous model dx_n/dt = F x_n + G (H x_s + w), x_s
the sensor states: psi-free phi-angle model of Shin 2005 (Eqs. 2.51-2.56) and Groves 2013 (section
14.2.4), with the position error in metres.

The transition is A = I + F dt + (F dt)^2 / 2 on the navigation block, B = (I dt + F dt^2 / 2) G H
into it from the sensor states, and the exact S (Van Loan, once per run) on the sensor block. The
covariance is kept in three pieces, nn (9, 9), ns (9, m), ss (m, m); S acts channel by channel, so
that its zeros are never multiplied.
"""

import numpy as np
from numba import njit

from . import earth


@njit(cache=True)
def fill_dynamics(p, v, force, f):
    """F (9, 9) into f, at position p, velocity v and specific force in the navigation frame."""
    latitude, height = p[0], p[2]
    meridian, transverse = earth.radii(latitude)
    rm, rn = meridian + height, transverse + height
    sin, cos = np.sin(latitude), np.cos(latitude)
    tan = sin / cos
    vn, ve, vd = v[0], v[1], v[2]
    w, wc, ws = earth.RATE, earth.RATE * cos, earth.RATE * sin
    for i in range(9):
        for j in range(9):
            f[i, j] = 0.0
    f[0, 0], f[0, 2] = -vd / rm, vn / rm
    f[1, 0], f[1, 1], f[1, 2] = ve * tan / rn, -(vd + vn * tan) / rn, ve / rn
    f[0, 3] = f[1, 4] = f[2, 5] = 1.0
    f[3, 0] = -2.0 * ve * wc / rm - ve * ve / (rm * rn * cos * cos)
    f[3, 2] = vn * vd / (rm * rm) - ve * ve * tan / (rn * rn)
    f[4, 0] = 2.0 * w * (vn * cos - vd * sin) / rm + vn * ve / (rm * rn * cos * cos)
    f[4, 2] = (ve * vd + vn * ve * tan) / (rn * rn)
    f[5, 0] = 2.0 * ve * ws / rm
    f[5, 2] = (
        -ve * ve / (rn * rn)
        - vn * vn / (rm * rm)
        + 2.0 * earth.gravity(latitude, height) / (np.sqrt(meridian * transverse) + height)
    )
    f[3, 3], f[3, 4], f[3, 5] = vd / rm, -2.0 * ws - 2.0 * ve * tan / rn, vn / rm
    f[4, 3], f[4, 4], f[4, 5] = 2.0 * ws + ve * tan / rn, (vd + vn * tan) / rn, 2.0 * wc + ve / rn
    f[5, 3], f[5, 4] = -2.0 * vn / rm, -2.0 * wc - 2.0 * ve / rn
    f[3, 7], f[3, 8] = -force[2], force[1]
    f[4, 6], f[4, 8] = force[2], -force[0]
    f[5, 6], f[5, 7] = -force[1], force[0]
    f[6, 0], f[6, 2] = -ws / rm, ve / (rn * rn)
    f[7, 2] = -vn / (rm * rm)
    f[8, 0], f[8, 2] = -wc / rm - ve / (rm * rn * cos * cos), -ve * tan / (rn * rn)
    f[6, 4], f[7, 3], f[8, 4] = 1.0 / rn, -1.0 / rm, -tan / rn
    i0, i1, i2 = (
        wc + ve / rn,
        -vn / rm,
        -ws - ve * tan / rn,
    )  # rate of the navigation frame, inertial
    f[6, 7], f[6, 8] = i2, -i1
    f[7, 6], f[7, 8] = -i2, i0
    f[8, 6], f[8, 7] = i1, -i0


@njit(cache=True)
def fill_transition(f, c, dt, a, d, f2):
    """A (9, 9) into a and (I dt + F dt^2 / 2) G (9, 6; columns gyro, accelerometer) into d; f2 (9,
    9) is room to work in.
    """
    half = 0.5 * dt * dt
    for i in range(9):
        for j in range(9):
            f2[i, j] = 0.0
        for k in range(9):
            x = f[i, k] * half
            if x != 0.0:
                for j in range(9):
                    f2[i, j] += x * f[k, j]
    for i in range(9):
        for j in range(9):
            a[i, j] = f[i, j] * dt + f2[i, j]
        a[i, i] += 1.0
    for i in range(9):
        for j in range(3):
            d[i, j] = -half * (f[i, 6] * c[0, j] + f[i, 7] * c[1, j] + f[i, 8] * c[2, j])
            d[i, 3 + j] = half * (f[i, 3] * c[0, j] + f[i, 4] * c[1, j] + f[i, 5] * c[2, j])
    for i in range(3):
        for j in range(3):
            d[6 + i, j] -= dt * c[i, j]
            d[3 + i, 3 + j] += dt * c[i, j]


@njit(cache=True)
def add_white(nn, c, white, weight):
    """Adds weight * G diag(white) G' to nn: white (6,), two-sided densities, gyro then
    accelerometer.
    """
    for i in range(3):
        for j in range(i + 1):
            g = (
                c[i, 0] * c[j, 0] * white[0]
                + c[i, 1] * c[j, 1] * white[1]
                + c[i, 2] * c[j, 2] * white[2]
            ) * weight
            a = (
                c[i, 0] * c[j, 0] * white[3]
                + c[i, 1] * c[j, 1] * white[4]
                + c[i, 2] * c[j, 2] * white[5]
            ) * weight
            nn[6 + i, 6 + j] += g
            nn[3 + i, 3 + j] += a
            if i != j:
                nn[6 + j, 6 + i] += g
                nn[3 + j, 3 + i] += a


@njit(cache=True)
def project(pieces, h, tail, ph):
    """P h' into ph (n,), for h (n,) that is zero on the channels' states: on columns 9 to 9 +
    tail.
    """
    nn, ns, ss = pieces.nn, pieces.ns, pieces.ss
    m = ns.shape[1]
    for j in range(9 + m):
        ph[j] = 0.0
    for i in range(9):
        x = h[i]
        if x != 0.0:
            for j in range(9):
                ph[j] += x * nn[i, j]
            for j in range(m):
                ph[9 + j] += x * ns[i, j]
    for i in range(tail, m):
        x = h[9 + i]
        if x != 0.0:
            for j in range(9):
                ph[j] += x * ns[j, i]
            for j in range(m):
                ph[9 + j] += x * ss[i, j]


@njit(cache=True)
def update(pieces, h, tail, variance, k, ph):
    """Joseph update with one measurement h x, in place; returns the innovation variance.

    h (n,), zero on columns 9 to 9 + tail; k (n,) receives the gain, ph (n,) is room to work in.
    """
    nn, ns, ss = pieces.nn, pieces.ns, pieces.ss
    m = ns.shape[1]
    n = 9 + m
    project(pieces, h, tail, ph)
    s = variance
    for i in range(9):
        s += h[i] * ph[i]
    for i in range(9 + tail, n):
        s += h[i] * ph[i]
    for j in range(n):
        k[j] = ph[j] / s
    # P - k (Ph)', then minus (what is left of Ph) k', then k variance k': the order in which
    # rounding cannot make it negative
    for i in range(9):
        left = ph[i] * (variance / s)
        for j in range(i + 1):
            x = nn[i, j] - k[i] * ph[j] - left * k[j] + variance * k[i] * k[j]
            nn[i, j] = x
            nn[j, i] = x
        for j in range(m):
            ns[i, j] += -k[i] * ph[9 + j] - left * k[9 + j] + variance * k[i] * k[9 + j]
    for i in range(m):
        left = ph[9 + i] * (variance / s)
        for j in range(i + 1):
            x = ss[i, j] - k[9 + i] * ph[9 + j] - left * k[9 + j] + variance * k[9 + i] * k[9 + j]
            ss[i, j] = x
            ss[j, i] = x
    return s


def van_loan(f, q, dt):
    """Exact transition and step covariance of dx/dt = f x + w (Van Loan 1978, Eqs. 1.1-1.4): what
    the fast forms are checked against.

    f, q : ndarray, shape (k, k), dynamics and two-sided density of w
    """
    from scipy.linalg import expm

    k = f.shape[0]
    block = expm(np.block([[-f, q], [np.zeros((k, k)), f.T]]) * dt)
    transition = block[k:, k:].T
    return transition, transition @ block[:k, k:]
