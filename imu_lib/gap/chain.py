"""A hidden chain of two levels: how likely each is in every sample, and paths over them."""

from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.arrays import Array


@njit(cache=True, nogil=True)
def posterior(y: Array, a: float, flip: float, var: float) -> tuple[Array, float, float]:
    """Probability of the upper level and log-likelihood against pure noise of y = a (s - 1/2) +
    N(0, var).
    """
    n = len(y)
    alpha = np.empty(n)
    ll = 0.0
    p = 0.5
    for k in range(n):
        q = p * (1 - flip) + (1 - p) * flip
        odds = a * y[k] / var  # log of upper to lower, relative to the likelier one: no overflow
        up, down = (1.0, np.exp(-odds)) if odds > 0 else (np.exp(odds), 1.0)
        total = q * up + (1 - q) * down
        ll += np.log(total) + 0.5 * abs(odds) - a * a / (8 * var)
        p = q * up / total
        alpha[k] = p
    out = np.empty(n)
    out[n - 1] = alpha[n - 1]
    flips = 0.0
    for k in range(n - 2, -1, -1):
        forward = alpha[k] * (1 - flip) + (1 - alpha[k]) * flip
        stay_up = alpha[k] * (1 - flip) / max(forward, 1e-300)
        up_to_down = alpha[k] * flip / max(1 - forward, 1e-300)
        out[k] = out[k + 1] * stay_up + (1 - out[k + 1]) * up_to_down
        flips += (1 - out[k + 1]) * up_to_down + out[k + 1] * (1 - stay_up)
    return out, ll, flips


@njit(cache=True, nogil=True)
def path(y: Array, a: float, flip: float, var: float, chance: Array) -> Array:
    """One path over the two levels, 1 and 0, out of those that `y` leaves open, by as many numbers
    of `chance` between 0 and 1 (forward filtering, backward sampling: Chib 1996).
    """
    n = len(y)
    odds, out = np.empty(n), np.empty(n)
    p = 0.5
    for k in range(n):
        q = p * (1 - flip) + (1 - p) * flip
        odds[k] = np.log(q) - np.log1p(-q) + a * y[k] / var
        p = min(max(1 / (1 + np.exp(-odds[k])), 1e-15), 1 - 1e-15)
    stays = np.log((1 - flip) / flip)
    for k in range(n - 1, -1, -1):
        after = 0.0 if k == n - 1 else stays * (2 * out[k + 1] - 1)
        out[k] = 1.0 if chance[k] < 1 / (1 + np.exp(-odds[k] - after)) else 0.0
    return out


@njit(cache=True, nogil=True)
def followed(y: Array, a: float, flip: float, var: float, walk: float) -> Array:
    """Log odds of the upper level after each of y = a (s - 1/2) + w + N(0, var), beside a random
    walk w of variance `walk` a step: a Kalman filter for each level, each from both levels before
    (generalised pseudo-Bayesian of second order, Bar-Shalom, Li and Kirubarajan 2001, sec. 11.6.4).
    """
    n = len(y)
    out = np.empty(n)
    weight, mean, spread = np.full(2, 0.5), np.empty(2), np.full(2, 1e6 * var)
    mean[0], mean[1] = y[0] + a / 2, y[0] - a / 2
    chance = np.empty((2, 2))
    to, error = np.empty((2, 2)), np.empty((2, 2))
    for k in range(n):
        for i in range(2):
            for j in range(2):
                before = spread[i] + walk
                total = before + var
                off = y[k] - (j - 0.5) * a - mean[i]
                stays = 1 - flip if i == j else flip
                chance[i, j] = np.log(weight[i] * stays) - 0.5 * (np.log(total) + off**2 / total)
                to[i, j] = mean[i] + before / total * off
                error[i, j] = before * var / total
        chance = np.exp(chance - chance.max())
        chance /= chance.sum()
        for j in range(2):
            share = chance[:, j] + 1e-300
            share = share / share.sum()
            mean[j] = np.sum(share * to[:, j])
            spread[j] = np.sum(share * (error[:, j] + (to[:, j] - mean[j]) ** 2))
            weight[j] = max(chance[0, j] + chance[1, j], 1e-300)
        out[k] = np.log(weight[1] / weight[0])
    return out
