"""Which channels feel what shakes at one place of the spectrum, against its surroundings there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.arrays import Array
from imu_lib.vibrations.behaviour import coherent
from imu_lib.vibrations.transforms import Transforms

#: Gain in log-likelihood from which on a channel feels what another one shows, and power over its
#: surroundings that it needs at the least.
FELT, LEAST = 9.0, 1.12
#: Widths of a place on either side that are its surroundings at the time of an episode.
SIDES = 12


def beside(
    spans: Sequence[tuple[float, float]], a: int, b: int, transforms: Transforms
) -> dict[str, float]:
    """How much louder than usual the surroundings of the ordinates `a` to `b` are in the `spans`,
    by channel: where all of the noise is louder for a time, no line begins and ends.
    """
    if not spans:
        return {}
    width = SIDES * (b - a)
    parts = [
        (low, high)
        for low, high in ((a - width, a - (b - a)), (b + (b - a), b + width))
        if low > 1 and high < transforms.n // 2
    ]
    out = {}
    for name in transforms.names if parts else ():
        levels = []
        for low, high in parts:
            x = transforms.zoom(name, low, high)
            on = within(spans, (np.arange(len(x)) + 0.5) / len(x) * transforms.duration)
            power = np.abs(x) ** 2
            levels.append(float(np.mean(power[on]) / max(np.mean(power), 1e-300)))
        out[name] = max(1.0, float(np.mean(levels)))
    return out


def felt_on(
    z: dict[str, Array],
    on: Array,
    share: float,
    found_on: set[str],
    louder: dict[str, float] | None = None,
    *,
    wide: bool = False,
) -> dict[str, tuple[float, float]]:
    """Channels that feel it: name -> (power over the surroundings, gain); `louder` is the level of
    these at that time, by channel. Over a `wide` band a spectrum may bend by as much as another
    channel's rises: there a channel that did not show it by itself has to move with one that did.
    """
    out = {}
    dof = max(on.sum() * share, 1.0)
    for name, x in z.items():
        r = float(np.mean(np.abs(x[on]) ** 2)) / share / (louder or {}).get(name, 1.0)
        gain = dof * (r - 1 - np.log(max(r, 1e-9))) if r > 1 else 0.0
        felt = gain > FELT and r > LEAST
        if felt and wide and name not in found_on:
            felt = any(coherent([x[on], z[other][on]]) for other in found_on)
        if name in found_on or felt:
            out[name] = (max(r, 1.0 + 1e-6), float(gain))
    return out


def within(spans: Sequence[tuple[float, float]], time: Array) -> np.ndarray:
    """Whether times (n,) lie in one of the spans (from, to); all where there is none."""
    out = np.full(len(time), not spans)
    for start, stop in spans:
        out |= (time >= start) & (time <= stop)
    return out
