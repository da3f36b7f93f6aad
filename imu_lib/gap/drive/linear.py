"""The linear filter over the nodes of a condensed drive (`condense`), compiled: innovations, and
what each parameter does to them.

States are errors: 9 of navigation, then those of the sensors, then three Gauss-Markov errors of the
positions and of the velocities where there are some. Each sensor state belongs to one channel, and
the transition of the sensor states is nearly diagonal: products run over its blocks. The innermost
loops run along the rows of arrays, which is what a processor does several at a time.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.arrays import Array
from imu_lib.navigation.pieces import copy, copy_matrix

from .correction import judge, take
from .structures import Fixes, Out, Random, Room, Track

Rows = tuple[Array, Array, Array]
__all__ = ["Fixes", "Out", "Random", "Track", "innovations"]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def innovations(track: Track, random: Random, fixes: Fixes, count: int) -> Out:
    """The filter over the nodes: `Out`. count: parameters to carry, 0 or all."""
    m = random.weight.size
    n = 9 + m + random.of.size
    shape = fixes.y.shape
    out = Out(
        np.full(shape, np.nan),
        np.full(shape, np.nan),
        np.zeros((shape[0] if count else 1, 6, count)),
        np.zeros(shape[0], np.bool_),
        np.full(shape[0], np.inf),
    )
    room = Room(
        np.zeros(n), np.zeros((n, n)), np.zeros((n, count)), np.zeros((9, n)), np.zeros((6, n)),
        np.zeros((6, count)), np.zeros((m, n)), np.zeros((n, count)), np.zeros(n), np.zeros(n),
        np.zeros((9, 6)), np.zeros((15, 9)),
    )  # fmt: skip
    copy_matrix(random.sensors, room.p[9 : 9 + m, 9 : 9 + m])
    for i in range(9 + m, n):
        room.p[i, i] = random.sigma[random.of[i - 9 - m]] ** 2
    for node in range(track.begins.size):
        if track.begins[node]:
            _restart(room, random.start)
        else:
            _predict_covariance(room, track, random, node)
            _predict_states(room, track, random, node)
            if count:
                _predict_parameters(room, track, random, node)
        for fix in range(track.first[node], track.last[node]):
            if random.fraction > 0.0 and fixes.use[fix, 0]:
                judge(room, random, fixes, fix, out)
            take(room, random, fixes, fix, out)
    return out


@njit(cache=True, nogil=True)
def _restart(room: Room, start: Array) -> None:
    """All that is known of the motion is forgotten."""
    room.x[:9] = 0.0
    room.z[:9] = 0.0
    room.p[:9, :] = 0.0
    room.p[:, :9] = 0.0
    for i in range(9):
        room.p[i, i] = start[i]


@njit(cache=True, nogil=True, inline="always", fastmath={"reassoc", "contract"})
def _predict_covariance(room: Room, track: Track, random: Random, node: int) -> None:
    k, m = node - 1, random.weight.size
    s, walk = random.powers[track.kind[k]], random.walks[track.kind[k]]
    over = track.phi[k], track.gain[k], s
    _carry(room.p, over, random, (room.top, room.es, room.low))
    _navigation(room, track, random, node, s)
    p, low, first, last = room.p, room.low, random.first, random.last
    for a in range(m):
        for b in range(a + 1):
            v = walk[a, b]
            for r in range(first[b], last[b]):
                v += low[a, 9 + r] * s[b, r]
            p[9 + a, 9 + b] = v
            p[9 + b, 9 + a] = v
    if p.shape[0] > 9 + m:
        _predict_fix_errors(room, m, random, random.decay[k])


@njit(cache=True, nogil=True, inline="always", fastmath={"reassoc", "contract"})
def _carry(x: Array, over: tuple[Array, Array, Array], random: Random, into: Rows) -> None:
    """The transition times rows x (n, j) of the states: those of navigation and of the sensors, and
    the channels' errors in x.

    over: transition of navigation phi (9, 9), what errors of the channels do to it gain (9, 6), and
    transition of the sensor states (m, m)
    """
    phi, gain, s = over
    top, es, low = into
    m, width = random.weight.size, x.shape[1]
    channel, weight, first, last = random.channel, random.weight, random.first, random.last
    es[:, :] = 0.0
    for a in range(m):
        c, w = channel[a], weight[a]
        for j in range(width):
            es[c, j] += w * x[9 + a, j]
    for i in range(9):
        for j in range(width):
            top[i, j] = 0.0
        for r in range(9):
            v = phi[i, r]
            for j in range(width):
                top[i, j] += v * x[r, j]
        for c in range(6):
            v = gain[i, c]
            for j in range(width):
                top[i, j] += v * es[c, j]
    low[:, :] = 0.0
    for a in range(m):
        for b in range(first[a], last[a]):
            v = s[a, b]
            for j in range(width):
                low[a, j] += v * x[9 + b, j]


@njit(cache=True, nogil=True, inline="always", fastmath={"reassoc", "contract"})
def _navigation(room: Room, track: Track, random: Random, node: int, s: Array) -> None:
    """Covariance of navigation, with itself and with the sensor states, from room.top."""
    k, m, p, top = node - 1, random.weight.size, room.p, room.top
    by_channel, both, phi, gain = room.by_channel, room.both, track.phi[k], track.gain[k]
    first, last, noise = random.first, random.last, track.noise[k]
    channel, weight = random.channel, random.weight
    square = track.speed[node] ** 2
    by_channel[:, :] = 0.0
    for a in range(m):
        c, w = channel[a], weight[a]
        for i in range(9):
            by_channel[i, c] += w * top[i, 9 + a]
    for i in range(9):  # phi and gain, transposed
        for r in range(9):
            both[r, i] = phi[i, r]
        for c in range(6):
            both[9 + c, i] = gain[i, c]
    for i in range(9):
        for j in range(9):
            p[i, j] = 0.0
        for r in range(9):
            v = top[i, r]
            for j in range(9):
                p[i, j] += v * both[r, j]
        for c in range(6):
            v, white = by_channel[i, c], random.density[c] + random.per_speed[c] * square
            for j in range(9):
                p[i, j] += v * both[9 + c, j] + white * noise[c, i, j]
        for j in range(i):
            p[i, j] = p[j, i]
        for a in range(m):
            v = 0.0
            for b in range(first[a], last[a]):
                v += s[a, b] * top[i, 9 + b]
            p[i, 9 + a] = v
            p[9 + a, i] = v


@njit(cache=True, nogil=True)
def _predict_fix_errors(room: Room, m: int, random: Random, decay: Array) -> None:
    """Covariance of the Gauss-Markov errors of the fixes over an interval, after the other
    states'.
    """
    p, n = room.p, room.p.shape[0]
    for i in range(9 + m, n):
        of = random.of[i - 9 - m]
        own, sigma = decay[of], random.sigma[of]
        for r in range(9):
            p[r, i] = own * room.top[r, i]
            p[i, r] = p[r, i]
        for a in range(m):
            p[9 + a, i] = own * room.low[a, i]
            p[i, 9 + a] = p[9 + a, i]
        for j in range(9 + m, n):
            p[i, j] *= own * decay[random.of[j - 9 - m]]
        p[i, i] += sigma * sigma * (1.0 - own * own)


@njit(cache=True, nogil=True, inline="always", fastmath={"reassoc", "contract"})
def _predict_states(room: Room, track: Track, random: Random, node: int) -> None:
    """States over the interval that ends at a node."""
    k, x, new = node - 1, room.x, room.ph
    n, m = x.size, random.weight.size
    phi, gain = track.phi[k], track.gain[k]
    s, jump = random.powers[track.kind[k]], track.jump[k]
    channel, weight, first, last = random.channel, random.weight, random.first, random.last
    error = np.empty(6)  # of the channels
    for c in range(6):
        error[c] = -track.bias[c]
    for a in range(m):
        error[channel[a]] += weight[a] * x[9 + a]
    for i in range(9):
        v = -jump[i]
        for r in range(9):
            v += phi[i, r] * x[r]
        for c in range(6):
            v += gain[i, c] * error[c]
        new[i] = v
    for a in range(m):
        v = 0.0
        for b in range(first[a], last[a]):
            v += s[a, b] * x[9 + b]
        new[9 + a] = v
    for i in range(9 + m, n):
        new[i] = random.decay[k, random.of[i - 9 - m]] * x[i]
    copy(new, x)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _predict_parameters(room: Room, track: Track, random: Random, node: int) -> None:
    """What the parameters do to the states, over the interval that ends at a node."""
    k, z, zt = node - 1, room.z, room.zt
    m, count, force = random.weight.size, room.z.shape[1], track.force[k]
    over = track.phi[k], track.gain[k], random.powers[track.kind[k]]
    _carry(z, over, random, (zt[:9], room.zs, zt[9 : 9 + m]))
    for i in range(9):
        for j in range(min(force.shape[0], count)):
            zt[i, j] += force[j, i]
    for i in range(9 + m, z.shape[0]):
        for j in range(count):
            zt[i, j] = random.decay[k, random.of[i - 9 - m]] * z[i, j]
    copy_matrix(zt, z)
