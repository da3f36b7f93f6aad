"""The linear filter over the nodes of a condensed drive (`condense`), compiled: innovations, and what
each parameter does to them.

States are errors: 9 of navigation, then those of the sensors, then three Gauss-Markov errors of the
positions where there are some. Each sensor state belongs to one channel, and the transition of the
sensor states is nearly diagonal: products run over what is not zero.
"""

from typing import NamedTuple

import numpy as np
from numba import njit


class Track(NamedTuple):
    """What `condense.intervals` made of the path, k nodes.

    begins (k,) bool: a stretch begins at the node; phi (k-1, 9, 9), gain (k-1, 9, 6), noise (k-1,
    6, 9, 9), force (k-1, columns, 9), jump (k-1, 9); kind (k-1,) which of `Random.powers` an
    interval takes; speed (k,) m/s; bias (6,) taken off the readings; first, last (k,) rows of the
    fixes at the node: from, to before.
    """

    begins: np.ndarray
    phi: np.ndarray
    gain: np.ndarray
    noise: np.ndarray
    force: np.ndarray
    jump: np.ndarray
    kind: np.ndarray
    speed: np.ndarray
    bias: np.ndarray
    first: np.ndarray
    last: np.ndarray


class Random(NamedTuple):
    """A hypothesis about noise.

    start (9,), sensors (m, m): variance and covariance at the begin of a stretch; powers, walks (u,
    m, m): transition and noise of the sensor states over an interval; channel (m,) of each state,
    and its weight (m,) there; density, per_speed (6,): white noise N^2 and its growth with speed^2;
    decay (k-1,), sigma m: of the positions' Gauss-Markov errors; fraction, scale m: of wild
    positions.
    """

    start: np.ndarray
    sensors: np.ndarray
    powers: np.ndarray
    walks: np.ndarray
    channel: np.ndarray
    weight: np.ndarray
    density: np.ndarray
    per_speed: np.ndarray
    decay: np.ndarray
    sigma: float
    fraction: float
    scale: float


class Fixes(NamedTuple):
    """y (f, 6) predicted minus measured; arm (f, 3, 3) rows of the attitude error; variance, use (f,
    6); columns (f, 6, P): what a parameter does to y beyond what it does to the path.
    """

    y: np.ndarray
    arm: np.ndarray
    variance: np.ndarray
    use: np.ndarray
    columns: np.ndarray


class Out(NamedTuple):
    """e (f, 6) whitened, s (f, 6) variance of the innovations, jac (f, 6, P) whitened (empty where not
    asked for), wild (f,) bool, doubt (f,) nats by which one of wild and tame is likelier (infinite
    where no fix can be wild).
    """

    e: np.ndarray
    s: np.ndarray
    jac: np.ndarray
    wild: np.ndarray
    doubt: np.ndarray


class _Room(NamedTuple):
    """States x (n,), covariance p (n, n), what parameters do to them z (n, P); top (9, n), es (6, n),
    zs (6, P), low (m, n), zt (n, P), d (9, 6), ph (n,): room to work in.
    """

    x: np.ndarray
    p: np.ndarray
    z: np.ndarray
    top: np.ndarray
    es: np.ndarray
    zs: np.ndarray
    low: np.ndarray
    zt: np.ndarray
    ph: np.ndarray


@njit(cache=True, nogil=True)
def innovations(track, random, fixes, sens):
    """The filter over the nodes: `Out`. sens: whether to carry the parameters."""
    count, m = fixes.columns.shape[2], random.weight.size
    n = 9 + m + (3 if random.sigma > 0.0 else 0)
    shape = fixes.y.shape
    out = Out(
        np.full(shape, np.nan),
        np.full(shape, np.nan),
        np.zeros((shape[0], 6, count)) if sens else np.zeros((1, 6, 0)),
        np.zeros(shape[0], np.bool_),
        np.full(shape[0], np.inf),
    )
    width = count if sens else 0
    room = _Room(
        np.zeros(n), np.zeros((n, n)), np.zeros((n, width)), np.zeros((9, n)), np.zeros((6, n)),
        np.zeros((6, width)), np.zeros((m, n)), np.zeros((n, width)), np.zeros(n),
    )  # fmt: skip
    room.p[9 : 9 + m, 9 : 9 + m] = random.sensors
    for i in range(9 + m, n):
        room.p[i, i] = random.sigma * random.sigma
    for node in range(track.begins.size):
        if track.begins[node]:
            _restart(room, random.start)
        else:
            _predict_covariance(room, track, random, node)
            _predict_states(room, track, random, node)
        for fix in range(track.first[node], track.last[node]):
            if random.fraction > 0.0 and fixes.use[fix, 0]:
                _judge(room, random, fixes, fix, out)
            _take(room, random, fixes, fix, out)
    return out


@njit(cache=True, nogil=True)
def _restart(room, start):
    """All that is known of the motion is forgotten."""
    room.x[:9] = 0.0
    room.z[:9] = 0.0
    room.p[:9, :] = 0.0
    room.p[:, :9] = 0.0
    for i in range(9):
        room.p[i, i] = start[i]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _predict_covariance(room, track, random, node):
    k, p, top, es, low = node - 1, room.p, room.top, room.es, room.low
    n, m = p.shape[0], random.weight.size
    phi, gain = track.phi[k], track.gain[k]
    s, walk = random.powers[track.kind[k]], random.walks[track.kind[k]]
    es[:, :] = 0.0
    for a in range(m):
        c, w = random.channel[a], random.weight[a]
        for j in range(n):
            es[c, j] += w * p[9 + a, j]
    for i in range(9):  # top = phi p + gain es
        for j in range(n):
            top[i, j] = 0.0
        for r in range(9):
            v = phi[i, r]
            for j in range(n):
                top[i, j] += v * p[r, j]
        for c in range(6):
            v = gain[i, c]
            for j in range(n):
                top[i, j] += v * es[c, j]
    low[:, :] = 0.0
    for a in range(m):  # low = S p, of the sensor states
        for b in range(m):
            v = s[a, b]
            if v != 0.0:
                for j in range(n):
                    low[a, j] += v * p[9 + b, j]
    for i in range(9):
        for j in range(i + 1):
            v = 0.0
            for r in range(9):
                v += top[i, r] * phi[j, r]
            for a in range(m):
                v += top[i, 9 + a] * random.weight[a] * gain[j, random.channel[a]]
            for c in range(6):
                level = random.density[c] + random.per_speed[c] * track.speed[node] ** 2
                v += level * track.noise[k, c, i, j]
            p[i, j] = v
            p[j, i] = v
        for a in range(m):
            v = 0.0
            for b in range(m):
                if s[a, b] != 0.0:
                    v += s[a, b] * top[i, 9 + b]
            p[i, 9 + a] = v
            p[9 + a, i] = v
    for a in range(m):
        for b in range(a + 1):
            v = walk[a, b]
            for r in range(m):
                if s[b, r] != 0.0:
                    v += low[a, 9 + r] * s[b, r]
            p[9 + a, 9 + b] = v
            p[9 + b, 9 + a] = v
    if n > 9 + m:
        _predict_fix_errors(room, m, random.decay[k], random.sigma)


@njit(cache=True, nogil=True)
def _predict_fix_errors(room, m, decay, sigma):
    """Covariance of the positions' Gauss-Markov errors over an interval, after the other states'."""
    p, n = room.p, room.p.shape[0]
    for i in range(9 + m, n):
        for r in range(9):
            p[r, i] = decay * room.top[r, i]
            p[i, r] = p[r, i]
        for a in range(m):
            p[9 + a, i] = decay * room.low[a, i]
            p[i, 9 + a] = p[9 + a, i]
        for j in range(9 + m, n):
            p[i, j] *= decay * decay
        p[i, i] += sigma * sigma * (1.0 - decay * decay)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _predict_states(room, track, random, node):
    """States, and what the parameters do to them, over the interval that ends at a node."""
    k, x, z, zs, zt = node - 1, room.x, room.z, room.zs, room.zt
    n, m, count = x.size, random.weight.size, room.z.shape[1]
    phi, gain, force = track.phi[k], track.gain[k], track.force[k]
    s = random.powers[track.kind[k]]
    imu = force.shape[0]
    error = -track.bias  # of the six channels
    zs[:, :] = 0.0
    for a in range(m):
        c, w = random.channel[a], random.weight[a]
        error[c] += w * x[9 + a]
        for j in range(count):
            zs[c, j] += w * z[9 + a, j]
    room.ph[:] = 0.0
    zt[:, :] = 0.0
    for i in range(9):
        v = -track.jump[k, i]
        for r in range(9):
            v += phi[i, r] * x[r]
            for j in range(count):
                zt[i, j] += phi[i, r] * z[r, j]
        for c in range(6):
            v += gain[i, c] * error[c]
            for j in range(count):
                zt[i, j] += gain[i, c] * zs[c, j]
        for j in range(min(imu, count)):
            zt[i, j] += force[j, i]
        room.ph[i] = v
    for a in range(m):
        for b in range(m):
            v = s[a, b]
            if v != 0.0:
                room.ph[9 + a] += v * x[9 + b]
                for j in range(count):
                    zt[9 + a, j] += v * z[9 + b, j]
    for i in range(9 + m, n):
        room.ph[i] = random.decay[k] * x[i]
        for j in range(count):
            zt[i, j] = random.decay[k] * z[i, j]
    x[:] = room.ph
    z[:, :] = zt


@njit(cache=True, nogil=True, inline="always")
def _project(p, arm, i, tail, ph):
    """P h into ph (n,) for number i of a fix, arm (3,) being its row; h' P h is returned."""
    for j in range(ph.size):
        ph[j] = p[i, j]
    if i < 3:
        for r in range(3):
            if arm[r] != 0.0:
                for j in range(ph.size):
                    ph[j] += arm[r] * p[6 + r, j]
        if tail < ph.size:
            for j in range(ph.size):
                ph[j] += p[tail + i, j]
    return _along(ph, arm, i, tail)


@njit(cache=True, nogil=True, inline="always")
def _along(x, arm, i, tail):
    """h' x for number i of a fix."""
    v = x[i]
    if i < 3:
        v += arm[0] * x[6] + arm[1] * x[7] + arm[2] * x[8]
        if tail < x.size:
            v += x[tail + i]
    return v


@njit(cache=True, nogil=True)
def _judge(room, random, fixes, fix, out):
    """A position is taken for wild where that is likelier."""
    tail = 9 + random.weight.size
    tame, other = np.log(1.0 - random.fraction), np.log(random.fraction)
    for i in range(3):
        arm = fixes.arm[fix, i]
        var = fixes.variance[fix, i] + _project(room.p, arm, i, tail, room.ph)
        apart = (fixes.y[fix, i] - _along(room.x, arm, i, tail)) ** 2
        more = var + random.scale * random.scale
        tame -= 0.5 * (apart / var + np.log(var))
        other -= 0.5 * (apart / more + np.log(more))
    out.wild[fix] = other > tame
    out.doubt[fix] = np.abs(other - tame)


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _take(room, random, fixes, fix, out):
    """The numbers of a fix, one after the other: innovations, and the corrections."""
    x, p, z, ph = room.x, room.p, room.z, room.ph
    n, tail, count = x.size, 9 + random.weight.size, z.shape[1]
    for i in range(6):
        if not fixes.use[fix, i]:
            continue
        arm = fixes.arm[fix, i % 3]
        var = fixes.variance[fix, i] + _project(p, arm, i, tail, ph)
        if i < 3 and out.wild[fix]:
            var += random.scale * random.scale
        root = np.sqrt(var)
        residual = fixes.y[fix, i] - _along(x, arm, i, tail)
        out.e[fix, i], out.s[fix, i] = residual / root, var
        if count:
            _take_parameters(z, ph, fixes.columns[fix, i], arm, (i, tail), var, out.jac[fix, i])
        for a in range(n):
            v = ph[a] / var
            x[a] += v * residual
            for b in range(n):
                p[a, b] -= v * ph[b]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _take_parameters(z, ph, column, arm, place, var, row):
    """What the parameters do to an innovation, into row (P,), and to the states after it."""
    i, tail = place
    n, count = z.shape
    for j in range(count):
        row[j] = column[j] + z[i, j]
    if i < 3:
        for r in range(3):
            if arm[r] != 0.0:
                for j in range(count):
                    row[j] += arm[r] * z[6 + r, j]
        if tail < n:
            for j in range(count):
                row[j] += z[tail + i, j]
    for a in range(n):
        v = ph[a] / var
        for j in range(count):
            z[a, j] -= v * row[j]
    root = np.sqrt(var)
    for j in range(count):
        row[j] /= root
