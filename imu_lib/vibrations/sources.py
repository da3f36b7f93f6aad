"""One place in frequency over all channels: who feels it, from when to when, how wide, how strong.

The band around a place is brought down to zero frequency and sampled at its own width (`Zoom`):
its samples are then nearly independent complex numbers, normal where there is nothing but noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import next_fast_len

from imu_lib.arrays import Array
from imu_lib.vibrations.behaviour import (
    SWEEPS,
    carried,
    coherent,
    fading,
    wander,
)
from imu_lib.vibrations.narrow_band import Place
from imu_lib.vibrations.response import beside, felt_on, within
from imu_lib.vibrations.transforms import Transforms
from imu_lib.vibrations.wide_band import WideBand

#: Width over frequency up to which what several channels show at one place is one cause.
NARROW = 0.04
#: Share of the band of a tone that sweeps by which it may begin and end outside of it.
ENDS = 0.1
#: Width over that of a stronger place from which on what is faint is what is left beside it.
WIDE = 1.6


@dataclass(frozen=True)
class Source:
    """What shakes several channels at one place of the spectrum.

    `amplitude` and `sd` (its standard deviation) by channel, of a sinusoid of the same power;
    `bandwidth` Hz, 0 where the line is as narrow as the record can tell; `fading` 0 where its
    amplitude is steady, 1 where it is that of normal noise; `strength` its power over that of the
    noise in the band on the channel that shows it best.
    """

    place: Place
    frequency: float
    frequency_sd: float
    bandwidth: float
    #: When it is there, (from, to) in s each; empty: all the time.
    spans: tuple[tuple[float, float], ...]
    amplitude: dict[str, float]
    sd: dict[str, float]
    gain: float
    fading: float
    strength: float
    #: Why it is no vibration where one channel alone has it: its amplitude rises and falls, or its
    #: frequency goes from one end of the band to the other.
    strange: str = ""
    #: Whether a band that several channels show moves in them together.
    coherent: bool = True
    #: Standard deviation of the logarithm of its amplitude and correlation time in s, where that
    #: wanders about a mean; whether most of it is one wave all the same.
    wander: tuple[float, float] | None = None
    carried: bool = False

    @property
    def channels(self) -> tuple[str, ...]:
        """Who feels it, in the order of the record."""
        return tuple(self.amplitude)

    @property
    def whole(self) -> bool:
        """Whether it is there all the time."""
        return not self.spans

    @property
    def start(self) -> float | None:
        """When it is there first, s."""
        return self.spans[0][0] if self.spans else None

    @property
    def stop(self) -> float | None:
        """When it is there last, s."""
        return self.spans[-1][1] if self.spans else None


def examined(place: Place, found_on: set[str], transforms: Transforms) -> Source:
    """The source behind a `place` that was found on the channels `found_on`."""
    a, b = transforms.ordinates(place.low, place.high)
    z = {name: transforms.zoom(name, a, b) for name in transforms.names}
    count = len(next(iter(z.values())))
    time = (np.arange(count) + 0.5) / count * transforms.duration
    on = (time >= place.start) & (time <= place.stop)
    broad = place.high - place.low > NARROW * place.high
    felt = felt_on(z, on, (b - a) / count, found_on, wide=broad)
    wide = WideBand.around(felt, a, b, transforms)
    spans = wide.episodes(transforms.duration)
    on = within(spans, time)
    felt = felt_on(z, on, (b - a) / count, found_on, beside(spans, a, b, transforms), wide=broad)
    frequency, frequency_sd, bandwidth = _width(z, felt, on, a, b, transforms)
    best = max(felt, key=lambda name: felt[name][1])
    ratio = felt[best][0]
    amplitude, sd = {}, {}
    dof = max(on.sum() * (b - a) / count, 1.0)
    for name, (r, _) in felt.items():
        scale = transforms.density(name, a, b) * (b - a) * transforms.fs / transforms.n
        amplitude[name] = float(np.sqrt(2 * max(r - 1.0, 1e-6) * scale))
        free = dof if bandwidth == 0 else min(dof, 1 + bandwidth * transforms.duration * on.mean())
        spread = (2 * (r - 1) + 1) / dof + (0 if bandwidth == 0 else (r - 1) ** 2 / free)
        sd[name] = float(0.5 * amplitude[name] * np.sqrt(spread) / max(r - 1.0, 1e-6))
    strange = wide.strange(
        {
            "spans": spans,
            "frequency": frequency,
            "bandwidth": bandwidth,
            "crossed": (b - a) / transforms.duration,
        },
        best,
        transforms.duration,
    )
    if strange == SWEEPS:  # it is all over its band, and the windows that found it end within
        more = ENDS * (place.high - place.low)
        top = min(place.high + more, 0.495 * transforms.fs)
        place = replace(place, low=max(place.low - more, 0.5 * place.low), high=top)
        frequency, bandwidth = 0.5 * (place.low + place.high), place.high - place.low
    return Source(
        place,
        frequency,
        frequency_sd,
        bandwidth,
        spans,
        {n: amplitude[n] for n in transforms.names if n in amplitude},
        sd,
        float(sum(g for _, g in felt.values())),
        fading(z[best][on], ratio),
        float(ratio - 1.0),
        strange,
        bandwidth < NARROW * frequency or coherent([z[name][on] for name in felt]),
        *_amplitude(wide, best, bandwidth < NARROW * frequency and not spans),
    )


def _amplitude(wide: WideBand, best: str, line: bool) -> tuple[tuple[float, float] | None, bool]:
    """How the amplitude wanders, and whether most of it is one wave, of a `line` that is there all
    the time.
    """
    x = wide.z.get(best)
    if not line or x is None:
        return None, False
    return wander(x, wide.width), carried(x)


def _width(
    z: dict[str, Array],
    felt: dict[str, tuple[float, float]],
    on: Array,
    a: int,
    b: int,
    transforms: Transforms,
) -> tuple[float, float, float]:
    """Frequency with its standard deviation and width at half power, Hz, of what is felt."""
    count = len(on)
    rate = count / transforms.duration  # of the zoomed samples
    first, last = np.flatnonzero(on)[[0, -1]]
    part = slice(first, last + 1)
    length = last + 1 - first
    window = np.sin(np.pi * (np.arange(length) + 0.5) / length)
    size = next_fast_len(4 * length)
    weight = sum((r - 1) for r, _ in felt.values())
    power = np.asarray(
        sum(
            (r - 1) / weight * np.abs(np.fft.fft(z[name][part] * window, size)) ** 2
            for name, (r, _) in felt.items()
        )
    )
    seconds = length / rate
    f = transforms.fs / transforms.n * a + np.arange(size) / size * rate
    keep = f <= transforms.fs / transforms.n * (b - 1)
    f, power = f[keep], power[keep]
    ratio = max(r for r, _ in felt.values())
    floor = power.mean() / ratio  # of the noise in the band
    over = np.maximum(power - floor, 0.0)
    # what noise leaves of itself is no width: ordinates that stand out, in runs of a segment
    over[power < 4 * floor] *= 0.25
    peak = int(np.argmax(over))
    steps = np.cumsum(over) / over.sum()
    q = np.interp([0.25, 0.5, 0.75], steps, f)
    half = float(q[2] - q[0])
    snr = max(ratio - 1, 1e-3) * max(on.sum(), 1)
    if half < 2.0 / seconds:
        best = f[peak]
        if 0 < peak < len(power) - 1:
            y = np.log(np.maximum(power[peak - 1 : peak + 2], 1e-300))
            bend = y[0] - 2 * y[1] + y[2]
            if bend < 0:
                best += 0.5 * (y[0] - y[2]) / bend * (f[1] - f[0])
        return float(best), float(np.sqrt(3 / snr) / (np.pi * seconds)), 0.0
    return float(q[1]), float(half / np.sqrt(max(half * seconds, 1.0))), half


def sources(places: dict[str, list[Place]], transforms: Transforms) -> list[Source]:
    """All sources behind the places of the channels (name -> list of `Place`), the strongest
    first, each place used once.
    """
    left = [(p, name) for name, found in places.items() for p in found]
    left.sort(key=lambda item: -item[0].rank)
    out = []
    while left:
        place, first = left[0]
        near, names = [left[0]], {first}
        grown = True
        while grown:  # a line that wanders is seen in pieces
            grown = False
            for item in left:
                if item not in near and _meets(item, place, names, transforms):
                    place = _joined(place, item[0])
                    near.append(item)
                    names.add(item[1])
                    grown = True
        left = [item for item in left if item not in near]
        out.append(examined(place, names, transforms))
    return out


def _meets(item: tuple[Place, str], place: Place, names: set[str], transforms: Transforms) -> bool:
    """Whether a place on a channel belongs to one that was found: their bands meet, and at the
    same time or on a channel that shows it already.
    """
    other, name = item
    slack = transforms.fs / max(place.length, other.length)
    if other.high - other.low > WIDE * (place.high - place.low) and other.rank < place.rank:
        # wide and faint over narrow and strong: it is what is left beside the line
        return place.low - slack <= other.high and other.low - slack <= place.high
    return place.overlaps(other, slack) or (
        name in names and place.low <= other.high and other.low <= place.high
    )


def _joined(place: Place, other: Place) -> Place:
    """A place widened to the band and the time of another of its make."""
    if other.high - other.low > WIDE * (place.high - place.low):
        return place
    whole = min(place.start, other.start), max(place.stop, other.stop)
    return replace(
        place,
        low=min(place.low, other.low),
        high=max(place.high, other.high),
        start=whole[0],
        stop=whole[1],
        gain=max(place.gain, other.gain),
    )
