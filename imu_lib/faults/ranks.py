"""Windows that are among the loudest of several channels at once: by ranks alone, whatever the
tails of the noise are.
"""

from __future__ import annotations

from math import comb

import numpy as np

#: Chance alarms allowed in a record, on several channels together.
TOGETHER = 1e-4
#: The same where none of them stands out, in each of some ten searches, and channels at the least.
FAINT, LEAST = 1e-6, 3
#: Correlation of the energies of two channels over the record from which on one is no witness of
#: what the other shows.
ALIKE = 0.2


def together(power: np.ndarray, stands: np.ndarray, quiet: np.ndarray) -> np.ndarray:
    """Windows in which several channels are among their own loudest at once, shape (windows,).

    By ranks alone, whatever the tails of the noise are: of m channels out of k, independent, the
    probability that all are among their u loudest is at most C(k, m) u^m. Ranks are those among the
    windows not found otherwise (`quiet`).
    """
    k, count = power.shape
    at = np.flatnonzero((stands.sum(axis=0) >= 2) & quiet)
    out = np.zeros(count, bool)
    if not len(at):
        return out
    u = _ranks(power, at, quiet)
    u = np.where(stands[:, at], u, 1.0)
    u.sort(axis=0)
    p = np.min([comb(k, m) * u[m - 1] ** m for m in range(2, k + 1)], axis=0)
    out[at] = p * count < TOGETHER
    return out


def with_others(power: np.ndarray, stands: np.ndarray, quiet: np.ndarray) -> np.ndarray:
    """Channels, by windows, that share a weak knock: one stands out alone, and others are among
    their own loudest at that time, shape (k, windows).

    Of the k - 1 others, independent of it, the probability that m are among their u loudest is at
    most C(k - 1, m) u^m, in each of the windows in which one stands out.
    """
    k, count = power.shape
    out = np.zeros((k, count), bool)
    at = np.flatnonzero((stands.sum(axis=0) == 1) & quiet)
    if k < 3 or not len(at):
        return out
    u = _ranks(power, at, quiet)
    u[stands[:, at]] = 2.0  # it is no witness of its own
    alike = np.corrcoef(np.log(np.maximum(power[:, quiet], 1e-12))) > ALIKE
    for j, window in enumerate(at):
        # what is loud together all the time, as in a vibration, tells the same twice
        u[alike[stands[:, window]].any(axis=0) & ~stands[:, window], j] = 1.0
        order = np.sort(u[:, j])[: k - 1]
        p = [comb(k - 1, m) * order[m - 1] ** m for m in range(2, k)]
        best = int(np.argmin(p))
        if p[best] * len(at) < TOGETHER:
            out[:, window] = stands[:, window] | (u[:, j] <= order[best + 1])
    return out


def faint(power: np.ndarray, quiet: np.ndarray) -> np.ndarray:
    """Channels, by windows, that share a knock of which none stands out: so many of them, that tell
    nothing of one another otherwise, are among their own loudest, shape (k, windows).
    """
    k, count = power.shape
    out = np.zeros((k, count), bool)
    own = _apart(power[:, quiet])
    if len(own) < LEAST or not quiet.any():
        return out
    at = np.flatnonzero(quiet)
    u = _ranks(power, at, quiet)
    order = np.sort(u[own], axis=0)
    sizes = range(LEAST, len(own) + 1)
    p = np.array([comb(len(own), m) * order[m - 1] ** m for m in sizes])
    found = p.min(axis=0) * count < FAINT
    most = order[np.argmin(p, axis=0) + LEAST - 1, np.arange(len(at))]
    out[:, at] = found & (u <= most)
    return out


def _apart(power: np.ndarray) -> list[int]:
    """Channels whose energies have nothing to do with one another."""
    alike = np.corrcoef(np.log(np.maximum(power, 1e-12))) > ALIKE
    own: list[int] = []
    for c in range(len(power)):
        if not alike[c, own].any():
            own.append(c)
    return own


def _ranks(power: np.ndarray, at: np.ndarray, quiet: np.ndarray) -> np.ndarray:
    """Share of the `quiet` windows of each channel that are at least as loud as those `at`."""
    u = np.ones((len(power), len(at)))
    for c, y in enumerate(power):
        order = np.sort(y[quiet])
        u[c] = (len(order) - np.searchsorted(order, y[at], side="left")) / len(order)
    return u
