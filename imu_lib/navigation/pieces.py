"""The filter's covariance between its three pieces and one matrix, and the transition that the
smoother needs, compiled.

Arrays are copied by loops: an assignment of one array to another takes Numba seconds to compile,
for the error that it would raise where shapes differ.
"""

import numpy as np
from numba import njit


@njit(cache=True)
def zero(v):
    for i in range(v.size):
        v[i] = 0.0


@njit(cache=True)
def add(total, v):
    for i in range(v.size):
        total[i] += v[i]


@njit(cache=True)
def copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


@njit(cache=True)
def copy_matrix(source, target):
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@njit(cache=True)
def unpack(p, pieces):
    """One matrix into the three pieces."""
    nn, ns, ss = pieces.nn, pieces.ns, pieces.ss
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
def pack(pieces, p):
    """The three pieces into one matrix."""
    nn, ns, ss = pieces.nn, pieces.ns, pieces.ss
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
def accumulate(phi, a, d, weight, sensors):
    """phi becomes the transition of this interval times phi."""
    first, s = sensors.first, sensors.transition
    n = phi.shape[0]
    new = np.zeros((n, n))
    for i in range(9):
        for k in range(9):
            for j in range(n):
                new[i, j] += a[i, k] * phi[k, j]
    for ch in range(7):
        for k in range(first[ch], first[ch + 1]):
            if ch < 6:
                for i in range(9):
                    for j in range(n):
                        new[i, j] += d[i, ch] * weight[k] * phi[9 + k, j]
            for i in range(first[ch], first[ch + 1]):
                if s[i, k] != 0.0:
                    for j in range(n):
                        new[9 + i, j] += s[i, k] * phi[9 + k, j]
    for i in range(n):
        copy(new[i], phi[i])
