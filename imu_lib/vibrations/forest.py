"""So many lines that each of its own would be no cause: the products of clocks that are no
multiples of each other, or of a clock and the steps of a converter.

They are as narrow as the record is long, so that they are found, and brought down to the level of
their neighbours, in the transform of the whole record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.likelihood.tapered import taper

#: Lines from which on it is a forest, and those that a finding lists.
MANY, LISTED = 40, 2000
#: Parts of the spectrum, and those that have to have lines.
PARTS, SPREAD = 64, 16
#: Ordinates in a block whose median tells the level, and ordinates on each side of a line that are
#: its own.
BLOCK, BESIDE = 256, 3
#: Ordinates without a line that tell the level of a block at the least; rounds at the most.
LEAST, ROUNDS = 16, 4
#: log10 of the probability, all ordinates taken together, of what stands out.
RARE = -2.0
#: Share of the lines that chance may make once it is a forest.
FALSE = 0.1
#: Share of the ordinates that lines may take: beyond it they are another spectrum.
MOST = 0.35


@dataclass(frozen=True)
class Forest:
    """Lines of several channels: `frequencies` in Hz, the strongest first, their `amplitude`
    (channels, lines), the `gain` of all of them, and the `ordinates` that they fill.
    """

    channels: tuple[str, ...]
    frequencies: np.ndarray
    amplitude: np.ndarray
    gain: float
    ordinates: np.ndarray
    count: int


def forest(channels: dict[str, Array], fs: float, *, least: float = 0.0) -> Forest | None:
    """The forest of lines in channels (name -> (n,), fast part) above `least` Hz, or None."""
    n = len(next(iter(channels.values())))
    first = int(np.ceil(least / fs * n))
    spectra = {name: np.abs(np.fft.rfft(taper(n) * x)) ** 2 for name, x in channels.items()}
    power = {name: p / level_of(p) for name, p in spectra.items()}
    dense = [
        name
        for name, p in power.items()
        if _is_dense(_lines(p, 1, first, 10**RARE / len(p)), len(p))
    ]
    if not dense:
        return None
    own, rare = np.zeros(n // 2 + 1, bool), 10**RARE / (n // 2 + 1)
    for _ in range(ROUNDS):  # the level is better known once the lines are
        # what is faint in each is seen in all of them together
        total = sum(spectra[name] / _level(spectra[name], ~own) for name in dense)
        lines = _lines(total, len(dense), first, rare)
        before, own = own, own | _around(lines, total, len(dense), first, rare)
        rare = FALSE * len(lines) / len(total)  # where so many are, a faint one is one, too
        if own.sum() <= 1.01 * before.sum():
            break
    if own.mean() > MOST:
        return None
    lines = lines[np.argsort(-total[lines])]
    size = [_amplitudes(channels[name], lines[:LISTED], ~own, fs) for name in dense]
    return Forest(
        tuple(dense),
        lines[:LISTED] * fs / n,
        np.array(size),
        float(np.sum((total[lines] - len(dense)).clip(0.0))),
        np.flatnonzero(own),
        len(lines),
    )


def _amplitudes(x: Array, lines: Array, free: Array, fs: float) -> np.ndarray:
    """Amplitudes of lines at the ordinates `lines`: one of amplitude a has n a^2 / (2 fs) over the
    density of the noise.
    """
    n, power = len(x), np.abs(np.fft.rfft(x)) ** 2
    excess = np.maximum(power - _level(power, free), 0.0)[lines]
    return 2.0 * np.sqrt(excess) / n


def _is_dense(lines: Array, ordinates: int) -> bool:
    """Whether lines are many, and all over the spectrum."""
    return len(lines) >= MANY and len(np.unique(lines * PARTS // ordinates)) >= SPREAD


def felled(x: Array, found: Forest, rng: np.random.Generator) -> np.ndarray:
    """A channel `x` (n,) with the ordinates of the forest at the level of their neighbours."""
    z = np.fft.rfft(x - np.mean(x))
    free = np.ones(len(z), bool)
    free[found.ordinates] = False
    level = _level(np.abs(z) ** 2, free)[found.ordinates]
    noise = rng.standard_normal((len(level), 2)) @ np.array([1.0, 1j])
    z[found.ordinates] = noise * np.sqrt(0.5 * level)
    return np.fft.irfft(z, len(x)) + np.mean(x)


def level_of(power: Array) -> np.ndarray:
    """Mean power of the noise around each ordinate, which lines do not lift."""
    return _level(power, np.ones(len(power), bool))


def _level(power: Array, free: Array) -> np.ndarray:
    """Mean power of the noise around each ordinate, from medians of blocks of those that are
    `free` of lines.
    """
    k = max(len(power) // BLOCK, 1)
    level, at = [], []
    for part in np.array_split(np.arange(len(power)), k):
        own = part[free[part]]
        if len(own) >= LEAST:
            level.append(np.median(power[own]) / np.log(2))
            at.append(part.mean())
    if not at:
        return np.full(len(power), max(np.median(power) / np.log(2), 1e-300))
    return np.exp(np.interp(np.arange(len(power)), at, np.log(np.maximum(level, 1e-300))))


def _lines(total: Array, count: int, first: int, rare: float) -> np.ndarray:
    """Ordinates that stand out of noise and of their neighbours, of the power of `count`
    channels.
    """
    limit = 0.5 * chi2.isf(rare, 2 * count)
    peak = (total[1:-1] > limit) & (total[1:-1] >= total[:-2]) & (total[1:-1] > total[2:])
    at = np.flatnonzero(peak) + 1
    return at[at >= max(first, 2)]


def _around(lines: Array, total: Array, count: int, first: int, rare: float) -> np.ndarray:
    """Whether lines fill an ordinate: those beside them, and what stands out between."""
    mask = np.zeros(len(total), bool)
    for k in range(-BESIDE, BESIDE + 1):
        mask[np.clip(lines + k, 0, len(total) - 1)] = True
    mask |= total > 0.5 * chi2.isf(rare, 2 * count)
    mask[: max(first, 1)] = False
    mask[-1] = False
    return mask
