"""What the electronics did to a channel, found first and undone: rounding, clipping, frozen
samples, spikes, missing samples.

Everything else assumes a Gaussian signal, so that these come first; the samples they touch are
drawn anew given the others under the spectrum of the record itself, not of the base model, which
may be wrong.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.effects.quantization import Quantization
from imu_lib.gap.effects.resolution import Resolution, grid_of
from imu_lib.gap.effects.saturation import Saturation
from imu_lib.gap.effects.stuck import Stuck
from imu_lib.gap.gross_signals import gross_signals
from imu_lib.gap.spike_removal import Hidden, without_spikes
from imu_lib.processes import Quantization as OfIntegral
from imu_lib.processes import Resolution as Grid
from imu_lib.processes import Saturation as Range
from imu_lib.processes import Sum
from imu_lib.samples.imputation import first_fill
from imu_lib.samples.innovations import Smooth
from imu_lib.samples.rounding import COARSE, Rounding
from imu_lib.samples.uneven import Uneven, uneven

#: Share of the mean spectrum below which a bin holds little but what was filled in for missing
#: samples.
EMPTY = 3e-3


@dataclass
class Clean:
    """A channel with the electronics undone.

    `x` is clean, `coarse` the deterministic part (lines, gross jumps) that was set aside meanwhile,
    `findings` what was found, `white` the variance of rounding left in every sample, `smooth` the
    spectrum of `x - coarse`, `step` the grid, `of_integral` the quantization where it is the
    integral that is rounded, `blind` the bins of the spectrum where samples that were filled in
    (`filled` many) are stronger than the signal, `swing` how a coarse grid lets the noise rise and
    fall (n,), 1 where it does not, `uneven` whether its steps are.
    """

    x: np.ndarray
    coarse: np.ndarray
    findings: list[Finding]
    white: float
    smooth: Smooth
    step: float | None
    extra: np.ndarray | None = None
    swing: np.ndarray | float = 1.0
    of_integral: OfIntegral | None = None
    blind: np.ndarray | None = None
    filled: int = 0
    uneven: bool = False

    @property
    def rounding(self) -> np.ndarray | float:
        """Density that rounding leaves in the bins."""
        return 2.0 * self.white / self.smooth.fs if self.extra is None else self.extra


@dataclass(frozen=True)
class Levels:
    """The levels of the converter: their `step` and `grid` (step, offset), None where they are too
    fine to matter; the quantization where it is the integral that is rounded; what was found; the
    steps where they are not equally wide.
    """

    step: float | None
    grid: tuple[float, float] | None
    of_integral: OfIntegral | None
    findings: list[Finding]
    steps: Uneven | None = None


def undo(
    raw: Array,
    fs: float,
    base: Sum | None,
    rng: np.random.Generator,
    *,
    integral: bool = False,
    known: Array | None = None,
) -> Clean:
    """Find and undo what the electronics did to `raw` (NaN where a sample is missing); `base` is
    the channel's model (`Sum`).

    `known`, shape (n,), is what the record is known to put into the channel (vibration): it is in
    the samples that are rounded and clipped, and not in what is clean. A grid is taken for that of
    a rounded integral whose increments are read out where `integral` is set.
    """
    missing = np.isnan(raw)
    held: dict[str, Any] = {s.name: s for s in base.stages} if base is not None else {}
    levels = _levels(raw[~missing], fs, base, held.get("resolution"), integral)
    clipped, side = _clipped(raw, missing, levels, held.get("saturation"))
    x = first_fill(raw, missing)
    known = np.zeros(len(x)) if known is None else known
    coarse = known + gross_signals(x - known, fs)
    smooth = Smooth(x - coarse, fs)
    twin = None
    if levels.grid is not None:
        twin = Rounding(x, smooth, levels.grid, levels.steps).twin(rng, levels.of_integral)
    stuck = None
    if levels.steps is None or not _coarse(levels, smooth):  # on few wide steps neighbours agree
        stuck = Stuck().detect(x, side != 0, twin, held.get("stuck"))
    if clipped is not None:
        at = np.flatnonzero(side) / fs
        clipped = replace(clipped, where=f"{clipped.where}, from {at[0]:.1f} to {at[-1]:.1f} s")
    if stuck is not None:
        assert stuck.mask is not None, "it is found by its samples"
        first, last = timing.runs(stuck.mask)
        longest = first[np.argmax(last - first)] / fs
        stuck = replace(stuck, where=f"{stuck.where}, at {longest:.1f} s")
    bad = missing if stuck is None else missing | stuck.mask
    hidden = Hidden.of(raw, x - coarse, coarse, bad, side, levels.grid)
    spikes, spiked, clean, smooth = without_spikes(hidden, smooth, held.get("spikes"), rng)
    white, extra, swing = _rounded(clean + coarse, smooth, levels, integral, rng)
    drawn = hidden.mask | spiked
    return Clean(
        clean + coarse - known,
        coarse - known,
        [
            *levels.findings,
            *(f for f in (clipped, stuck, spikes) if f is not None and not f.held),
        ],
        white,
        smooth,
        levels.step,
        extra,
        swing,
        levels.of_integral,
        smooth.level < EMPTY * np.mean(smooth.on(2048)) if drawn.any() else None,
        int(np.count_nonzero(drawn)),
        levels.steps is not None,
    )


def _levels(good: Array, fs: float, base: Sum | None, held: Grid | None, integral: bool) -> Levels:
    """What the values of the samples say; `held` is the resolution of the given model."""
    fast_sd = float(np.median(np.abs(np.diff(good))) / 0.954)
    grid = grid_of(good)
    step = grid[0] if grid else None
    if step is not None and fast_sd < step:
        fast_sd = float(np.std(np.diff(good)) / np.sqrt(2))
    rounded = Resolution().detect(good, max(fast_sd, 1e-300), None if held is None else held.lsb)
    if step is not None and rounded is None and held is None:
        step = grid = None  # a number format, too fine to matter
    if not integral or step is None:
        steps = None if grid is None else uneven(good, *grid)
        return Levels(step, grid, None, [] if rounded is None else [rounded], steps)
    of_integral, findings = OfIntegral.of_grid(step, fs), []
    if integral_of(base, step, fs) is None:
        doubt = None if rounded is None else rounded.doubt
        findings = [Quantization().on_grid(of_integral, len(np.unique(good)), doubt)]
    return Levels(step, grid, of_integral, findings)


def _clipped(
    raw: Array, missing: Array, levels: Levels, held: Range | None
) -> tuple[Finding | None, Array]:
    """(finding or None, side of each sample: 1 at the upper limit, -1 at the lower, else 0); `held`
    is the saturation of the given model.
    """
    good, side, step = raw[~missing], np.zeros(len(raw), np.int8), levels.step
    clipped = Saturation().detect(good, step, held)
    if clipped is not None and levels.steps is not None and not _piled_up(good, step):
        clipped = None  # the last step is a wide one
    if clipped is not None:
        assert clipped.mask is not None, "it is found by its samples"
        side[~missing] = clipped.mask
    elif held is not None:
        low = -held.limit if held.low is None else held.low
        half = 0.5 * (step or 0.0) + 1e-9 * abs(held.limit)
        side[~missing] = np.where(good >= held.limit - half, 1, np.where(good <= low + half, -1, 0))
    return clipped, side


def _coarse(levels: Levels, smooth: Smooth) -> bool:
    """Whether the steps are as wide as the noise."""
    return levels.step is not None and levels.step > COARSE * np.sqrt(smooth.sample_variance)


def _piled_up(x: Array, step: float | None) -> bool:
    """Whether more samples lie on the level at an end than on the one before it."""
    counts = [np.count_nonzero(np.abs(x - end) < 0.5 * (step or 0.0)) for end in (x.max(), x.min())]
    beside = [
        np.count_nonzero(np.abs(x - end) < 1.5 * (step or 0.0)) - count
        for end, count in zip((x.max(), x.min()), counts)
    ]
    return any(count > other for count, other in zip(counts, beside))


def _rounded(
    x: Array, smooth: Smooth, levels: Levels, integral: bool, rng: np.random.Generator
) -> tuple[float, Array | None, Array | float]:
    """(variance that rounding leaves in every sample, density that it adds in the bands where that
    is not the same everywhere, how it lets the noise rise and fall).
    """
    if levels.step is None or levels.grid is None or integral:
        return 0.0, None, 1.0
    if levels.steps is None and not _coarse(levels, smooth):
        return levels.step**2 / 12.0, None, 1.0
    rounding = Rounding(x, smooth, levels.grid, levels.steps)
    extra, swing, k = rounding.extra(rng), rounding.swing, smooth.layout.slow
    return float(np.mean(extra[k : k + 12]) * smooth.fs / 2), extra, swing


def may_be_of_integral(raw: Array, step: float, fs: float) -> bool:
    """Whether the spectrum leaves room for the errors of a rounded integral, which are strongest
    at half the sampling rate.
    """
    smooth = Smooth(first_fill(raw, np.isnan(raw)), fs)
    top = smooth.layout.frequency > 0.45 * fs
    return bool(
        np.mean(smooth.level[top])
        > 0.9 * np.mean(OfIntegral.of_grid(step, fs).psd(smooth.layout.frequency[top], fs))
    )


def integral_of(base: Sum | None, step: float, fs: float) -> OfIntegral | None:
    """The quantization of a base model that a grid of `step` would come of, if it has one."""
    want = OfIntegral.of_grid(step, fs).Q
    if base is None or any(
        isinstance(s, Grid) and abs(s.lsb / step - 1) < 0.02 for s in base.stages
    ):
        return None
    return next(
        (t for t in base.terms if isinstance(t, OfIntegral) and abs(t.Q / want - 1) < 0.02), None
    )
