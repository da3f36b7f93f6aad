"""Is the sensor at rest at all? Windows of one second in which it turned, tilted or was shaken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

#: s of the windows.
WINDOW = 1.0
#: rad/s of a window's mean off the bias: more than any bias drifts within a record at rest.
TURNING = 0.02
#: rad/s that no change of bias makes, and windows around each that tell its usual mean.
SPINNING, AROUND = 0.15, 61
#: m/s^2 between neighbouring windows' means: 0.9 deg of tilt.
TILTING = 0.15
#: Times the scatter of the quietest fifth of the windows.
SHAKING = 4.0
#: Shares of the windows in which a sensor turns, and in which it turns or is shaken, from which on
#: nothing is a disturbance: it travels.
TRAVELS, RESTLESS = 0.2, 0.5


@dataclass(frozen=True)
class Windows:
    """What each window of WINDOW s shows, ndarrays of shape (k,), bool.

    known: all channels are there. moving: turned or tilted. shaking: louder than the quiet ones.
    size: samples in a window.
    """

    known: np.ndarray
    moving: np.ndarray
    shaking: np.ndarray
    size: int

    @property
    def moving_share(self) -> float:
        """Of the windows that are known."""
        return float(self.moving[self.known].mean()) if self.known.any() else 0.0

    @property
    def shaking_share(self) -> float:
        """Of the windows that are known."""
        return float(self.shaking[self.known].mean()) if self.known.any() else 0.0

    @property
    def restless_share(self) -> float:
        """Moving or shaken, of the windows that are known."""
        return float((self.moving | self.shaking)[self.known].mean()) if self.known.any() else 0.0

    @property
    def travels(self) -> bool:
        """Whether it moves for so long that it is not at rest with disturbances."""
        share = self.moving_share
        return share > TRAVELS or share > 0.02 and self.restless_share > RESTLESS


def windows(channels: dict[str, np.ndarray], rate: float, grid: dict[str, float]) -> Windows:
    """The windows of a record; `grid` is each channel's output step, 0 where there is none."""
    n = len(next(iter(channels.values())))
    block = max(10, int(round(WINDOW * rate)))
    k = n // block
    if k == 0:
        block, k = n, 1
    x = np.stack([c[: k * block].reshape(k, block) for c in channels.values()])
    mean, sd = x.mean(axis=2), x.std(axis=2)
    known = np.isfinite(mean).all(axis=0)
    moving, shaking = np.zeros(k, bool), np.zeros(k, bool)
    if not known.any():
        return Windows(known, moving, shaking, block)
    for row, name in enumerate(channels):
        m, s = mean[row], sd[row]
        # where the output is frozen nothing is quiet
        live = known & (s > 1e-6 * s[known].max())
        quiet = float(np.quantile(s[live if live.any() else known], 0.2))
        shaking |= known & (s > SHAKING * quiet + grid.get(name, 0.0))
        noise = quiet / np.sqrt(block)
        if name.startswith("gyro"):
            still = known & (s <= np.quantile(s[known], 0.5))
            usual = np.median(m[still])
            # a bias may change for good, and be another one from then on
            around = median_filter(np.where(known, m, usual), size=min(AROUND, k), mode="nearest")
            least = max(TURNING, 5 * noise)
            moving |= known & (
                (np.abs(m - around) > least) | (np.abs(m - usual) > least + SPINNING)
            )
        else:
            jump = np.r_[0.0, np.abs(np.diff(m))]
            moving |= known & (np.nan_to_num(jump) > max(TILTING, 6 * noise))
    return Windows(known, moving, shaking, block)
