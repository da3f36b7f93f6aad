"""Records as sensors give them, drawn: coloured fast noise, coarse grids, a shared vibration, heavy
tails, slow wandering, at 4 Hz to 1 kHz and from two minutes to twelve hours. Nothing of `imu_lib`.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

#: Samples at the most, so that a record takes a minute and not an hour to look at.
MOST = 60_000
RATES = (4.16, 10.0, 25.0, 40.0, 100.0, 120.0, 200.0, 250.0, 1000.0)


def record(seed: int, *, six: bool = False):
    """(rate, channels {name: (n,)}) of a sensor that nobody has seen."""
    rng = np.random.default_rng([seed, 29])
    fs = float(rng.choice(RATES))
    seconds = 10 ** rng.uniform(np.log10(120), np.log10(43_200))
    n = int(np.clip(seconds * fs, 6_000, MOST))
    kinds = [f"{k}_{a}" for k in ("gyro", "accel") for a in "xyz"]
    names = kinds if six else [kinds[k] for k in sorted(rng.choice(6, 3, replace=False))]
    colour, tails, steps = _colour(rng), rng.random() < 0.3, rng.random() < 0.5
    channels = {}
    for name in names:
        sd = 10 ** rng.uniform(-3.2, -2.2) * (8.0 if name.startswith("accel") else 1.0)
        x = sd * _fast(n, rng, colour, tails) + sd * _slow(n, rng)
        x = x + (-9.81 if name == "accel_z" else rng.normal(0, 0.02))
        channels[name] = (x, sd)
    if rng.random() < 0.4:
        _shake(channels, fs, rng)
    out = {}
    for name, (x, sd) in channels.items():
        step = sd * 10 ** rng.uniform(-1.2, 0.1) if steps else sd * 1e-3
        out[name] = np.rint(x / step) * step
    return fs, out


def _colour(rng):
    """Numerator and denominator of what the electronics do to the noise of all channels."""
    kind = int(rng.integers(4))
    if kind == 0:
        return [1.0], [1.0]
    if kind == 1:
        taps = int(rng.integers(2, 6))
        return np.full(taps, 1 / np.sqrt(taps)), [1.0]
    if kind == 2:
        a = rng.uniform(0.2, 0.7)
        return [np.sqrt(1 - a * a)], [1.0, -a]
    r, w = rng.uniform(0.5, 0.85), rng.uniform(0.15, 0.8) * np.pi
    return [1.0], [1.0, -2 * r * np.cos(w), r * r]


def _fast(n, rng, colour, tails):
    w = rng.standard_normal(n)
    if tails:
        freedom = rng.uniform(4, 9)
        w = rng.standard_t(freedom, n) * np.sqrt((freedom - 2) / freedom)
    x = lfilter(*colour, w)
    return x / np.std(x)


def _slow(n, rng):
    """A Gauss-Markov process and a walk, faint over one sample, plain over many."""
    tau = n / 10 ** rng.uniform(0.7, 2.5)
    pole = np.exp(-1 / tau)
    x = lfilter([np.sqrt(1 - pole**2)], [1, -pole], rng.standard_normal(2 * n))[n:]
    walk = np.cumsum(rng.standard_normal(n)) / np.sqrt(n)
    size = rng.uniform(0, 6, 2) / np.sqrt(tau), rng.uniform(0, 8) / np.sqrt(n)
    return size[0][0] * x + size[1] * walk


def _shake(channels, fs, rng):
    names = list(channels)
    n = len(channels[names[0]][0])
    t, f = np.arange(n) / fs, rng.uniform(0.1, 0.4) * fs
    phase = np.cumsum(rng.normal(0, 2e-3, n)) + 2 * np.pi * f * t
    for name in names[: int(rng.integers(2, len(names) + 1))]:
        x, sd = channels[name]
        size = sd * rng.uniform(10, 40) / np.sqrt(n)
        channels[name] = (x + size * np.sin(phase + rng.uniform(0, 6)), sd)
