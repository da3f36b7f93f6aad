"""A drive condensed to its fixes: how errors move from one fix to the next along a known path.

The nominal path is cut at nodes (every fix, and in between where fixes are rare). Over each
interval the strapdown runs from the nominal state at its begin, and what an error of the state, a
constant error of each channel, unit white noise of each channel and each parameter of `columns.IMU`
do by its end is accumulated (the error model is that of the filter, `navigation.covariance`). The
likelihood of the innovations (`linear`) then costs a step per fix and not one per IMU sample, and
is linear in the parameters (multiple shooting; Friedland 1969 for the separation of parameters
from states).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.arrays import Array
from imu_lib.gap.drive.legs import Leg
from imu_lib.navigation import attitude, covariance, earth, strapdown
from imu_lib.navigation.pieces import copy, copy_matrix
from imu_lib.navigation.structures import Imu

from . import columns
from .structures import Nominal, Pieces


@njit(cache=True)
def _error_to(
    q: Array, p: Array, v: Array, p_to: Array, v_to: Array, q_to: Array, out: Array
) -> None:
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
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[6 + i] = 0.0
        for r in range(3):  # what is odd of c d'
            out[6 + i] += 0.5 * (c[j, r] * d[k, r] - c[k, r] * d[j, r])


@njit(cache=True, nogil=True)
def intervals(
    epochs: Array, nominal: Nominal, imu: Imu, bias: Array, drifts: Array, sub: int, out: Pieces
) -> None:
    """Accumulate over the intervals between nodes, into out: `Pieces`.

    epochs (k,) into the stretch; nominal at the nodes; imu of the stretch; bias (6,) taken off the
    readings; drifts (n, 2) regressors; sub: samples per linear step
    """
    longest = 1
    for i in range(epochs.size - 1):
        longest = max(longest, (epochs[i + 1] - epochs[i] + sub - 1) // sub)
    a, d = np.empty((longest, 9, 9)), np.empty((longest, 9, 6))
    felt, along = np.empty((longest, 3, 3)), np.empty((longest, 8))
    c, f, f2, mean_c, last = (
        np.empty((3, 3)), np.empty((9, 9)), np.empty((9, 9)), np.empty((3, 3)), np.zeros((2, 3)),
    )  # fmt: skip
    for i in range(epochs.size - 1):
        p, v, q = (
            nominal.position[i].copy(),
            nominal.velocity[i].copy(),
            nominal.quaternion[i].copy(),
        )
        attitude.fill_matrix(q, c)
        e, steps = epochs[i], 0
        while e < epochs[i + 1]:
            stop = min(e + sub, epochs[i + 1])
            means = felt[steps], mean_c, last
            step, scale = _run_on(p, v, q, c, imu, bias, (e, stop), means)
            covariance.fill_dynamics(p, v, felt[steps, 2], f)
            covariance.fill_transition(f, mean_c, step, a[steps], d[steps], f2)
            now = along[steps]
            copy(v, now[:3])
            now[3], now[4] = step, scale / (step * step)
            now[5], now[6], now[7] = drifts[e, 0], np.sqrt(v[0] ** 2 + v[1] ** 2), drifts[e, 1]
            e, steps = stop, steps + 1
        _carried(
            (a, d, felt, along), steps, (out.phi[i], out.gain[i], out.noise[i], out.force[i]), f
        )
        _error_to(
            q, p, v, nominal.position[i + 1], nominal.velocity[i + 1], nominal.quaternion[i + 1],
            out.jump[i],
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _carried(
    made: tuple[Array, Array, Array, Array],
    steps: int,
    out: tuple[Array, Array, Array, Array],
    room: Array,
) -> None:
    """What errors in the linear steps of an interval have become by its end, into out: phi (9, 9),
    gain (9, 6), noise (6, 9, 9) and force (columns, 9). From the last step to the first, so that
    what is carried on is one transition and not the many that are asked for.

    made: transitions, gains, what was felt, and velocity, length s, factor of the noise and
    regressors of each step; room (9, 9)
    """
    a, d, felt, along = made
    phi, gain, noise, force = out
    last = np.empty((9, 6))
    gain[:, :], noise[:, :, :], force[:, :] = 0.0, 0.0, 0.0
    for r in range(9):
        for s in range(9):
            phi[r, s] = 1.0 if r == s else 0.0
    for k in range(steps - 1, -1, -1):
        _product(phi, d[k], last)
        for r in range(9):
            for ch in range(6):
                gain[r, ch] += last[r, ch]
            for s in range(3):  # a clock that runs fast has come further
                force[27, r] += phi[r, s] * along[k, s] * along[k, 3]
        for ch in range(6):
            for r in range(9):
                weight = last[r, ch] * along[k, 4]
                for s in range(9):
                    noise[ch, r, s] += weight * last[s, ch]
        _force(felt[k, 0], felt[k, 1], along[k, 5:], last, force)
        copy_matrix(phi, room)
        _product(room, a[k], phi)


@njit(cache=True, nogil=True)
def _product(a: Array, b: Array, out: Array) -> None:
    """a b into out."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            out[i, j] = 0.0
        for k in range(a.shape[1]):
            x = a[i, k]
            for j in range(b.shape[1]):
                out[i, j] += x * b[k, j]


@njit(cache=True, nogil=True)
def _force(w: Array, f: Array, follows: Array, gain: Array, force: Array) -> None:
    """Add what each of columns.IMU does over a linear step to force (columns, 9): w rad/s and f
    m/s^2 in the body, follows (3,) of temperature, speed and the step, gain (9, 6).
    """
    for r in range(9):
        k = 0
        for i in range(3):
            g, a = gain[r, i], gain[r, 3 + i]
            force[i, r] += f[i] * a
            force[3 + i, r] += w[i] * g
            force[27, r] += w[i] * g + f[i] * a
            for j in range(3):
                if i != j:
                    force[6 + k, r] += f[j] * a
                    force[12 + k, r] += w[j] * g
                    k += 1
                force[18 + 3 * i + j, r] += f[j] * g
        for i in range(6):
            g = gain[r, i]
            force[28 + i, r] += g
            for j in range(3):
                force[34 + 6 * j + i, r] += follows[j] * g


@njit(cache=True, nogil=True)
def _run_on(
    p: Array,
    v: Array,
    q: Array,
    c: Array,
    imu: Imu,
    bias: Array,
    part: tuple[int, int],
    means: tuple[Array, Array, Array],
) -> tuple[float, float]:
    """The strapdown over the samples of a linear step, in place: (its length s, the same weighted
    with the extra noise); means: turn rate, specific force in the body and in north, east, down
    (3, 3), attitude (3, 3), and the increments of the sample before (2, 3).
    """
    felt, mean_c, last = means
    felt[:, :], mean_c[:, :] = 0.0, 0.0
    turn, push, mid = np.empty(3), np.empty(3), np.empty((3, 3))
    step, scale = 0.0, 0.0
    for j in range(part[0], part[1]):
        dt = imu.dt[j]
        for r in range(3):
            turn[r] = imu.dtheta[j, r] - bias[r] * dt
            push[r] = imu.dvel[j, r] - bias[3 + r] * dt
        copy_matrix(c, mid)
        strapdown.step((p, v, q, c), (turn, push), (last[0], last[1]), dt)
        copy(turn, last[0])
        copy(push, last[1])
        for r in range(3):
            felt[0, r] += turn[r]
            felt[1, r] += push[r]
            for s in range(3):
                mid[r, s] = 0.5 * (mid[r, s] + c[r, s])
                felt[2, r] += mid[r, s] * push[s]
                mean_c[r, s] += mid[r, s]
        step += dt
        scale += imu.extra_noise[j] * dt
    for r in range(3):
        for s in range(3):
            mean_c[r, s] /= part[1] - part[0]
            felt[r, s] /= step
    return step, scale


def joined(legs: list[Leg], bias: Array, sub: int) -> dict[str, Array]:
    """The legs of a path one after the other, as the arrays of a problem; an interval that leads
    from one into the next is empty.
    """
    sizes = [leg.node.size for leg in legs]
    first = np.concatenate([[0], np.cumsum(sizes)])
    out = Pieces.zeros(first[-1] - 1, len(columns.IMU))
    gap, counts = np.ones(first[-1] - 1), np.ones(first[-1] - 1, np.int64)
    begins = np.zeros(first[-1], bool)
    begins[first[:-1]] = True
    node_fix: list[Array] = []
    node_end: list[Array] = []
    speed = []
    bias = np.asarray(bias, float)
    for leg, begin, size in zip(legs, first, sizes):
        part, stretch = slice(begin, begin + size - 1), leg.stretch
        nominal = leg.at(leg.node)
        imu = Imu(stretch.dt, stretch.dtheta, stretch.dvel, stretch.extra_noise)
        piece = Pieces(*(store[part] for store in out))
        intervals(leg.node, nominal, imu, bias, leg.drifts, sub, piece)
        gap[part], counts[part] = np.diff(stretch.time[leg.node]), np.diff(leg.node)
        node_fix.append(leg.fixes.start + np.searchsorted(leg.epochs, leg.node, "left"))
        node_end.append(leg.fixes.start + np.searchsorted(leg.epochs, leg.node, "right"))
        speed.append(np.linalg.norm(nominal.velocity, axis=1))
    unique, kind = np.unique(counts, return_inverse=True)
    return out._asdict() | {
        "gap": gap, "counts": unique, "kind": kind, "begins": begins, "bias": bias,
        "node_fix": np.concatenate(node_fix), "node_end": np.concatenate(node_end),
        "node_speed": np.concatenate(speed),
    }  # fmt: skip
