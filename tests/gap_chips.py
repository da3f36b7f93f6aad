"""Records whose noise no estimator assumes, drawn: power laws between flicker and walk, the filters
of real chips, grids; and in them what noise and its spectrum do. Nothing of `imu_lib`.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, cheby1, firwin, lfilter

RATES = (50.0, 100.0, 104.0, 125.0, 200.0, 208.0, 256.0)
#: Samples at the most, so that a record takes seconds to look at.
MOST = 24_000
#: What may be in a record, and the names that are right for it.
KINDS = {
    "nothing": (),
    "heavy_tails": ("heavy_tails",),
    "wandering_level": ("wandering_level",),
    "level_step": ("noise_level_change",),
    "level_growing": ("noise_level_change", "wandering_level"),
    "level_breathing": (),
    "sinusoid": ("sinusoid",),
    "line_in_growing_noise": ("sinusoid", "noise_level_change", "wandering_level"),
    "wandering_line": ("vibration",),
    "chirp": (),
    "notch": (),
    "resonance": ("autoregressive",),
    "telegraph": ("telegraph",),
    "gauss_markov": (),  # as the slow noise of every record
}
#: Names that are right for what every record has: a power law, and a filter where it has one.
SLOW = ("flicker", "random_walk", "gauss_markov", "white_noise")


def record(kind: str, seed: int):
    """(rate, samples (n,), names that are right) of a channel with an effect of that kind."""
    rng = np.random.default_rng([seed, 31, *kind.encode()])
    fs = float(rng.choice(RATES))
    n = int(min(rng.uniform(120.0, 420.0) * fs, MOST))
    t = np.arange(n) / fs
    numerator, denominator = chip(rng)
    right = [*KINDS[kind], *SLOW] + (["low_pass"] if len(numerator) + len(denominator) > 2 else [])
    w = rng.standard_normal(n)
    if kind == "heavy_tails":
        freedom = rng.uniform(3.5, 7.0)
        w = rng.standard_t(freedom, n) * np.sqrt((freedom - 2.0) / freedom)
    x = lfilter(numerator, denominator, w * level(kind, t, rng))
    if kind in ("notch", "resonance"):
        a, r = rng.uniform(0.1, 0.4) * 2 * np.pi, rng.uniform(0.75, 0.96)
        poles = [1.0, -2 * r * np.cos(a), r * r]
        if kind == "notch":
            x = lfilter([1.0, -2 * np.cos(a), 1.0], poles, x)
        else:
            x = x + 0.7 * lfilter([1.0], poles, rng.standard_normal(n))
    x = x + slow(n, fs, rng) + signal(kind, t, fs, rng)
    if rng.random() < 0.6:
        step = 10 ** rng.uniform(-1.0, 0.0)
        x = np.rint(x / step) * step
        right.append("resolution")
    return fs, 10 ** rng.uniform(-3.0, -2.0) * x, right


def chip(rng):
    """Numerator and denominator of what a chip does to its noise."""
    kind = int(rng.integers(6))
    if kind == 0:
        return [1.0], [1.0]
    if kind in (1, 2):  # a moving average; a decimator
        box = np.full(int(rng.integers(2, 5)), 1.0)
        box = box / box.sum()
        return (box if kind == 1 else np.convolve(np.convolve(box, box), box)), [1.0]
    if kind == 3:
        return butter(int(rng.integers(1, 4)), rng.uniform(0.3, 0.8))
    if kind == 4:
        return cheby1(int(rng.integers(2, 4)), rng.uniform(0.3, 1.0), rng.uniform(0.3, 0.7))
    return firwin(int(rng.integers(9, 25)), rng.uniform(0.4, 0.8)), [1.0]


def slow(n, fs, rng):
    """A power law that is as strong as the noise at some hundredths to tenths of a hertz."""
    exponent, corner = rng.uniform(0.7, 1.5), 10 ** rng.uniform(-2.0, -0.5)
    f = np.fft.rfftfreq(2 * n, 1 / fs)
    f[0] = f[1]
    z = rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))
    return np.fft.irfft(z * np.sqrt(n * (f / corner) ** -exponent), 2 * n)[:n]


def level(kind, t, rng):
    """The level of the noise through the record, shape (n,)."""
    n, whole = len(t), t[-1]
    if kind == "level_step":
        ratio = np.exp(rng.choice([-1, 1]) * rng.uniform(0.15, 0.7))
        return np.where(t > rng.uniform(0.2, 0.8) * whole, ratio, 1.0)
    if kind in ("level_growing", "line_in_growing_noise"):
        ratio = np.exp(rng.choice([-1, 1]) * rng.uniform(0.25, 0.9))
        a, b = np.sort(rng.uniform(0.0, 1.0, 2))
        a, b = (a, b) if b - a > 0.3 else (0.0, 1.0)
        u = np.clip((t / whole - a) / (b - a), 0.0, 1.0)
        shapes = (1 + (ratio - 1) * u, ratio**u, 1 + (ratio - 1) * 0.5 * (1 - np.cos(np.pi * u)))
        return shapes[int(rng.integers(3))]
    if kind == "level_breathing":
        phase = 2 * np.pi * t / (whole / rng.uniform(3.0, 20.0)) + rng.uniform(0, 6)
        return 1.0 + rng.uniform(0.2, 0.5) * np.sin(phase)
    if kind == "wandering_level":
        step = t[1]
        pole = np.exp(-step / rng.uniform(5.0, whole / 8))
        z = lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(2 * n))[n:]
        return np.exp(rng.uniform(0.15, 0.5) * z)
    return np.ones(n)


def signal(kind, t, fs, rng):
    """What else is in the channel, shape (n,), its noise before the filter having the variance
    one.
    """
    f, phase = rng.uniform(0.03, 0.4) * fs, rng.uniform(0, 2 * np.pi)
    if kind in ("sinusoid", "line_in_growing_noise"):
        return rng.uniform(0.08, 0.5) * np.sin(2 * np.pi * f * t + phase)
    if kind == "wandering_line":
        pole = np.exp(-1 / (5 * fs))
        off = lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(len(t)))
        turn = np.cumsum(f + rng.uniform(0.02, 0.15) * off) / fs
        return rng.uniform(0.3, 1.0) * np.sin(2 * np.pi * turn + phase)
    if kind == "chirp":
        last = f + rng.choice([-1, 1]) * rng.uniform(0.05, 0.2) * fs
        last = last if 0.02 * fs < last < 0.47 * fs else 2 * f - last
        turn = np.cumsum(np.linspace(f, last, len(t))) / fs
        return rng.uniform(0.5, 1.2) * np.sin(2 * np.pi * turn + phase)
    if kind == "telegraph":
        flips = np.cumsum(rng.random(len(t)) < rng.uniform(6 / t[-1], 0.3) / fs)
        return rng.uniform(0.25, 0.8) * (flips % 2)
    if kind == "gauss_markov":
        tau = 10 ** rng.uniform(-0.3, 1.2) * fs
        pole = np.exp(-1 / tau)
        z = lfilter([np.sqrt(1 - pole**2)], [1.0, -pole], rng.standard_normal(2 * len(t)))
        return rng.uniform(4.0, 12.0) / np.sqrt(tau) * z[len(t) :]
    return np.zeros(len(t))
