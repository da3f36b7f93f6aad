"""How far the skirts of a line that wanders reach: a strong one is above its surroundings long
after its own band has ended.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter

from imu_lib.arrays import Array
from imu_lib.likelihood.tapered import taper
from imu_lib.vibrations.band_removal import segment_length

#: Ordinates in a band, widths of the band that a skirt may reach on each side, and widths beyond
#: that tell the level.
ORDINATES, REACH, BESIDE = 8, 3.0, 1.5
#: Power over the level down to which it is a skirt, or that over chance in standard deviations.
LEAST, CHANCE = 1.08, 3.0
#: Ordinates of the record on each side of a line that are its own; those of the segments that are
#: spared there; those of the record whose median tells the level around it; and the logarithm of
#: the probability, all ordinates of the skirt taken together, from which on it is a line.
BESIDE_LINE, SPARED, AROUND, STANDS_OUT = 6, 3, 257, 12.0


def widened(
    x: Array,
    fs: float,
    bands: Sequence[tuple[float, float]],
    *,
    start: float = 0.0,
    stop: float | None = None,
) -> list[tuple[float, float]]:
    """Bands (low, high) in Hz of a channel `x` (n,) with the skirts of each, as there are between
    `start` and `stop` s; a line that stands in a skirt has another cause, and is left where it is.
    """
    part = x[int(start * fs) : None if stop is None else int(stop * fs)]
    step, out = fs / len(part), []
    power = np.abs(np.fft.rfft(taper(len(part)) * (part - np.mean(part)))) ** 2
    for low, high in bands:
        wide = _widened(part, fs, low, high)
        # as far as the segments in which the band is taken out tell them apart
        spared = SPARED * fs / segment_length(len(x), fs, wide[1] - wide[0])
        out += _around(_lines(power, step, (wide[0], low), (high, wide[1])), wide, spared)
    return out


def _lines(power: Array, step: float, *skirts: tuple[float, float]) -> list[float]:
    """Frequencies in Hz that stand out of the skirts (low, high) of a band, of the `power` at
    ordinates `step` Hz apart.
    """
    found: list[float] = []
    for low, high in skirts:
        a, b = int(np.ceil(low / step)) + BESIDE_LINE, int(high / step) - BESIDE_LINE
        if b - a < 8 * BESIDE_LINE:
            continue
        level = median_filter(power[a:b], min(AROUND, b - a), mode="nearest") / np.log(2)
        over = power[a:b] / np.maximum(level, 1e-300)
        at = np.flatnonzero(over > np.log(b - a) + STANDS_OUT)
        found += [float((a + k) * step) for k in at]
    return found


def _around(
    lines: list[float], band: tuple[float, float], spared: float
) -> list[tuple[float, float]]:
    """What is left of a band without `spared` Hz on either side of the lines in it."""
    low, high = band
    out = []
    for f in sorted(lines):
        if f - spared > low:
            out.append((low, f - spared))
        low = max(low, f + spared)
    return [*out, (low, high)] if high > low else out


def _widened(x: Array, fs: float, low: float, high: float) -> tuple[float, float]:
    width = high - low
    m = int(2 ** np.round(np.log2(max(ORDINATES * fs / width, 32))))
    if len(x) < 16 * m:
        return low, high
    window = np.sin(np.pi * (np.arange(m) + 0.5) / m)
    part = np.lib.stride_tricks.sliding_window_view(x, m)[:: m // 2]
    power = np.mean(np.abs(np.fft.rfft((part - part.mean(axis=1)[:, None]) * window)) ** 2, axis=0)
    f = np.arange(len(power)) * fs / m
    level = _level(f, power, low, high, fs)
    if level is None:
        return low, high
    # neighbours under the window go together
    ratio = np.convolve(power / level, [0.25, 0.5, 0.25], "same")
    floor = max(LEAST, 1.0 + CHANCE / np.sqrt(2.0 * len(part)))
    a, b = np.searchsorted(f, [low, high])
    first, last = np.searchsorted(f, [low - REACH * width, high + REACH * width])
    while a > max(first, 2) and ratio[a - 1] > floor:
        a -= 1
    while b < min(last, len(f) - 2) and ratio[b] > floor:
        b += 1
    return min(low, float(f[a])), max(high, float(f[b]))


def _level(f: Array, power: Array, low: float, high: float, fs: float) -> Array | None:
    """The level under the band: a straight line in the logarithm between what lies beyond the
    skirts; None where one side is missing.
    """
    width, at, value = high - low, [], []
    for a, b in (
        (low - (REACH + BESIDE) * width, low - REACH * width),
        (high + REACH * width, high + (REACH + BESIDE) * width),
    ):
        inside = (f >= max(a, 2 * f[1])) & (f <= min(b, 0.48 * fs))
        if inside.sum() < 3:
            return None
        at.append(f[inside].mean())
        value.append(np.log(np.median(power[inside])))
    return np.exp(np.interp(f, at, value))
