"""A band about what shakes several channels, wide enough to see when it is there and what it does
in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.vibrations.behaviour import BREATHES, SWEEPS, breathes, rises, sweeps
from imu_lib.vibrations.episodes import BLOCKS, episodes
from imu_lib.vibrations.response import within
from imu_lib.vibrations.transforms import Transforms


@dataclass(frozen=True)
class WideBand:
    """A band as much wider as its strength allows, so that its samples are shorter: `z` by channel,
    noise of mean square 1, the `ratio` of each, the band's `width` in Hz.
    """

    z: dict[str, Array]
    ratio: dict[str, float]
    width: float

    @classmethod
    def around(
        cls, felt: dict[str, tuple[float, float]], a: int, b: int, transforms: Transforms
    ) -> WideBand:
        strength = max(r - 1.0 for r, _ in felt.values())
        wider = int(np.clip(min(strength / 2, BLOCKS / (b - a)), 1, 40) * (b - a))
        middle, half = (a + b) // 2, wider // 2 + 1
        if wider > b - a and middle - half > 1 and middle + half < transforms.n // 2:
            a, b = middle - half, middle + half
        z = {name: transforms.zoom(name, a, b) for name in felt}
        share = (b - a) / len(next(iter(z.values())))
        z = {name: x / np.sqrt(share) for name, x in z.items()}
        ratio = {name: max(float(np.mean(np.abs(x) ** 2)), 1.001) for name, x in z.items()}
        return cls(z, ratio, len(next(iter(z.values()))) / transforms.duration)

    def episodes(self, duration: float) -> tuple[tuple[float, float], ...]:
        """(from, to) in s; empty where it is there all the time."""
        weight = {name: (r - 1) / r for name, r in self.ratio.items()}
        total = sum(weight.values())
        power = np.asarray(sum(w / total * np.abs(self.z[name]) ** 2 for name, w in weight.items()))
        return episodes(power, min(len(weight), 2), duration) or ()

    def strange(self, source: dict[str, Any], best: str, duration: float) -> str:
        """Why it behaves as no vibration does, or nothing."""
        # who feels it only in its episodes is not among the channels of the wider band
        x = self.z[best if best in self.z else max(self.ratio, key=lambda c: self.ratio[c])]
        spans = source["spans"]
        time = (np.arange(len(x)) + 0.5) / len(x) * duration
        on = within(spans, time)
        whole = not spans
        if sweeps(x[on], self.width, source["crossed"], source["frequency"], whole=whole):
            return SWEEPS
        parts = [x[within([span], time)] for span in spans]
        line = source["bandwidth"] <= 0.1 * source["frequency"]
        if line and (breathes(x[on]) or rises(parts)):
            return BREATHES
        return ""
