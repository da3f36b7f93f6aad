"""The filter's covariance over one interval, compiled: see `covariance` for the model.

The transition of the sensor states acts channel by channel, so that its zeros are never multiplied.
"""

from numba import njit


@njit(cache=True, fastmath=True)
def propagate(pieces, room, a, d, h, sensors):
    """One interval, in place on the three pieces of the covariance.

    pieces : structures.Pieces; room : structures.Room; a (9, 9), d (9, 6) of `fill_transition`
    h (m,) the states' weights in their channels' errors; sensors : structures.Sensors
    """
    _rows(pieces, room, a, d, h, sensors)
    _navigation(pieces, room, a, d)
    for i in range(9):  # vs = A ns + D es
        for k in range(6):
            x = 0.5 * d[i, k]
            for j in range(room.vs.shape[1]):
                room.vs[i, j] += x * room.es[k, j]
    _across(pieces, room, sensors)
    _sensors(pieces, room, sensors)


@njit(cache=True, fastmath=True, inline="always")
def _rows(pieces, room, a, d, h, sensors):
    """es = H ss, vs = A ns + D es / 2 and vh = vs H'."""
    ns, ss, first = pieces.ns, pieces.ss, sensors.first
    vs, es, vh = room.vs, room.es, room.vh
    m = ns.shape[1]
    for c in range(6):
        for j in range(m):
            es[c, j] = 0.0
        for k in range(first[c], first[c + 1]):
            x = h[k]
            for j in range(m):
                es[c, j] += x * ss[k, j]
    for i in range(9):
        for j in range(m):
            vs[i, j] = 0.0
        for k in range(9):
            x = a[i, k]
            for j in range(m):
                vs[i, j] += x * ns[k, j]
        for k in range(6):
            x = 0.5 * d[i, k]
            for j in range(m):
                vs[i, j] += x * es[k, j]
    for i in range(9):
        for c in range(6):
            x = 0.0
            for j in range(first[c], first[c + 1]):
                x += vs[i, j] * h[j]
            vh[i, c] = x


@njit(cache=True, fastmath=True, inline="always")
def _navigation(pieces, room, a, d):
    """nn = A nn A' + vh D' + D vh'."""
    nn, w9, vh = pieces.nn, room.w9, room.vh
    for i in range(9):  # w9 = A nn
        for j in range(9):
            w9[i, j] = 0.0
        for k in range(9):
            x = a[i, k]
            for j in range(9):
                w9[i, j] += x * nn[k, j]
    for i in range(9):
        for j in range(i + 1):
            x = 0.0
            for k in range(9):
                x += w9[i, k] * a[j, k]
            for k in range(6):
                x += vh[i, k] * d[j, k] + d[i, k] * vh[j, k]
            nn[i, j] = x
            nn[j, i] = x


@njit(cache=True, fastmath=True, inline="always")
def _across(pieces, room, sensors):
    """ns = vs S', ts = S ss, block by block; a static state stays as it is."""
    ns, ss, vs, ts = pieces.ns, pieces.ss, room.vs, room.ts
    first, static, s = sensors.first, sensors.static, sensors.transition
    m = ns.shape[1]
    for c in range(7):
        b0, b1, b2 = first[c], static[c], first[c + 1]
        if b1 - b0 == 1:
            x = s[b0, b0]
            for i in range(9):
                ns[i, b0] = vs[i, b0] * x
            for j in range(m):
                ts[b0, j] = ss[b0, j] * x
        else:
            for i in range(9):
                for j in range(b0, b1):
                    x = 0.0
                    for k in range(b0, b1):
                        x += vs[i, k] * s[j, k]
                    ns[i, j] = x
            for i in range(b0, b1):
                for j in range(m):
                    ts[i, j] = 0.0
                for k in range(b0, b1):
                    x = s[i, k]
                    if x != 0.0:
                        for j in range(m):
                            ts[i, j] += x * ss[k, j]
        if b2 > b1:
            for i in range(9):
                for j in range(b1, b2):
                    ns[i, j] = vs[i, j]
            for i in range(b1, b2):
                for j in range(m):
                    ts[i, j] = ss[i, j]


@njit(cache=True, fastmath=True, inline="always")
def _sensors(pieces, room, sensors):
    """ss = ts S' + q; between two static states nothing changes."""
    ss, ts = pieces.ss, room.ts
    first, static, s, q = sensors.first, sensors.static, sensors.transition, sensors.noise
    m = ss.shape[0]
    for c in range(7):
        b0, b1 = first[c], static[c]
        for j in range(b0, b1):
            for i in range(j, m):
                x = 0.0
                for k in range(b0, b1):
                    x += ts[i, k] * s[j, k]
                ss[i, j] = x
                ss[j, i] = x
            for e in range(c):  # static states of the blocks before
                for i in range(static[e], first[e + 1]):
                    ss[i, j] = ts[j, i]
                    ss[j, i] = ts[j, i]
        for i in range(b0, b1):
            for j in range(b0, b1):
                ss[i, j] += q[i, j]
