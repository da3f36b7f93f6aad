"""Records of a sensor at rest, stranger than a textbook's: coloured, heavy-tailed, wandering, rounded
twice, shaken, 4 Hz to 1 kHz. Drawn by code that shares nothing with the package.
"""

from __future__ import annotations

import numpy as np
from scipy import signal

CHANNELS = tuple(f"{kind}_{axis}" for kind in ("gyro", "accel") for axis in "xyz")
G = 9.81


def noise(n, fs, rng, colour):
    """(n,) of standard deviation about 1."""
    w = rng.standard_normal(n + 500)
    if colour == "one_pole":
        p = np.exp(-2 * np.pi * rng.uniform(0.08, 0.3))
        w = signal.lfilter([np.sqrt(1 - p * p)], [1, -p], w)
    elif colour == "butterworth":
        sos = signal.butter(2, rng.uniform(0.2, 0.8), output="sos")
        w = signal.sosfilt(sos, w)
        w = w / w.std()
    elif colour == "tails":
        w = rng.standard_t(5, n + 500) * np.sqrt(3 / 5)
    elif colour == "differenced":
        w = np.diff(rng.standard_normal(n + 501)) / np.sqrt(2)
    return w[500:]


def pink(n, rng):
    """(n,) of 1/f noise, standard deviation 1: it has no time constant."""
    f = np.fft.rfftfreq(n)
    shape = np.zeros(len(f), complex)
    shape[1:] = (rng.standard_normal(len(f) - 1) + 1j * rng.standard_normal(len(f) - 1)) / np.sqrt(f[1:])  # fmt: skip
    y = np.fft.irfft(shape, n)
    return y / y.std()


def strange(x, t, fs, sd, rng):
    """What sensors and rooms do besides, added to x (n, 6); words on what it was."""
    n, words = len(x), []
    if rng.random() < 0.25:
        x += np.column_stack([pink(n, rng) for _ in range(6)]) * sd * rng.uniform(0.1, 0.7)
        words.append("flicker")
    if rng.random() < 0.15:  # a bias that jumps between two levels, on one or two channels
        for c in rng.choice(6, int(rng.integers(1, 3)), replace=False):
            flips = np.cumsum(rng.random(n) < 10 ** rng.uniform(-2.3, -0.3) / fs)
            x[:, c] += sd[c] * rng.uniform(0.3, 2.0) * (flips % 2)
        words.append("telegraph")
    if rng.random() < 0.2:  # the building sways
        f = rng.uniform(0.1, min(3.0, 0.3 * fs))
        swing = 1 + 0.8 * np.sin(2 * np.pi * t / rng.uniform(15, 90) + rng.uniform(0, 6))
        for c in rng.choice(6, 3, replace=False):
            x[:, c] += sd[c] * rng.uniform(0.1, 0.8) * swing * np.sin(2 * np.pi * f * t + c)
        words.append("sway")
    if rng.random() < 0.2:  # an air conditioner: bias after the room's temperature
        period = rng.uniform(100, 900)
        room = signal.sawtooth(2 * np.pi * t / period + rng.uniform(0, 6), rng.uniform(0.2, 0.8))
        x += room[:, None] * sd * rng.normal(0, 0.5, 6)
        words.append("room")
    if rng.random() < 0.15:  # one channel is another sensor's
        c = int(rng.integers(6))
        x[:, c] *= rng.choice([0.2, 5.0])
        sd[c] *= 1.0
        words.append("uneven")
    if rng.random() < 0.15:  # single wild samples on one channel
        c, rows = int(rng.integers(6)), rng.random(n) < 10 ** rng.uniform(-4.0, -3.0)
        x[rows, c] += sd[c] * rng.normal(0, 6, int(rows.sum()))
        words.append("wild")
    return words


def sound(seed, rng, *, rate=None, n=None):
    """A record at rest: x, rate, fast standard deviations, and words on what it is."""
    fs = rate or float(rng.choice([4, 10, 25, 50, 100, 100, 120, 200, 400, 1000]))
    n = n or int(np.clip(rng.uniform(120, 1800) * fs, 6000, 150_000))
    t = np.arange(n) / fs
    gyro, accel = 10 ** rng.uniform(-4, -2), 10 ** rng.uniform(-2.7, -1.2)
    sd = np.r_[gyro * rng.uniform(0.6, 1.6, 3), accel * rng.uniform(0.6, 1.6, 3)]
    colour = str(rng.choice(["white", "white", "one_pole", "butterworth", "tails", "differenced"]))
    words = [colour]
    x = np.column_stack([noise(n, fs, rng, colour) for _ in range(6)]) * sd
    if rng.random() < 0.3:  # a level that wanders
        step = max(1, int(fs))
        k = n // step + 3
        p = np.exp(-1 / rng.uniform(20, 200))
        slow = signal.lfilter([np.sqrt(1 - p * p)], [1, -p], rng.standard_normal((k, 6)), axis=0)
        level = np.exp(rng.uniform(0.1, 0.35) * slow)
        x *= np.column_stack([np.interp(t, np.arange(k), level[:, c]) for c in range(6)])
        words.append("level")
    if rng.random() < 0.6:  # slow errors
        tc = 10 ** rng.uniform(0.5, 3)
        p = np.exp(-1 / (fs * tc))
        drive = np.sqrt(1 - p * p) * rng.uniform(0.05, 0.6)
        slow = signal.lfilter([drive], [1, -p], rng.standard_normal((n, 6)), axis=0)
        x += slow * sd
        words.append("gauss_markov")
    if rng.random() < 0.4:
        x += np.cumsum(rng.standard_normal((n, 6)), axis=0) * sd * rng.uniform(0.1, 1) / n**0.75
        words.append("walk")
    if rng.random() < 0.35:  # a machine
        f = rng.uniform(0.05, 0.45) * fs
        phase = 2 * np.pi * np.cumsum(f + rng.normal(0, 0.002 * f, n)) / fs
        swing = 1 + 0.3 * np.sin(2 * np.pi * t / rng.uniform(20, 120))
        part = np.ones(n)
        if rng.random() < 0.5:
            a = rng.uniform(0, 0.5)
            part = ((t > a * t[-1]) & (t < (a + rng.uniform(0.2, 0.5)) * t[-1])).astype(float)
        for c in rng.choice(6, int(rng.integers(1, 5)), replace=False):
            x[:, c] += rng.uniform(0.3, 2.5) * sd[c] * swing * part * np.sin(phase + c)
        words.append("vibration")
    if rng.random() < 0.3:  # it warms
        x += (1 - np.exp(-t / rng.uniform(60, 900)))[:, None] * sd * rng.normal(0, 1.0, 6)
        words.append("warm")
    words += strange(x, t, fs, sd, np.random.default_rng([seed, 4]))
    roll, pitch = rng.normal(0, 0.3, 2)
    level = G * np.array(
        [np.sin(pitch), -np.sin(roll) * np.cos(pitch), -np.cos(roll) * np.cos(pitch)]
    )
    x[:, 3:] += level + rng.normal(0, 0.05, 3)
    x[:, :3] += rng.normal(0, 5 * gyro, 3)
    return x, fs, sd, words


def rounded(x, sd, rng):
    """As files have it: a fine or coarse grid, printed digits on top, single precision, or nothing."""
    how = str(rng.choice(["none", "none", "fine", "coarse", "digits", "twice", "single"]))
    lsb = sd * {"fine": 0.1, "coarse": rng.uniform(0.5, 1.3), "twice": 0.4}.get(how, 0.0)
    if how in ("fine", "coarse"):
        x = np.round(x / lsb) * lsb
    elif how == "digits":
        unit = 10 ** np.floor(np.log10(sd * 0.03))
        x = np.round(x / unit) * unit
    elif how == "twice":
        unit = 10 ** np.floor(np.log10(lsb * 0.05))
        x = np.round(np.round(x / lsb) * lsb / unit) * unit
    elif how == "single":
        x = x.astype(np.float32).astype(float)
    return x, how
