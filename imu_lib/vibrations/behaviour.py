"""Does what was found in a narrow band behave as its name says? A vibration has an amplitude that
stays and a frequency that wanders about one place.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array

#: What it may do instead.
SWEEPS, BREATHES = "its frequency sweeps", "its amplitude rises and falls"
#: Squared coherence of a band from which on it is one cause, and over that of chance.
TOGETHER, BY_CHANCE = 0.05, 14.0
#: Blocks in which the amplitude is looked at, and samples in one at the least.
BLOCKS, SAMPLES = 24, 6
#: log10 of the probability of the scatter by chance, and the standard deviation of the power over
#: its mean, from which on an amplitude rises and falls.
RARE, DEPTH = -4.0, 0.25
#: Slopes of the frequency that are tried, in bands of the tone over its duration, and how many.
REACH, SLOPES = 2.0, 81
#: Share of the tone's power that is one line once its frequency is straightened, and the share of
#: that which a steady frequency leaves; power that no noise reaches; share of the band that it has
#: to cross.
STRAIGHT, BENT, BEYOND, CROSSED = 0.5, 0.6, 20.0, 0.4
#: Samples of the band in which the frequency is taken for a straight line, and in which one that
#: goes from end to end all the time has to turn the phase away from a steady one's, in half turns.
SECTION, TURNS = 64, 2.0
#: Share of the time from which down half of the power of a band comes in bursts.
BURSTS = 0.2
#: Crossings of its mean, and standard deviation of its logarithm, from which on an amplitude
#: wanders; share of a line's power in one wave.
CROSSINGS, LITTLE, CARRIER = 6, 0.15, 0.6
#: Share by which the power at the ends of an episode is less than in its middle, where it rises and
#: falls.
LESS = 0.25
#: Share of the frequency that it has to move where it is there all the time: a machine warms up.
MOVED = 0.03


def breathes(x: Array) -> bool:
    """Whether the amplitude of a line rises and falls.

    Parameters
    ----------
    x : ndarray of complex, shape (n,)
        The band at its own width, while the line is there; the noise has mean square 1.
    """
    blocks = min(BLOCKS, len(x) // SAMPLES)
    excess = float(np.mean(np.abs(x) ** 2)) - 1.0
    if blocks < 6 or excess < 0.3:
        return False
    size = len(x) // blocks
    e = (np.abs(x[: blocks * size]) ** 2).reshape(blocks, size).mean(axis=1)
    chance = (2.0 * excess + 1.0) / size
    scatter = float(np.sum((e - e.mean()) ** 2))
    rare = chi2.logsf(scatter / chance, blocks - 1) / np.log(10)
    depth = np.sqrt(max(scatter / (blocks - 1) - chance, 0.0)) / max(e.mean() - 1.0, 1e-9)
    return bool(rare < RARE and depth > DEPTH)


def wander(x: Array, width: float) -> tuple[float, float] | None:
    """(standard deviation of the logarithm of the amplitude of a line, its correlation time in s)
    where the amplitude wanders about a mean; None where it only rises and falls, or turns its sign
    as that of two lines does.

    Parameters
    ----------
    x : ndarray of complex, shape (n,)
        As above.
    width : float, Hz
        Of the band.
    """
    power = np.abs(x) ** 2
    excess = float(power.mean()) - 1.0
    if not breathes(x):
        return None
    # of the line without the noise: mean square one, fourth moment that of a steady one and more
    square = (float(np.mean(power**2)) - 4.0 * excess - 2.0) / excess**2
    sd = 0.5 * np.sqrt(np.log(max(square, 1.0 + 1e-6)))
    if sd < LITTLE:
        return None
    z = np.convolve(power - power.mean(), np.ones(SAMPLES) / SAMPLES, "same")
    crossed = np.count_nonzero(np.diff(np.signbit(z)))
    lagged = np.correlate(z, z, "full")[len(z) - 1 :] / max(float(z @ z), 1e-300)
    below = np.flatnonzero(lagged < np.exp(-1.0))
    if not len(below) or crossed < CROSSINGS:
        return None
    return float(sd), float(max(below[0], 1) / width)


def carried(x: Array) -> bool:
    """Whether most of a line (as above) is one steady wave, however its amplitude wanders: of two
    lines beside one another, which beat, either has half.
    """
    n, excess = len(x), float(np.mean(np.abs(x) ** 2)) - 1.0
    line = float(np.max(np.abs(np.fft.fft(x, 8 * n)) ** 2)) / n**2
    return bool(excess > 0 and line - 1.0 / n > CARRIER * excess)


def sweeps(x: Array, width: float, crossed: float, frequency: float, *, whole: bool) -> bool:
    """Whether the frequency of a tone goes from one end of its band to the other.

    Parameters
    ----------
    x : ndarray of complex, shape (n,)
        As above.
    width, crossed : float, Hz
        Of the band `x`, and of the part of it that stands out.
    frequency : float, Hz
        The middle.
    whole : bool
        Whether the tone is there all the time.
    """
    bent = TURNS * np.sqrt(len(x) * width / max(crossed, 1e-9))  # samples until it shows
    parts = np.array_split(x, max(1, round(len(x) / max(SECTION, bent))))
    slope = [
        _slope(part, width, crossed * len(part) / len(x) + width / len(part)) for part in parts
    ]
    found = [v for v in slope if v is not None]
    if len(found) <= 0.6 * len(parts) or abs(np.sum(np.sign(found))) < 0.8 * len(found):
        return False
    moved = abs(np.median(found)) * len(x) / width
    return bool(moved > CROSSED * crossed and (not whole or moved > MOVED * frequency))


def _slope(x: Array, width: float, reach: float) -> float | None:
    """Slope in Hz/s of the frequency of a tone in `x` that moves by no more than about `reach` Hz;
    None where it is steady or no tone.
    """
    n = len(x)
    excess = float(np.mean(np.abs(x) ** 2)) - 1.0
    if n < 10 or excess < 0.3:
        return None
    time, span = (np.arange(n) - 0.5 * n) / width, n / width
    slopes = np.linspace(-REACH, REACH, SLOPES) * reach / span
    straightened = x * np.exp(-1j * np.pi * slopes[:, None] * time**2)
    kept = np.max(np.abs(np.fft.fft(straightened, 4 * n, axis=1)) ** 2, axis=1) / n**2
    best = int(np.argmax(kept))
    steady = kept[SLOPES // 2] > BENT * kept[best]
    return (
        None if steady or kept[best] < max(STRAIGHT * excess, BEYOND / n) else float(slopes[best])
    )


def rises(parts: list[Array]) -> bool:
    """Whether the amplitude rises and falls within the episodes `parts` (arrays as above) instead
    of going on and off.
    """
    edges, middles = [], []
    for x in parts:
        power, quarter = np.abs(x) ** 2, len(x) // 4
        if quarter >= 3:
            edges.append(np.r_[power[1:quarter], power[-quarter:-1]])
            middles.append(power[quarter:-quarter])
    if not edges:
        return False
    edge, middle = np.concatenate(edges), np.concatenate(middles)
    excess = middle.mean() - 1.0
    chance = (2.0 * excess + 1.0) * (1 / len(edge) + 1 / len(middle))
    less = middle.mean() - edge.mean()
    return bool(less > LESS * excess and less > 3.0 * np.sqrt(max(chance, 1e-12)))


def coherent(bands: Sequence[Array]) -> bool:
    """Whether any two channels move together in their bands (n,): the same resonance of each is
    driven by the noise of each.
    """
    n = len(bands[0])
    return any(
        abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a) * np.vdot(b, b)).real
        > max(TOGETHER, BY_CHANCE / n)
        for a, b in combinations(bands, 2)
    )


def half_in(x: Array, fs: float, low: float, high: float) -> float:
    """Share of the time in which half of the power of the band `low` to `high` Hz of `x` (n,)
    comes, in blocks of a second; of stationary noise some 0.4.
    """
    power = block_power(x, fs, low, high, max(1, int(fs)))
    share = np.cumsum(np.sort(power)[::-1]) / power.sum()
    return float((np.searchsorted(share, 0.5) + 1) / len(power))


def block_power(x: Array, fs: float, low: float, high: float, size: int) -> np.ndarray:
    """Mean power of the band `low` to `high` Hz of `x` (n,) in blocks of `size` samples."""
    f = np.fft.rfftfreq(len(x), 1.0 / fs)
    band = np.fft.irfft(np.where((f >= low) & (f <= high), np.fft.rfft(x), 0.0), len(x))
    return np.asarray((band[: len(x) // size * size].reshape(-1, size) ** 2).mean(axis=1))


def fading(x: Array, ratio: float) -> float:
    """Between 0, a steady amplitude, and 1, that of normal noise, from the fourth moment of the
    zoomed band; 1 where the noise hides it.
    """
    r = ratio - 1.0
    if len(x) < 30 or r < 0.5:
        return 1.0
    p = np.abs(x) ** 2
    kurtosis = float(np.mean(p**2) / np.mean(p) ** 2)
    steady = (r * r + 4 * r + 2) / (1 + r) ** 2
    return float(np.clip((kurtosis - steady) / (2.0 - steady), 0.0, 1.5))
