"""Lines of one cause by the pattern in which the channels feel them: one ratio of amplitudes for
all channels, or several.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.vibrations.multiples import multiple
from imu_lib.vibrations.sources import Source
from imu_lib.vibrations.transforms import Transforms

#: A line with its order in a comb, or its frequency in Hz where it is no multiple.
Line = tuple[float, Source]
#: Share of the power of a line on a channel, and standard deviations of it, by which the pattern
#: of its family may miss it.
SHARE, SURE = 0.15, 4.0


def faint(
    order: int, amplitude: dict[str, float], f0: float, family: list[Source], transforms: Transforms
) -> Source:
    """A multiple of `f0` Hz that did not stand out alone, with what its `family` is otherwise."""
    best = max(family, key=lambda s: s.gain)
    low, high = multiple(order, f0, family, transforms)
    a, b = transforms.ordinates(low, high)
    times = order * f0 / best.frequency
    own = {name: v for name, v in amplitude.items() if v > 0}
    over = {n: v**2 / 2 / _noise(n, a, b, transforms) for n, v in own.items()}
    return replace(
        best,
        place=replace(best.place, low=low, high=high),
        frequency=order * f0,
        frequency_sd=best.frequency_sd * times,
        bandwidth=best.bandwidth * times,
        amplitude=own,
        sd={n: 0.5 * v * _spread(over[n], b - a) / over[n] for n, v in own.items()},
        gain=float(sum((b - a) * (r - np.log1p(r)) for r in over.values())),
        strength=max(over.values(), default=0.0),
    )


def alike(lines: list[Line], names: list[str], transforms: Transforms) -> list[list[Line]]:
    """The lines by pattern, each a list in which one ratio of amplitudes holds for all of the
    channels `names` as far as their noise can tell.
    """
    power, sd = _powers(lines, names, transforms)
    left = sorted(range(len(lines)), key=lambda k: -lines[k][1].gain)
    out = []
    while left:
        part: list[int] = []
        for k in left:
            if not part or _agrees(power[:, [*part, k]], sd[:, [*part, k]]):
                part.append(k)
        left = [k for k in left if k not in part]
        out.append([lines[k] for k in sorted(part)])
    return out


def factors(matrix: Array, noise: Array) -> tuple[Array, Array]:
    """Amplitudes of the channels and of the lines over the strongest whose product is nearest to
    `matrix`, each channel in units of its `noise` (channels,): shapes (channels,), (lines,).
    """
    u, s, v = np.linalg.svd(matrix / noise[:, None], full_matrices=False)
    ratios = np.abs(v[0])
    top = ratios.max()
    return np.abs(u[:, 0]) * noise * s[0] * top, ratios / top


def noise_of(lines: list[Line], names: list[str], transforms: Transforms) -> np.ndarray:
    """Root of the mean power of the noise beside the lines, shape (names,)."""
    return np.sqrt([np.mean([_beside(s, n, transforms)[0] for _, s in lines]) for n in names])


def _agrees(power: Array, sd: Array) -> bool:
    """Whether one ratio of amplitudes foretells the `power` (channels, lines) within its `sd`."""
    strength, ratios = factors(np.sqrt(power), np.sqrt(sd.mean(axis=1)))
    off = np.abs(np.outer(strength, ratios) ** 2 - power)
    largest = np.maximum(np.outer(strength, ratios) ** 2, power)
    return not np.any((off > SURE * sd) & (off > SHARE * largest))


def _powers(
    lines: list[Line], names: list[str], transforms: Transforms
) -> tuple[np.ndarray, np.ndarray]:
    """Power of each line on each channel, and its standard deviation, (names, lines) each."""
    power = np.array([[s.amplitude.get(n, 0.0) ** 2 / 2 for _, s in lines] for n in names])
    sd = np.zeros_like(power)
    for i, n in enumerate(names):
        for k, (_, s) in enumerate(lines):
            noise, count = _beside(s, n, transforms)
            sd[i, k] = noise * _spread(power[i, k] / noise, count)
    return power, sd


def _beside(s: Source, name: str, transforms: Transforms) -> tuple[float, int]:
    """Power of the noise in the band of a source, and the ordinates of that."""
    a, b = transforms.ordinates(s.place.low, s.place.high)
    return _noise(name, a, b, transforms), b - a


def _noise(name: str, a: int, b: int, transforms: Transforms) -> float:
    return float(transforms.density(name, a, b) * (b - a) / transforms.duration)


def _spread(over: float, count: int) -> float:
    """Standard deviation of a line's power, `over` times the noise of `count` ordinates, over
    that.
    """
    return float(np.sqrt((2 * over + 1) / count))
