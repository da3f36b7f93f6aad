"""Means over short blocks and their changes: what shifts of level, tilts and restarts are seen
in.
"""

from __future__ import annotations

import numpy as np

#: s of a block.
BLOCK = 0.25


class Blocks:
    """Block means of several channels.

    means : ndarray, shape (channels, k). size : samples of a block. dt : its length, s.
    """

    def __init__(self, x: np.ndarray, rate: float):
        self.size = max(1, round(BLOCK * rate))
        k = x.shape[1] // self.size
        self.means = x[:, : k * self.size].reshape(len(x), k, self.size).mean(axis=2)
        self.dt = self.size / rate
        total = np.zeros((len(x), k + 1))
        np.cumsum(self.means, axis=1, out=total[:, 1:])
        self._total = total

    @property
    def k(self) -> int:
        """Number of blocks."""
        return self.means.shape[1]

    def mean(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Means over blocks low .. high-1, cut to the record; shape (channels, ...)."""
        low, high = np.clip(low, 0, self.k), np.clip(high, 0, self.k)
        return (self._total[:, high] - self._total[:, low]) / np.maximum(high - low, 1)

    def change(self, width: int, guard: int) -> np.ndarray:
        """Mean of the `width` blocks after each boundary less that of those before, `guard` blocks
        on each side left out; shape (channels, k + 1), NaN where a side has less than half.
        """
        j = np.arange(self.k + 1)
        out = self.mean(j + guard, j + guard + width) - self.mean(j - guard - width, j - guard)
        short = (j - guard < (width + 1) // 2) | (self.k - j - guard < (width + 1) // 2)
        out[:, short] = np.nan
        return out


def sudden(change: np.ndarray, apart: int) -> tuple[np.ndarray, np.ndarray]:
    """How far each change stands out of those `apart` blocks before and after, and the robust
    scatter of that; shapes (channels, k) and (channels, 1).

    A drift changes before and after as well; a step does not.
    """
    before = np.full_like(change, np.nan)
    after = np.full_like(change, np.nan)
    if apart < change.shape[1]:
        before[:, apart:] = change[:, :-apart]
        after[:, :-apart] = change[:, apart:]
    one_sided = np.isnan(before) | np.isnan(after)
    before = np.where(np.isnan(before), after, before)
    after = np.where(np.isnan(after), before, after)
    up = np.minimum(change - before, change - after)
    down = np.minimum(before - change, after - change)
    off = np.where(up > 0, up, np.where(down > 0, -down, 0.0))
    # with one neighbour a step there would show here as its mirror image: only what changes here
    # counts
    here = np.where(change * off > 0, np.minimum(np.abs(off), np.abs(change)), 0.0)
    off = np.where(one_sided, np.sign(off) * here, off)
    usual = np.abs(change - 0.5 * (before + after))
    off, usual = np.nan_to_num(off), np.where(np.isnan(usual), np.nan, usual)
    known = usual[:, ~np.isnan(usual).all(axis=0)]
    if known.shape[1] == 0:
        return off, np.full((len(change), 1), np.inf)
    return off, np.maximum(1.4826 * np.nanmedian(known, axis=1, keepdims=True), 1e-300)


def peaks(score: np.ndarray, least: float, apart: int) -> list[int]:
    """Positions of local maxima of `score` (k,) above `least`, none within `apart` of a higher
    one.
    """
    order = [int(i) for i in np.flatnonzero(score > least)]
    order.sort(key=lambda i: -score[i])
    taken: list[int] = []
    blocked = np.zeros(len(score), bool)
    for i in order:
        if not blocked[i]:
            taken.append(i)
            blocked[max(0, i - apart) : i + apart + 1] = True
    return sorted(taken)
