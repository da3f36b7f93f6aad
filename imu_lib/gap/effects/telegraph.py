"""Burst noise: a bias that jumps between two levels."""
from __future__ import annotations

import numpy as np
from numba import njit

from imu_lib.processes import Telegraph as Process

from .base import Effect


@njit(cache=True, nogil=True)
def _posterior(y, a, flip, var):
    """Probability of the upper level and log-likelihood against pure noise of y = a (s - 1/2) + N(0, var)."""
    n = len(y)
    alpha = np.empty(n)
    ll = 0.0
    p = 0.5
    for k in range(n):
        q = p * (1 - flip) + (1 - p) * flip
        odds = a * y[k] / var                              # log of upper to lower, relative to the likelier one: no overflow
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


class Telegraph(Effect):
    name = "telegraph"
    cause = "A single trap or contact switches between two states at random (burst or popcorn noise)."
    domain = "distribution"
    process = Process

    def decode(self, x, fs, start: Process, density: float, drift_gain=None, *, rounds: int = 12):
        """Two levels by expectation maximisation: (process, signal of shape (n,), expected flips, log evidence of the
        path, samples per step), or None.

        `density` is N^2 of the white noise; `drift_gain(size)` is the Wiener gain of the base model's own drift on a
        real transform of `size` points at the decimated rate, or None.
        """
        # a step is a small part of a dwell, and no longer than it takes to see on which level the signal is
        seen = 2.0 * density * fs / start.amplitude**2
        q = int(max(1, min(round(fs / (12 * start.rate)), seen, len(x) // 64)))
        k = len(x) // q
        y = x[:k * q].reshape(k, q).mean(axis=1)
        y = y - 0.5 * (np.quantile(y, 0.1) + np.quantile(y, 0.9))
        var = density * fs / q
        a, rate, middle = start.amplitude, start.rate, 0.0
        drift = np.zeros(k)
        s = None
        for _ in range(rounds):
            if not (np.isfinite(a) and a > 0):
                return None
            flip = 0.5 * -np.expm1(-2 * rate * q / fs)
            s, ll, flips = _posterior(y - drift - middle, a, flip, var)
            w = s - 0.5
            rest = y - drift
            # two levels by weighted means
            up, down = np.sum(s), np.sum(1 - s)
            if min(up, down) < 2:
                return None
            high, low = np.sum(s * rest) / up, np.sum((1 - s) * rest) / down
            # soft states shrink the means: solve for the levels with the states' own variance
            v = np.mean(s * (1 - s))
            a = abs(np.mean((w - w.mean()) * (rest - rest.mean())) / max(np.var(s) + v, 1e-12)) if v > 0.02 else abs(high - low)
            middle = 0.5 * (high + low)
            rate = float(np.clip(-0.5 * np.log1p(-2 * min(flips / (k - 1), 0.45)) * fs / q, 2.0 * fs / len(x), fs / q / 4))
            if drift_gain is not None:
                e = y - a * w
                e = e - e.mean()
                pad = np.concatenate([e, e[::-1]])
                drift = np.fft.irfft(np.fft.rfft(pad) * drift_gain(2 * k, fs / q), 2 * k)[:k]
        # the evidence of the path: what summing over all paths gives beyond taking out their mean
        s, ll, flips = _posterior(y - drift - middle, a, 0.5 * -np.expm1(-2 * rate * q / fs), var)
        w = s - 0.5
        path = ll - np.sum(a * (y - drift - middle) * w - 0.5 * (a * w) ** 2) / var
        signal = np.repeat(a * w, q)
        signal = np.concatenate([signal, np.full(len(x) - len(signal), signal[-1])])
        return Process(amplitude=float(a), rate=rate), signal, float(flips), float(path), q
