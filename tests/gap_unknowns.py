"""Effects that the catalogue of `imu_lib.gap` does not have, for the blind tests: plain numpy."""

from __future__ import annotations

import numpy as np

UNKNOWN = (
    "modulated_noise",
    "chirp",
    "heavy_tails",
    "bursts",
    "fading_tone",
    "bent",
    "missing_codes",
    "square_wave",
    "delayed_coupling",
    "clicks",
)


def unknown(effect, x, fs, rng, white):
    """The samples `x`, shape (n,), with `effect` at a random strength; `white` is the standard
    deviation of their white noise.
    """
    n, mean = len(x), x.mean()
    t = np.arange(n) / fs
    T = n / fs
    if effect == "modulated_noise":
        depth, period = rng.uniform(0.2, 0.6), T / rng.uniform(3, 40)
        return mean + (x - mean) * (1 + depth * np.sin(2 * np.pi * t / period + rng.uniform(0, 6)))
    if effect == "chirp":
        f0, f1 = rng.uniform(1, 0.2 * fs), rng.uniform(0.25 * fs, 0.45 * fs)
        return x + white * rng.uniform(0.3, 1) * np.sin(
            2 * np.pi * (f0 * t + (f1 - f0) * t * t / (2 * T))
        )
    if effect == "heavy_tails":
        return x + white * rng.standard_t(3, n) * rng.uniform(0.5, 1)
    if effect == "bursts":
        period, width = rng.uniform(20, 120), rng.uniform(0.5, 5)
        return x + white * rng.uniform(0.7, 2) * rng.standard_normal(n) * ((t % period) < width)
    if effect == "fading_tone":
        return x + white * rng.uniform(0.2, 0.6) * np.sin(
            2 * np.pi * rng.uniform(2, 0.45 * fs) * t
        ) * np.sin(np.pi * t / T * rng.integers(2, 9))
    if effect == "bent":
        u = (x - mean) / x.std()
        return x + x.std() * rng.uniform(0.08, 0.25) * (u * u - 1)
    if effect == "missing_codes":
        lsb = white * rng.uniform(0.2, 0.5)
        k = np.round(x / lsb)
        return np.where(k % 8 == 3, k + 1, k) * lsb
    if effect == "square_wave":
        return x + white * rng.uniform(0.2, 0.6) * np.sign(
            np.sin(2 * np.pi * rng.uniform(0.5, 4) * t)
        )
    if effect == "delayed_coupling":
        return x + np.roll(x - mean, int(fs * rng.uniform(0.05, 0.5))) * rng.uniform(0.1, 0.4)
    return x + (rng.random(n) < 1 / (fs * rng.uniform(1, 10))) * white * rng.uniform(
        5, 9
    )  # clicks: one sign, one height
