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
    low, high, p_low, p_high = y[0] + a / 2, y[0] - a / 2, 1e6 * var, 1e6 * var
    log_low, log_high = np.log(0.5), np.log(0.5)
    stays, turns = np.log(1 - flip), np.log(flip)
    for k in range(n):
        to_low, to_high = y[k] + 0.5 * a, y[k] - 0.5 * a
        # the filters of both levels before, each gone on to either level now
        ll, m_ll, p_ll = _gone_on(log_low + stays, low, p_low + walk, to_low, var)
        lh, m_lh, p_lh = _gone_on(log_low + turns, low, p_low + walk, to_high, var)
        hl, m_hl, p_hl = _gone_on(log_high + turns, high, p_high + walk, to_low, var)
        hh, m_hh, p_hh = _gone_on(log_high + stays, high, p_high + walk, to_high, var)
        log_low, low, p_low = _merged(ll, m_ll, p_ll, hl, m_hl, p_hl)
        log_high, high, p_high = _merged(lh, m_lh, p_lh, hh, m_hh, p_hh)
        top = max(log_low, log_high)
        # no level is ever given up for good
        log_low, log_high = max(log_low - top, -690.0), max(log_high - top, -690.0)
        out[k] = log_high - log_low
    return out


@njit(cache=True, nogil=True)
def _gone_on(
    log_weight: float, mean: float, spread: float, reading: float, var: float
) -> tuple[float, float, float]:
    """Log weight, mean and variance of a walk after a `reading` of it with noise of `var`."""
    total, off = spread + var, reading - mean
    log_weight -= 0.5 * (np.log(total) + off * off / total)
    return log_weight, mean + spread / total * off, spread * var / total


@njit(cache=True, nogil=True)
def _merged(
    log_a: float, a: float, p_a: float, log_b: float, b: float, p_b: float
) -> tuple[float, float, float]:
    """Log weight, mean and variance of two normal distributions of such log weights as one."""
    top = max(log_a, log_b)
    share_a, share_b = np.exp(log_a - top), np.exp(log_b - top)
    total = share_a + share_b
    share_a, share_b = share_a / total, share_b / total
    mean = share_a * a + share_b * b
    spread = share_a * (p_a + (a - mean) ** 2) + share_b * (p_b + (b - mean) ** 2)
    return top + np.log(total), mean, spread
