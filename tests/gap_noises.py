"""Noises of synthetic records, by closed forms of their own: spectra, realisations, and the
log-likelihood that something hidden in them gains. Plain numpy, nothing of imu_lib.
"""

from __future__ import annotations

import numpy as np


def spectrum(entry, f, fs):
    kind = entry["process"]
    w = 2 * np.sin(np.pi * f / fs) * fs
    if kind == "white_noise":
        return np.full(f.shape, 2 * entry["N"] ** 2)
    if kind == "random_walk":
        return 2 * entry["K"] ** 2 / w**2
    if kind == "quantization":
        return 2 * entry["Q"] ** 2 * w**2 / fs
    if kind == "flicker":
        return entry["B"] ** 2 / (np.pi * f)
    if kind == "gauss_markov":
        a = np.exp(-1 / (fs * entry["correlation_time"]))
        return (
            2
            * entry["sigma"] ** 2
            * (1 - a * a)
            / fs
            / np.abs(1 - a * np.exp(-2j * np.pi * f / fs)) ** 2
        )
    if kind == "gauss_markov_2":
        b = 2.146193220620583 / entry["correlation_time"]
        return 8 * entry["sigma"] ** 2 * b**3 / (w**2 + b * b) ** 2
    if kind == "telegraph":
        tc = 0.5 / entry["rate"]
        return spectrum(
            {"process": "gauss_markov", "sigma": entry["amplitude"] / 2, "correlation_time": tc},
            f,
            fs,
        )
    if kind == "autoregressive":
        z = np.exp(-2j * np.pi * f / fs)
        den = 1 - sum(p * z ** (i + 1) for i, p in enumerate(entry["phi"]))
        return 2 * entry["sigma"] ** 2 / fs / np.abs(den) ** 2
    raise KeyError(kind)


def noise(entry, n, fs, rng):
    """A realisation, by filtering step by step or through the spectrum of a record twice as long."""
    kind = entry["process"]
    w = rng.standard_normal(n)
    if kind == "white_noise":
        return entry["N"] * np.sqrt(fs) * w
    if kind == "random_walk":
        return np.cumsum(w) * entry["K"] / np.sqrt(fs)
    if kind == "quantization":
        u = rng.uniform(-0.5, 0.5, n + 1) * np.sqrt(12) * entry["Q"]
        return np.diff(u) * fs
    if kind == "telegraph":
        flips = np.cumsum(rng.random(n) < -np.expm1(-entry["rate"] / fs)) + rng.integers(2)
        return entry["amplitude"] * (flips % 2 - 0.5)
    m = 2 * n
    f = np.arange(1, m // 2 + 1) * fs / m
    z = (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))) * np.sqrt(
        spectrum(entry, f, fs) * m * fs / 4
    )
    return np.fft.irfft(np.concatenate([[0], z]), m)[:n]


def base_psd(entries, f, fs):
    return sum(spectrum(e, f, fs) for e in entries if e["process"] != "constant")


def gain_spectral(s0, s1):
    r = s1 / s0
    return float(np.sum(r - np.log1p(r)))


def gain_drift(d, base, fs):
    """Half the squared signal-to-noise ratio of a drift, from differenced block means and their
    dense covariance.
    """
    m = max(1, len(d) // 450)
    k = len(d) // m
    f = (
        (np.arange(4096 * 16) + 0.5) / (4096 * 16) * fs / 2 / np.sqrt(m)
    )  # beyond this the blocks see nothing
    f = f if m > 1 else f * np.sqrt(m)
    y = np.diff(d[: k * m].reshape(k, m).mean(axis=1))
    h = (
        (np.sin(np.pi * f * m / fs) / (m * np.sin(np.pi * f / fs))) ** 2
        * 4
        * np.sin(np.pi * f * m / fs) ** 2
    )
    density = base_psd(base, f, fs) * h * (f[1] - f[0])
    step = np.exp(2j * np.pi * f * m / fs)
    turn, c = np.ones_like(step), np.empty(k - 1)
    for j in range(k - 1):
        c[j] = np.sum(density * turn.real)
        turn = turn * step
    lag = np.abs(np.subtract.outer(np.arange(k - 1), np.arange(k - 1)))
    return float(0.5 * y @ np.linalg.solve(c[lag], y))


def gain_line(d, s0, fs):
    return float(np.sum(np.abs(np.fft.rfft(d))[1:] ** 2 * 2 / (fs * len(d)) / s0))


def strength(gain_of, target):
    """The strength at which `gain_of` reaches the target (it grows with strength)."""
    low, high = 1e-12, 1e9
    for _ in range(80):
        mid = np.sqrt(low * high)
        low, high = (low, mid) if gain_of(mid) > target else (mid, high)
    return np.sqrt(low * high)
