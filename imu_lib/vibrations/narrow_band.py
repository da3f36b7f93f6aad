"""Where in frequency and time a channel is louder than around: lines, lines that wander, bands,
for part of the record or all of it.

Periodograms of segments of several lengths are added up over stretches of the record and compared
with the running median over neighbouring frequencies; a stretch has its own level, so that noise
that is louder everywhere is no line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.stats import gamma

from imu_lib.arrays import Array
from imu_lib.samples.innovations import STOP_BAND_DEPTH

#: Lengths of the segments, and the stretches that a record is divided into at the most.
LENGTHS, STRETCHES = (128, 512, 2048, 8192, 32768, 131072), 32
#: Ordinates over which the running median goes, and gain in log-likelihood from which on a place
#: stands out of all that are looked at.
WIDTH, GAIN = 41, 30.0
#: Gain from which on it may be a part of one that several channels show at one place: of chance a
#: channel has some two of these, anywhere, and the channels together have `GAIN`.
PART = 12.0
#: Shortest segments that show such a line, and its ordinates in these at the most: what is wider is
#: a part of a band, which is told as one by its coherence.
LONG, THIN = 2048, 4.5
#: Power over its surroundings below which a place may be a bend of a smooth spectrum.
LEAST = 1.35
#: Segments in a stretch at the least: a knock that rings is shorter.
SEGMENTS = 6


@dataclass(frozen=True)
class Place:
    """A place that stands out: its band `low` to `high` Hz, its time `start` to `stop` s, the gain
    in log-likelihood over no excess, the frequency of its `peak`, and the `length` of the segments
    that show it best.
    """

    low: float
    high: float
    start: float
    stop: float
    gain: float
    peak: float
    length: int

    @property
    def rank(self) -> float:
        """Its gain, longer segments preferred: they show the same place more sharply."""
        return self.gain * (1.0 + 0.2 * np.log2(self.length / LENGTHS[0]))

    def overlaps(self, other: Place, slack: float = 0.0) -> bool:
        """Whether the bands meet and the times have more in common than not."""
        shared = min(self.stop, other.stop) - max(self.start, other.start)
        short = min(self.stop - self.start, other.stop - other.start)
        return (
            self.low - slack <= other.high
            and other.low - slack <= self.high
            and shared > 0.5 * short
        )


class Periodograms:
    """Power of successive half-overlapping segments of `length` samples under a sine window,
    density in unit^2/Hz, shape (segments, length / 2 + 1).
    """

    def __init__(self, x: Array, fs: float, length: int) -> None:
        self.fs, self.length, self.hop = fs, length, length // 2
        window = np.sin(np.pi * (np.arange(length) + 0.5) / length)
        parts = np.lib.stride_tricks.sliding_window_view(x, length)[:: self.hop]
        step = max(1, 2**22 // length)
        self.power = np.concatenate(
            [
                np.abs(np.fft.rfft((p - p.mean(axis=1, keepdims=True)) * window, axis=1)).astype(
                    np.float32
                )
                ** 2
                for p in (parts[i : i + step] for i in range(0, len(parts), step))
            ]
        ) * (4.0 / (fs * length))
        self.f = np.arange(length // 2 + 1) * fs / length

    @property
    def count(self) -> int:
        """Number of segments."""
        return len(self.power)

    def time(self, segment: float) -> float:
        """Beginning of a segment, s."""
        return segment * self.hop / self.fs


def surroundings(power: Array) -> np.ndarray:
    """The level around every ordinate of a mean spectrum (k,), which a line does not lift and a
    slope does not mislead: the larger of the running medians to its left and to its right.
    """
    half = WIDTH // 2
    power = np.concatenate([[power[1:4].max()], power[1:]])  # the mean is taken out
    middle = median_filter(power, WIDTH, mode="nearest")
    index = np.arange(len(power))
    left = middle[np.maximum(index - half // 2, 0)]
    right = middle[np.minimum(index + half // 2, len(power) - 1)]
    return np.maximum(np.maximum(left, right), 1e-300)


def independent(count: int) -> float:
    """Degrees of freedom, in pairs, of the mean of half-overlapping segments under a sine window:
    neighbours correlate by 0.19 in power.
    """
    return count / (1.0 + 0.36 * (count - 1) / count)


def ladder(n: int) -> list[int]:
    """Lengths of the segments for a record of `n` samples."""
    return [length for length in LENGTHS if length <= n // 4]


def _stretches(count: int) -> list[tuple[int, int]]:
    """First and last segment of the stretches: all, halves, quarters, ... and those between."""
    out = [(0, count)]
    parts = 2
    while parts <= STRETCHES and count // parts >= SEGMENTS:
        size = count / parts
        out += [
            (int(round(k * size / 2)), int(round(k * size / 2 + size)))
            for k in range(2 * parts - 1)
        ]
        parts *= 2
    return out


def of_all(channels: dict[str, Array], fs: float, *, least: float = 0.0) -> dict[str, list[Place]]:
    """Places by channel (name -> (n,)) above `least` Hz that stand out of one of them, or of
    several together.
    """
    found = {name: places(x, fs, least=least, gain=PART) for name, x in channels.items()}
    return {
        name: [p for p in own if p.gain >= GAIN or _joint(p, name, found, fs) >= GAIN]
        for name, own in found.items()
    }


def _joint(place: Place, on: str, found: dict[str, list[Place]], fs: float) -> float:
    """Gain of a line and of those that other channels have there, each the best it has."""
    slack = fs / place.length
    if place.length < LONG or place.high - place.low > THIN * slack:
        return place.gain
    return place.gain + sum(
        max((p.gain for p in own if p.overlaps(place, slack)), default=0.0)
        for name, own in found.items()
        if name != on
    )


def places(
    x: Array, fs: float, *, least: float = 0.0, most: int = 60, gain: float = GAIN
) -> list[Place]:
    """Places of a channel `x` (n,) above `least` Hz that stand out by `gain`, the strongest
    first.
    """
    found: list[Place] = []
    for length in ladder(len(x)):
        found += _of_length(Periodograms(x, fs, length), least, most, gain)
    found.sort(key=lambda p: -p.rank)
    out: list[Place] = []
    for place in found:
        slack = 1.5 * fs / place.length
        if not any(place.overlaps(other, slack) for other in out):
            out.append(place)
    return out[:most]


def _of_length(
    segments: Periodograms, least: float, most: int, enough: float = GAIN
) -> list[Place]:
    power, count = segments.power, segments.count
    whole = power.mean(axis=0, dtype=float)
    around = surroundings(whole)
    around = np.maximum(around, STOP_BAND_DEPTH * around.mean())  # below is what the window leaks
    first = max(5, int(np.ceil(least / segments.f[1])))  # slower is a drift
    total = np.vstack([np.zeros(power.shape[1]), np.cumsum(power, axis=0, dtype=float)])
    rows: list[Array] = []
    spans: list[tuple[int, int]] = []
    dofs: list[float] = []
    usual: Array | float = 1.0
    for a, b in _stretches(count):
        ratio = (total[b] - total[a]) / (b - a) / around
        # the level of a stretch in eight parts of the spectrum; where most of a part lies far below
        # its surroundings, between the lobes of a filter, these are the level
        own = _levels(ratio)
        usual = np.minimum(own / 0.75, 1.0) if not rows else usual
        rows.append(ratio * (usual / own))
        spans.append((a, b))
        dofs.append(independent(b - a))
    ratio, dof = np.array(rows), np.array(dofs)[:, None]
    gain = np.where(ratio > LEAST, dof * (ratio - 1.0 - np.log(np.maximum(ratio, 1e-9))), 0.0)
    gain[:, :first] = 0.0
    gain[:, -2:] = 0.0
    # what passes chance where so few segments have no other surroundings than a median
    unlikely = gamma.logsf(ratio * dof, dof) < -enough
    gain[~unlikely] = 0.0
    out = []
    for _ in range(most):
        j, i = map(int, np.unravel_index(int(np.argmax(gain)), gain.shape))
        if gain[j, i] < enough:
            break
        lo, hi = _extent(ratio[j], i, float(dof[j, 0]))
        a, b = spans[j]
        wide = hi - lo > 1 and segments.length < LENGTHS[2]
        if wide and _lobe((total[b] - total[a]) / (b - a), lo, i):
            gain[:, max(0, lo - 2) : hi + 3] = 0.0
            continue
        strength = float(gain[j, lo : hi + 1].sum())
        half = 0.5 * segments.f[1]
        out.append(
            Place(
                float(segments.f[lo] - half),
                float(segments.f[hi] + half),
                segments.time(a),
                segments.time(b - 1) + segments.length / segments.fs,
                strength,
                float(segments.f[i]),
                segments.length,
            )
        )
        gain[:, max(0, lo - 2) : hi + 3] = 0.0
    return out


def _lobe(power: Array, lo: int, peak: int) -> bool:
    """Whether what stands out is no louder than what lies below it in frequency: a lobe of a
    filter rises behind its null, and never as high as the one before.
    """
    width = 2 * (peak - lo) + 1
    below = power[max(2, lo // 2) : max(lo, 3)]
    if len(below) < width:
        return False
    return bool(np.convolve(below, np.ones(width) / width, "valid").max() > 0.8 * power[peak])


def _levels(ratio: Array, parts: int = 8) -> np.ndarray:
    """Median level in parts of the spectrum, straight lines between them, shape of `ratio`."""
    edge = np.linspace(0, len(ratio), parts + 1).astype(int)
    level = [np.median(ratio[a:b]) for a, b in zip(edge[:-1], edge[1:])]
    return np.maximum(np.interp(np.arange(len(ratio)), (edge[:-1] + edge[1:]) / 2, level), 1e-9)


def _extent(ratio: Array, i: int, dof: float) -> tuple[int, int]:
    """First and last ordinate of what stands out around ordinate `i`: down to a twentieth of the
    excess or a decibel, or to what chance allows.
    """
    floor = 1.0 + max(min(0.05 * (ratio[i] - 1.0), 0.3), 2.0 / np.sqrt(dof))
    lo = hi = i
    while lo > 1 and (ratio[lo - 1] > floor or lo > 2 and ratio[lo - 2] > floor):
        lo -= 1
    while hi < len(ratio) - 2 and (
        ratio[hi + 1] > floor or hi < len(ratio) - 3 and ratio[hi + 2] > floor
    ):
        hi += 1
    return lo, hi
