"""Windows that are among the loudest of several channels at once: by ranks alone, whatever the
tails of the noise are.
"""

from __future__ import annotations

from math import comb

import numpy as np
from scipy.special import gammainccinv

#: Chance alarms allowed in a record, on several channels together.
TOGETHER = 1e-4
#: The same where none of them stands out, in each of some ten searches, channels and windows at the
#: least.
FAINT, LEAST, FEWEST = 1e-5, 3, 100
#: Share of the windows that are a channel's tail, and of those that are as loud as one in which it
#: is said to have felt a faint knock.
TAIL, WITNESS = 0.03, 0.02
#: Share of the windows that tell how loud channels are together by chance.
OFTEN = 0.01
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
    """Channels, by windows, that share a knock of which none stands out: together they are louder
    than chance makes channels that tell nothing of one another, shape (k, windows).

    The loudest counts as the second does: what one channel shows alone is no witness.
    """
    k, count = power.shape
    out = np.zeros((k, count), bool)
    own = apart(power[:, quiet])
    if len(own) < LEAST or quiet.sum() < FEWEST:
        return out
    odds = np.stack([rarity(power[c], quiet) for c in range(k)])
    two = np.sort(odds[own], axis=0)[-2:]
    total = odds[own].sum(axis=0) - (two[1] - two[0])
    # sums of exponentials, larger ones where channels are often loud together
    usual, limit = gammainccinv(len(own), np.array([OFTEN, FAINT / count]))
    found = quiet & (total > limit * max(1.0, np.quantile(total[quiet], 1 - OFTEN) / usual))
    out[:, found] = odds[:, found] > -np.log(WITNESS)
    return out


def rarity(power: np.ndarray, quiet: np.ndarray) -> np.ndarray:
    """-log of the share of windows as loud as each, shape (windows,): counted among the `quiet`
    ones, and in their upper tail that of the logarithm taken as exponential.
    """
    value = np.log(np.maximum(power, 1e-12))
    order = np.sort(value[quiet])
    share = (len(order) - np.searchsorted(order, value, side="left") + 0.5) / (len(order) + 1)
    low, high = np.quantile(order, (1 - TAIL, 1 - TAIL / 6))
    slope = max(float(high - low) / np.log(6.0), 1e-3)
    beyond = -np.log(TAIL) + (value - low) / slope
    return np.asarray(np.where(value > low, beyond, -np.log(np.minimum(share, 1.0))))


def apart(power: np.ndarray) -> list[int]:
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
