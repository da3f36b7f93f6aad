"""Noise that channels share in a part of the spectrum only: where their coherence stands out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.processes import Vibration
from imu_lib.timing import folded

#: Segments of the record, ordinates of each, and bands that the spectrum is divided into.
LENGTH, BANDS = 256, 32
#: log10 of the probability of a band's coherence by chance from which on it stands out.
RARE = -6.0
#: Coherence over that of the rest of the spectrum from which on it is a band of its own.
ABOVE, SKIRT = 3.0, 1.5
#: First band in which shared noise that ends further up is no noise shared before filters.
LOWEST = 3
#: Share of the spectrum beyond which shared noise is white, and coherence outside of a band over
#: that inside, where it stands out alone and where it does so of what is shared everywhere.
BROAD, OUTSIDE, ABOVE_OUTSIDE = 0.7, 0.15, 0.3


@dataclass(frozen=True)
class Band:
    """Shared noise from `low` to `high` Hz: amplitude by channel, mean squared coherence, gain."""

    low: float
    high: float
    amplitude: dict[str, float]
    coherence: float
    gain: float
    #: Where it stands out at all; `low` to `high` is where it has half of its power or more.
    reach: tuple[float, float]


def bands(channels: dict[str, Array], fs: float, known: Sequence[Vibration] = ()) -> list[Band]:
    """Bands in which some channels (name -> (n,), fast part) share noise; lines and bands of the
    `known` vibrations are left out.
    """
    names = list(channels)
    n = len(next(iter(channels.values())))
    length = min(LENGTH, 2 ** int(np.log2(max(n // 40, 8))))
    if len(names) < 2 or length < 32:
        return []
    spectra = np.array([_segments(channels[name], length) for name in names])
    keep = _free(length, fs, known)
    edge = np.unique(np.linspace(2, length // 2, BANDS + 1).astype(int))
    products, counts = [], []
    for a, b in zip(edge[:-1], edge[1:]):
        z = spectra[:, :, a:b][:, :, keep[a:b]].reshape(len(names), -1)
        counts.append(z.shape[1] / 1.7)  # segments and ordinates of a window overlap
        products.append(z @ z.conj().T / max(z.shape[1], 1))
    cross, count = np.array(products), np.array(counts)
    level = np.maximum(np.einsum("bii->bi", cross).real, 1e-30)
    square = np.abs(cross) ** 2 / (level[:, :, None] * level[:, None, :])
    return _found(names, cross, level, square, count, edge * fs / length, fs / length)


def _found(
    names: list[str],
    cross: Array,
    level: Array,
    square: Array,
    count: Array,
    edge: Array,
    step: float,
) -> list[Band]:
    best = None
    for i, j in combinations(range(len(names)), 2):
        stands = chi2.logsf(2 * count * square[:, i, j], 2) / np.log(10) < RARE
        broad = stands.mean() > BROAD
        if broad:  # a band above what is shared everywhere
            stands &= square[:, i, j] > ABOVE * np.quantile(square[:, i, j], 0.3)
        if not stands.any() or stands.mean() > BROAD:
            continue
        a, b = _run(square[:, i, j], stands)
        if (
            a < LOWEST or broad and b == len(stands)
        ):  # what moves slowly, or all of what filters let through
            continue
        inside = np.zeros(len(stands), bool)
        inside[a:b] = True
        free = ~inside & (count > 0)
        if b - a < 2 or free.sum() < 4:
            continue
        excess = np.maximum(square[:, i, j] - 1 / np.maximum(count, 1), 0.0)
        outside = max(np.median(excess[free]), np.mean(excess[:LOWEST]))
        if outside > (ABOVE_OUTSIDE if broad else OUTSIDE) * np.median(excess[a:b]):
            continue
        gain = float(np.sum(-count[a:b] * np.log1p(-np.minimum(square[a:b, i, j], 0.999))))
        if best is None or gain > best[0]:
            best = (gain, a, b, i, j)
    if best is None:
        return []
    gain, a, b, i, j = best
    members = {i, j}
    for k in range(len(names)):
        if k not in members:
            joint = max(float(np.sum(2 * count[a:b] * square[a:b, k, m])) for m in members)
            if chi2.logsf(joint, 2 * (b - a)) / np.log(10) < RARE:
                members.add(k)
    amplitude = {}
    beside = [k for k in (a - 3, a - 2, b + 1, b + 2) if 0 <= k < len(level)]
    together = sorted(members)
    for k in together:
        others = [m for m in together if m != k]
        shared = max(float(np.mean(np.sqrt(square[a:b, k, m]))) for m in others)
        rise = np.mean(level[a:b, k]) - (np.median(level[beside, k]) if beside else np.inf)
        part = max(shared * float(np.mean(level[a:b, k])), float(rise))
        amplitude[names[k]] = float(np.sqrt(2 * part * (edge[b] - edge[a]) / step))
    mean = float(np.mean(square[a:b, i, j]))
    height = np.abs(cross[a:b, i, j])
    half = np.flatnonzero(height > 0.5 * np.median(np.sort(height)[-max(2, (b - a) // 2) :]))
    low, high = edge[a + half[0]], edge[a + half[-1] + 1]
    return [
        Band(float(low), float(high), amplitude, mean, gain, _reach(square[:, i, j], a, b, edge))
    ]


def _reach(value: Array, a: int, b: int, edge: Array) -> tuple[float, float]:
    """Where the coherence comes down to that of the rest of the spectrum on both sides, Hz."""
    floor = SKIRT * np.quantile(value, 0.3)
    while a > LOWEST and value[a - 1] > floor:
        a -= 1
    while b < len(value) - 1 and value[b] > floor:
        b += 1
    return float(edge[a]), float(edge[b])


def _segments(x: Array, length: int) -> Array:
    """Spectra of half-overlapping segments, scaled so that their mean square is the variance of an
    ordinate, shape (segments, length / 2).
    """
    window = np.sin(np.pi * (np.arange(length) + 0.5) / length)
    parts = np.lib.stride_tricks.sliding_window_view(x, length)[:: length // 2]
    z = np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window, axis=1)
    return z[:, : length // 2] * (2.0 / length)


def _free(length: int, fs: float, known: Sequence[Vibration]) -> Array:
    """Ordinates that no known vibration reaches, shape (length / 2,)."""
    f = np.arange(length // 2) * fs / length
    out = np.ones(len(f), bool)
    for process in known:
        for line in process.frequencies:
            # at a multiple it wanders by as many times its width
            width = process.bandwidth * max(line / process.frequency, 1.0)
            out &= np.abs(f - folded(line, fs)) > 1.5 * fs / length + width
    return out


def _run(value: Array, stands: Array) -> tuple[int, int]:
    """First and one behind the last of the longest run that stands out, holes of one allowed."""
    closed = stands.copy()
    closed[1:-1] |= stands[:-2] & stands[2:]
    step = np.diff(np.concatenate([[0], closed.astype(np.int8), [0]]))
    start, stop = np.flatnonzero(step == 1), np.flatnonzero(step == -1)
    best = int(np.argmax([value[a:b].sum() for a, b in zip(start, stop)]))
    return int(start[best]), int(stop[best])
