"""Single samples that are thrown off, between those that are hidden (missing, frozen, clipped):
both are drawn anew given the others, in turns, since what is drawn under too loud a spectrum makes
its neighbours surprising.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib import words
from imu_lib.arrays import Array
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.effects.spikes import Spikes
from imu_lib.processes import Spikes as Thrown
from imu_lib.samples.imputation import impute
from imu_lib.samples.innovations import Smooth, surprises
from imu_lib.samples.outliers import deconvolved, spike_odds

#: Steps of the grid, in standard deviations of what the other samples leave open, from which on
#: the levels show in the innovations.
DITHER = 0.3
#: Share of the samples that the spikes of a given model may be.
MOST = 0.5
#: Rounds of finding samples that are thrown off, and of filling in between two of them.
ROUNDS = 5
#: Share of clipped samples from which on the spectrum hangs on what is drawn for them: they are
#: drawn until the variance keeps to this share of itself.
MANY, STEADY = 0.01, 0.01
#: Samples whose times are told one by one.
TOLD = 5


@dataclass(frozen=True)
class Hidden:
    """Samples that say little of the signal.

    `rest` (n,) is the channel less what was set aside (`coarse`); `mask` marks the hidden samples,
    `clipped` those at a limit, `above` and `below` are (mask, limit) of either, `grid` (step,
    offset) or None.
    """

    rest: np.ndarray
    coarse: np.ndarray
    mask: np.ndarray
    clipped: np.ndarray
    above: tuple[Array, float]
    below: tuple[Array, float]
    grid: tuple[float, float] | None

    @classmethod
    def of(
        cls,
        raw: Array,
        rest: Array,
        coarse: Array,
        bad: Array,
        side: Array,
        grid: tuple[float, float] | None,
    ) -> Hidden:
        """Of samples that are `bad` or on one `side` of the range."""
        half = 0.5 * (0.0 if grid is None else grid[0])
        high, low = side > 0, side < 0
        above = high, raw[high].min() - half if high.any() else 0.0
        below = low, raw[low].max() + half if low.any() else 0.0
        return cls(rest, coarse, bad | (side != 0), side != 0, above, below, grid)

    def filled(
        self, spiked: Array, smooth: Smooth, rng: np.random.Generator, before: Array | None = None
    ) -> np.ndarray:
        """The rest with the hidden and the `spiked` samples drawn anew; `before` is the former
        filling.
        """
        bad = self.mask & ~self.clipped | spiked
        above, below = (self._moved(*side) for side in (self.above, self.below))
        out = impute(self.rest, bad, smooth, rng, above=above, below=below, before=before)
        if self.grid is None:
            return out
        step, offset = self.grid  # clipped samples were rounded, too
        rounded = offset + np.rint((out + self.coarse - offset) / step) * step - self.coarse
        return np.where(self.clipped, rounded, out)

    def _moved(self, mask: Array, limit: float) -> tuple[Array, float] | None:
        """(mask, limit of the rest): the limit of the whole signal moves with what was set
        aside.
        """
        return (mask, limit - float(np.median(self.coarse[mask]))) if mask.any() else None


def without_spikes(
    hidden: Hidden, smooth: Smooth, held: Thrown | None, rng: np.random.Generator
) -> tuple[Finding | None, Array, Array, Smooth]:
    """(finding or None, mask of the samples, clean rest, its spectrum); `held` are the spikes of
    the given model, or None.
    """
    clean, spikes, spiked = hidden.rest, None, np.zeros(len(hidden.rest), bool)
    former = None
    for _ in range(ROUNDS):
        if (hidden.mask | spiked).any():
            clean, smooth = _settled(hidden, spiked, smooth, rng, former)
            former = clean
        else:
            clean = hidden.rest
        y, even, instead = _surprises(hidden, clean, smooth, rng)
        new = Spikes().detect(y[~hidden.mask], even, held)
        if new is None and held is None:
            spikes = None
            break
        count = spiked.sum()
        spiked = np.zeros(len(clean), bool)
        if new is not None:
            assert new.mask is not None, "they are found by their samples"
            spiked[np.flatnonzero(~hidden.mask)[new.mask]] = True
            spikes = new
        elif held is not None:
            spiked[_of_model(y, even, held)] = True
        spiked |= instead & ~hidden.mask
        if abs(int(spiked.sum()) - int(count)) <= 0.01 * count:
            break
    if (hidden.mask | spiked).any():
        clean = hidden.filled(spiked, smooth, rng, former)
        smooth = Smooth(clean, smooth.fs)
    if spikes is not None:
        spikes = replace(spikes, where=spikes.where + _when(y, spiked, smooth.fs))
    return spikes, spiked, clean, smooth


def _when(y: Array, spiked: Array, fs: float) -> str:
    """When the samples `spiked` came, in words, by the sizes of their surprises."""
    at = np.flatnonzero(spiked)
    if not len(at):
        return ""
    if len(at) <= TOLD:
        return f", at {words.listed([f'{i / fs:.1f}' for i in at])} s"
    largest = at[np.argmax(np.abs(y[at]))]
    return f", from {at[0] / fs:.1f} to {at[-1] / fs:.1f} s, the largest at {largest / fs:.1f} s"


def _of_model(y: Array, smooth: Smooth, held: Thrown) -> np.ndarray:
    """Samples that are spikes of the given model (`held`) with more than even odds, mask (n,)."""
    sd = 1.4826 * float(np.median(np.abs(y)))
    scale = held.scale / (sd * np.sqrt(smooth.conditional_variance))
    return spike_odds(y / sd, min(held.rate / smooth.fs, MOST), scale) > 0


def _settled(
    hidden: Hidden, spiked: Array, smooth: Smooth, rng: np.random.Generator, clean: Array | None
) -> tuple[Array, Smooth]:
    """The clean rest and its spectrum: what was filled in under too loud a spectrum would make its
    neighbours surprising under a better one, and where much is clipped, under too quiet a one, it
    would not go far enough beyond the limit. `clean` is the former rest, or None.
    """
    many = np.mean(hidden.clipped) > MANY
    for _ in range(2 * ROUNDS if many else ROUNDS):
        clean = hidden.filled(spiked, smooth, rng, clean)
        before, smooth = smooth.conditional_variance, Smooth(clean, smooth.fs)
        change = smooth.conditional_variance / before
        if change > 0.9 and not (many and abs(change - 1) > STEADY):
            break
    assert clean is not None, "a round at the least has filled it"
    return clean, smooth


def _surprises(
    hidden: Hidden, clean: Array, smooth: Smooth, rng: np.random.Generator
) -> tuple[Array, Smooth, Array]:
    """(surprises of the samples, the spectrum they are held against, samples that stand for a spike
    found beside them).
    """
    measured = np.where(hidden.mask, clean, hidden.rest)
    probe, even = measured, smooth
    step = None if hidden.grid is None else hidden.grid[0]
    if step is not None and step > DITHER * np.sqrt(smooth.conditional_variance):
        # a few levels have no median and no shoulders: spread each over its own width
        dither = step * (rng.random(len(probe)) - 0.5)
        probe, even = probe + dither, Smooth(clean + dither, smooth.fs)
    y, instead = deconvolved(surprises(probe, even), even)
    y[hidden.mask | _edges(measured, y)] = 0.0
    for end in (y[:64], y[-64:]):
        # a filter that starts up is no spike, unless it is one by eye
        end[np.abs(end) < 20] = 0.0
    return y, even, instead


def _edges(x: Array, y: Array, *, reach: int = 4) -> np.ndarray:
    """Surprises where the level before differs from the level after by most of the surprise: a
    jump, not a spike; mask (n,).
    """
    at = np.flatnonzero(np.abs(y) > 4.5)
    at = at[(at > reach + 1) & (at < len(x) - reach - 2)]
    # the surprises beside a spike are its shadow
    at = (
        at[np.abs(y[at]) >= np.max(np.abs(y[at[:, None] + np.arange(-reach, reach + 1)]), axis=1)]
        if len(at)
        else at
    )
    out = np.zeros(len(x), bool)
    if len(at) == 0 or len(at) > len(x) // 50:
        return out
    lag = np.arange(2, reach + 2)

    def levels(at: Array) -> tuple[Array, Array]:
        return np.median(x[at[:, None] - lag], axis=1), np.median(x[at[:, None] + lag], axis=1)

    before, after = levels(at)
    far = np.maximum(np.abs(x[at] - before), np.abs(x[at] - after))
    # a filtered signal moves as much anywhere
    usual = 1.4826 * np.median(
        np.abs(np.subtract(*levels(np.linspace(reach + 2, len(x) - reach - 3, 4000).astype(int))))
    )
    jump = at[np.abs(after - before) > np.maximum(0.7 * far, 3.5 * usual)]
    for k in (-1, 0, 1):
        out[jump + k] = True
    return out
