"""A vibration as the record has it: the power that was taken out of its channels, the shape of its
spectrum and the bursts in which it comes, from the channels before and after.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import Vibration
from imu_lib.vibrations.band_removal import segment_length
from imu_lib.vibrations.behaviour import BURSTS, block_power, half_in

#: Points of a profile, and density over the largest that is none: what was not taken out.
POINTS, FAINT = 32, 1e-3
#: Segments from which on the shape of a spectrum is more than chance.
SEGMENTS = 16
#: Share of the power of a band that is left aside at either end, samples of the band in a block,
#: blocks at the least, and the standard deviation of the logarithm of its amplitude, and the size
#: of that over chance, from which on a band comes in bursts.
MARGIN, SAMPLES, BLOCKS, LITTLE, CHANCE = 0.05, 3, 24, 0.15, 4.0
#: Standard deviation of the logarithm of an amplitude at the most: rarer bursts are events.
MOST = 1.2


def measured(
    p: Vibration, before: dict[str, Array], after: dict[str, Array], fs: float
) -> Vibration:
    """The vibration `p` with the amplitudes, the profile and the bursts that its channels tell:
    name -> (n,) before it was taken out, and after.

    A steady line stays what it is: its amplitude was fitted in a band as narrow as itself. So does
    a family of lines, whose power is not the same share of each on all channels.
    """
    if p.forest:
        return _of_power(p, before, after)
    if p.bandwidth <= 0 or p.harmonics > 1:
        return p
    n = len(next(iter(before.values())))
    on = slice(int((p.start or 0.0) * fs), n if p.stop is None else int(p.stop * fs))
    spectra = {c: _Excess(before[c][on], after[c][on], p.bandwidth, fs) for c in p.channels}
    power = {c: s.power for c, s in spectra.items()}
    if min(power.values()) <= 0:
        return p
    p = p.with_(amplitude=tuple(float(np.sqrt(2 * power[c])) for c in p.channels))
    shape: Array = np.sum([s.density / power[c] for c, s in spectra.items()], axis=0)
    some = next(iter(spectra.values()))
    p = p.with_(**_profile(some.f, shape)) if some.segments >= SEGMENTS else p
    if p.band and p.start is None:
        best = max(spectra.values(), key=lambda s: s.strength)
        p = p.with_(**best.bursts(fs))
    return p


def _of_power(p: Vibration, before: dict[str, Array], after: dict[str, Array]) -> Vibration:
    """A forest of lines with the power of all of them, those too that are not listed."""
    listed = 0.5 * float(np.sum(p.shape**2))
    power = [max(float(np.var(before[c]) - np.var(after[c])), 0.0) / listed for c in p.channels]
    return p.with_(
        amplitude=tuple(float(np.sqrt(v)) or a for v, a in zip(power, p.amplitude, strict=True))
    )


class _Excess:
    """Density by which a channel `x` (n,) was louder than it is `calm`, one-sided, at `f` Hz."""

    def __init__(self, x: Array, calm: Array, width: float, fs: float):
        self.x, self.calm = x, calm
        m = min(segment_length(len(x), fs, width), len(x))
        window = np.sin(np.pi * (np.arange(m) + 0.5) / m)
        self.f = np.arange(m // 2 + 1) * fs / m
        loud, quiet = (_power(v, window) for v in (x, calm))
        self.density = (loud - quiet) * 2.0 / (fs * np.sum(window**2))
        self.density[0] = 0.0
        self.segments = 2 * len(x) // m - 1
        self.power = float(np.sum(self.density) * self.f[1])
        self.strength = float(np.max(loud / np.maximum(quiet, 1e-300)))

    def bursts(self, fs: float) -> dict[str, Any]:
        """Fields of a band whose amplitude wanders."""
        density = np.maximum(self.density, 0.0)
        share = np.cumsum(density) / max(float(density.sum()), 1e-300)
        low, high = np.interp([MARGIN, 1.0 - MARGIN], share, self.f)
        # samples of the band that are independent of each other, a second
        width = float(np.sum(density) ** 2 / np.sum(density**2) * self.f[1])
        size = int(np.ceil(SAMPLES * fs / width))
        count = len(self.x) // size
        if count < BLOCKS:
            return {}
        loud, quiet = (block_power(v, fs, low, high, size) for v in (self.x, self.calm))
        excess = loud - quiet
        mean = float(excess.mean())
        chance = float(np.mean(loud**2 + quiet**2)) / (SAMPLES + 1)
        varies = float(np.var(excess)) - chance
        # of the scatter of so many blocks by chance
        if mean <= 0 or varies < CHANCE * chance * np.sqrt(2.0 / count):
            return {}
        sd = min(0.5 * np.sqrt(np.log1p(varies / mean**2)), MOST)
        if sd < LITTLE:
            return {}
        z = excess - mean
        lagged = np.correlate(z, z, "full")[count - 1 :] / count
        below = np.flatnonzero(lagged[1:] < np.exp(-1.0) * varies)
        lag = (int(below[0]) if len(below) else count) + 0.5
        return {"wander": round(float(sd), 4), "wander_time": round(float(lag * size / fs), 4)}


def _power(x: Array, window: Array) -> np.ndarray:
    """Mean power of half-overlapping segments, shape (ordinates,)."""
    m = len(window)
    parts = np.lib.stride_tricks.sliding_window_view(x, m)[:: max(m // 2, 1)]
    total, step = np.zeros(m // 2 + 1), max(1, 2**22 // m)
    for i in range(0, len(parts), step):
        part = parts[i : i + step]
        z = np.fft.rfft((part - part.mean(axis=1, keepdims=True)) * window, axis=1)
        total += np.sum(z.real**2 + z.imag**2, axis=0)
    return np.asarray(total / len(parts))


def _profile(f: Array, density: Array) -> dict[str, Any]:
    """Fields of a vibration of this density (ordinates,): its means over classes, half of which
    are even in frequency and half in power, so that they are narrow where it is high.
    """
    there = np.flatnonzero(np.abs(density) > FAINT * np.max(density))
    if len(there) < 6:
        return {}
    a, b = int(there[0]), int(there[-1]) + 1
    share = np.cumsum(np.maximum(density[a:b], 0.0))
    even = np.linspace(a, b, POINTS // 2)
    of_power = a + np.interp(np.linspace(0, share[-1], POINTS // 2), share, np.arange(b - a))
    edge = np.unique(np.rint(np.r_[even, of_power]).astype(int))
    middle = [f[i:j].mean() for i, j in zip(edge[:-1], edge[1:])]
    value = [max(float(density[i:j].mean()), 0.0) for i, j in zip(edge[:-1], edge[1:])]
    at = [f[a] - 0.5 * f[1], *middle, f[b - 1] + 0.5 * f[1]]
    return {
        "profile_frequency": tuple(round(float(v), 6) for v in at),
        "profile": (0.0, *(round(v / max(value), 4) for v in value), 0.0),
    }


def in_bursts(p: Vibration, quick: dict[str, Array], fs: float) -> str:
    """Words for a wide band whose power comes in bursts, as of steps on a floor."""
    if not p.band or p.start is not None:
        return ""
    name = max(p.channels, key=lambda c: loudness(p, c, quick))
    half = p.bandwidth / 2
    share = half_in(quick[name], fs, p.frequency - half, p.frequency + half)
    return f"in bursts, half of it in {100 * share:.2g} % of the time" if share < BURSTS else ""


def loudness(p: Vibration, channel: str, quick: dict[str, Array]) -> float:
    """Amplitude over the scatter of the channel."""
    return p.amplitude[p.channels.index(channel)] / float(np.std(quick[channel]))
