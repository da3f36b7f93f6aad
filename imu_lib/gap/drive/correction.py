"""What a fix says to the linear filter, compiled: innovations, corrections, and what the
parameters do to both.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.arrays import Array

from .structures import Fixes, Out, Random, Room


@njit(cache=True, nogil=True, inline="always")
def _project(p: Array, arm: Array, i: int, own: int, ph: Array) -> float:
    """P h into ph (n,) for number i of a fix, arm (3,) being its row and own its error's state or
    -1; h' P h is returned.
    """
    for j in range(ph.size):
        ph[j] = p[i, j]
    if i < 3:
        for r in range(3):
            if arm[r] != 0.0:
                for j in range(ph.size):
                    ph[j] += arm[r] * p[6 + r, j]
    if own >= 0:
        for j in range(ph.size):
            ph[j] += p[own, j]
    return _along(ph, arm, i, own)


@njit(cache=True, nogil=True, inline="always")
def _along(x: Array, arm: Array, i: int, own: int) -> float:
    """h' x for number i of a fix."""
    v = x[i]
    if i < 3:
        v += arm[0] * x[6] + arm[1] * x[7] + arm[2] * x[8]
    if own >= 0:
        v += x[own]
    return v


@njit(cache=True, nogil=True)
def judge(room: Room, random: Random, fixes: Fixes, fix: int, out: Out) -> None:
    """A position is taken for wild where that is likelier."""
    tame, other = np.log(1.0 - random.fraction), np.log(random.fraction)
    for i in range(3):
        arm, own = fixes.arm[fix, i], random.place[i]
        var = fixes.variance[fix, i] + _project(room.p, arm, i, own, room.ph)
        apart = (fixes.y[fix, i] - _along(room.x, arm, i, own)) ** 2
        more = var + random.scale * random.scale
        tame -= 0.5 * (apart / var + np.log(var))
        other -= 0.5 * (apart / more + np.log(more))
    out.wild[fix] = other > tame
    out.doubt[fix] = np.abs(other - tame)


@njit(cache=True, nogil=True, inline="always", fastmath={"reassoc", "contract"})
def take(room: Room, random: Random, fixes: Fixes, fix: int, out: Out) -> None:
    """The numbers of a fix, one after the other: innovations, and the corrections."""
    x, p, z, ph, gain = room.x, room.p, room.z, room.ph, room.gain
    n, count = x.size, z.shape[1]
    # taken out of the tuples once: each time costs as much as a row of the covariance
    use, arms, y, variance = fixes.use[fix], fixes.arm[fix], fixes.y[fix], fixes.variance[fix]
    e, s = out.e[fix], out.s[fix]
    wild = random.scale * random.scale if out.wild[fix] else 0.0
    for i in range(6):
        if not use[i]:
            continue
        arm, own = arms[i % 3], random.place[i]
        var = variance[i] + _project(p, arm, i, own, ph)
        if i < 3:
            var += wild
        root = np.sqrt(var)
        residual = y[i] - _along(x, arm, i, own)
        e[i], s[i] = residual / root, var
        for a in range(n):
            gain[a] = ph[a] / var
            x[a] += gain[a] * residual
        if count:
            row = out.jac[fix, i]
            _parameters(z, gain, (fixes.columns[fix, i], fixes.of), arm, (i, own), row)
            for j in range(count):
                row[j] /= root
        for a in range(n):
            v = gain[a]
            for b in range(n):
                p[a, b] -= v * ph[b]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _parameters(
    z: Array,
    gain: Array,
    column: tuple[Array, Array],
    arm: Array,
    place: tuple[int, int],
    row: Array,
) -> None:
    """What the parameters do to an innovation, into row (P,), and to the states after it, with the
    filter's gain (n,).
    """
    i, own = place
    n, count = z.shape
    for j in range(count):
        row[j] = z[i, j]
    values, of = column
    for k in range(of.size):
        row[of[k]] += values[k]
    if i < 3:
        for r in range(3):
            if arm[r] != 0.0:
                for j in range(count):
                    row[j] += arm[r] * z[6 + r, j]
    if own >= 0:
        for j in range(count):
            row[j] += z[own, j]
    for a in range(n):
        v = gain[a]
        for j in range(count):
            z[a, j] -= v * row[j]
