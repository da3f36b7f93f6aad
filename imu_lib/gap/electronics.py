"""What the electronics did to a channel, found first and undone: rounding, clipping, frozen
samples, spikes, missing samples.

Everything else assumes a Gaussian signal, so that these come first; the samples they touch are
drawn
anew given the others under the spectrum of the record itself, not of the base model, which may be
wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.gap.data import Data
from imu_lib.gap.effects.quantization import Quantization
from imu_lib.gap.effects.resolution import Resolution, grid_of
from imu_lib.gap.effects.saturation import Saturation
from imu_lib.gap.effects.sinusoid import Sinusoid
from imu_lib.gap.effects.spikes import Spikes
from imu_lib.gap.effects.step import sharpen
from imu_lib.gap.effects.stuck import Stuck
from imu_lib.gap.imputation import first_fill, impute
from imu_lib.gap.innovations import Smooth, surprises
from imu_lib.gap.outliers import deconvolved
from imu_lib.gap.rounding import COARSE, Rounding
from imu_lib.processes import Quantization as OfIntegral
from imu_lib.processes import Resolution as Grid

#: Share of the mean spectrum below which a bin holds little but what was filled in for missing
#: samples.
EMPTY = 3e-3
#: Steps of the grid, in standard deviations of what the other samples leave open, from which on
#: the levels show in the innovations.
DITHER = 0.3


@dataclass
class Clean:
    """A channel with the electronics undone.

    `x` is clean, `coarse` the deterministic part (lines, gross jumps) that was set aside
    meanwhile, `findings` what was
    found, `white` the variance of rounding left in every sample, `smooth` the spectrum of `x -
    coarse`, `step` the grid,
    `of_integral` the quantization where it is the integral that is rounded, `blind` the bins of
    the spectrum where samples
    that were filled in (`filled` many) are stronger than the signal, `swing` how a coarse grid
    lets the noise rise and fall (n,), 1 where it does not.
    """

    x: np.ndarray
    coarse: np.ndarray
    findings: list
    white: float
    smooth: Smooth
    step: float | None
    extra: np.ndarray | None = None
    swing: np.ndarray | float = 1.0
    of_integral: OfIntegral | None = None
    blind: np.ndarray | None = None
    filled: int = 0


def gross_jumps(x, fs) -> np.ndarray:
    """The jumps that stand out of a channel by eye, as a signal to set aside, shape (n,)."""
    q = max(1, int(round(0.5 * fs)))
    k = len(x) // q
    out = np.zeros(len(x))
    if k < 60:
        return out
    y = x[: k * q].reshape(k, q).mean(axis=1)
    c = np.concatenate([[0.0], np.cumsum(y)])
    w = 6
    i = np.arange(w, k - w + 1)
    jump = (c[i + w] - 2 * c[i] + c[i - w]) / w
    sd = 1.4826 * np.median(np.abs(jump - np.median(jump)))
    fast_sd = np.median(np.abs(np.diff(x[::3]))) / 0.954
    strong = np.abs(jump)
    for _ in range(400):
        j = int(np.argmax(strong))
        if strong[j] < 9 * sd or strong[j] < 0.3 * fast_sd:
            break
        density = fast_sd**2 / fs
        edge = sharpen(x, fs, i[j] * q / fs, 1.0, jump[j], density)
        at = int(round((edge[0] if edge else i[j] * q / fs) * fs))
        a = x[max(0, at - w * q) : at].mean() if at > 0 else x[0]
        b = x[at : at + w * q].mean()
        out[at:] += b - a
        strong[max(0, j - w) : j + w + 1] = 0.0
    return out


def undo(raw, fs: float, base, rng, *, integral: bool = False, known=None) -> Clean:
    """Find and undo what the electronics did to `raw` (NaN where a sample is missing); `base` is
    the channel's model (`Sum`).

    `known`, shape (n,), is what the record is known to put into the channel (vibration): it is in
    the samples that are rounded and clipped, and not in what is clean.
    A grid is taken for that of a rounded integral whose increments are read out where `integral`
    is set.
    """
    missing = np.isnan(raw)
    held = {s.name: s for s in base.stages} if base is not None else {}
    good = raw[~missing]
    findings = []
    fast_sd = float(np.median(np.abs(np.diff(good))) / 0.954)
    grid = grid_of(good)
    step = grid[0] if grid else None
    if step is not None and fast_sd < step:
        fast_sd = float(np.std(np.diff(good)) / np.sqrt(2))
    rounded = Resolution().detect(
        good, max(fast_sd, 1e-300), held["resolution"].lsb if "resolution" in held else None
    )
    if step is not None and rounded is None and "resolution" not in held:
        step = grid = None  # a number format, too fine to matter
    of_integral = OfIntegral.of_grid(step, fs) if integral and step is not None else None
    if of_integral is not None:
        if integral_of(base, step, fs) is None:
            findings.append(
                Quantization().on_grid(
                    of_integral,
                    step,
                    len(np.unique(good)),
                    None if rounded is None else rounded.doubt,
                )
            )
    elif rounded is not None:
        findings.append(rounded)
    clipped = Saturation().detect(good, step, held.get("saturation"))
    side = np.zeros(len(raw), np.int8)
    if clipped is not None:
        findings.append(clipped)
        side[~missing] = clipped.mask
    elif "saturation" in held:
        limit, low = held["saturation"].limit, held["saturation"].low
        low = -limit if low is None else low
        half = 0.5 * (step or 0.0) + 1e-9 * abs(limit)
        side[~missing] = np.where(good >= limit - half, 1, np.where(good <= low + half, -1, 0))
    x = first_fill(raw, missing)
    known = np.zeros(len(x)) if known is None else known
    coarse = known + gross_jumps(x - known, fs)
    lines, _ = Sinusoid().find(Data(x - coarse, fs))
    for _, signal in lines:
        coarse = coarse + signal
    smooth = Smooth(x - coarse, fs)
    stuck = Stuck().detect(
        x,
        side != 0,
        None if step is None else Rounding(x, smooth, grid).twin(rng, of_integral),
        held.get("stuck"),
    )
    bad = missing.copy()
    if stuck is not None:
        findings.append(stuck)
        bad |= stuck.mask
    above = (side > 0, raw[side > 0].min() - 0.5 * (step or 0.0) if (side > 0).any() else 0.0)
    below = (side < 0, raw[side < 0].max() + 0.5 * (step or 0.0) if (side < 0).any() else 0.0)
    hidden = bad | (side != 0)
    rest = x - coarse
    spikes, spiked = None, np.zeros(len(x), bool)
    for _ in range(5):
        if (hidden | spiked).any():
            # what was filled in under too loud a spectrum would make its neighbours surprising
            # under a better one
            for _ in range(5):
                clean = _fill(
                    rest, hidden & (side == 0) | spiked, above, below, coarse, smooth, rng, grid
                )
                before, smooth = smooth.conditional_variance, Smooth(clean, fs)
                if smooth.conditional_variance > 0.9 * before:
                    break
        else:
            clean = rest
        measured = np.where(hidden, clean, rest)
        probe, even = measured, smooth
        if step is not None and step > DITHER * np.sqrt(smooth.conditional_variance):
            # a few levels have no median and no shoulders: spread each over its own width
            dither = step * (rng.random(len(probe)) - 0.5)
            probe, even = probe + dither, Smooth(clean + dither, fs)
        y, instead = deconvolved(surprises(probe, even), even)
        y[hidden | _edges(measured, y)] = 0.0
        for end in (y[:64], y[-64:]):
            end[np.abs(end) < 20] = (
                0.0  # a filter that starts up is no spike, unless it is one by eye
            )
        new = Spikes().detect(y[~hidden], even, held.get("spikes"))
        if new is None and "spikes" not in held:
            spikes = None
            break
        count = spiked.sum()
        spiked = np.zeros(len(x), bool)
        if new is not None:
            spiked[np.flatnonzero(~hidden)[new.mask]] = True
            spikes = new
        else:
            spiked[np.abs(y) > 5] = True
        spiked |= instead & ~hidden
        if abs(int(spiked.sum()) - int(count)) <= 0.01 * count:
            break
    if spikes is not None:
        findings.append(spikes)
    if (hidden | spiked).any():
        clean = _fill(rest, hidden & (side == 0) | spiked, above, below, coarse, smooth, rng, grid)
        smooth = Smooth(clean, fs)
    white, extra = 0.0 if step is None or integral else step**2 / 12.0, None
    swing = 1.0
    if step is not None and not integral and step > COARSE * np.sqrt(smooth.sample_variance):
        rounding = Rounding(clean + coarse, smooth, grid)
        extra, swing = rounding.extra(rng), rounding.swing
        k = smooth.layout.slow
        white = float(np.mean(extra[k : k + 12]) * fs / 2)
    blind = smooth.level < EMPTY * np.mean(smooth.on(2048)) if (hidden | spiked).any() else None
    return Clean(
        clean + coarse - known,
        coarse - known,
        findings,
        white,
        smooth,
        step,
        extra,
        swing,
        of_integral,
        blind,
        int(np.count_nonzero(hidden | spiked)),
    )


def may_be_of_integral(raw, step: float, fs: float) -> bool:
    """Whether the spectrum leaves room for the errors of a rounded integral, which are strongest
    at half the sampling rate.
    """
    smooth = Smooth(first_fill(raw, np.isnan(raw)), fs)
    top = smooth.layout.frequency > 0.45 * fs
    return bool(
        np.mean(smooth.level[top])
        > 0.9 * np.mean(OfIntegral.of_grid(step, fs).psd(smooth.layout.frequency[top], fs))
    )


def integral_of(base, step: float, fs: float) -> OfIntegral | None:
    """The quantization of a base model that a grid of `step` would come of, if it has one."""
    want = OfIntegral.of_grid(step, fs).Q
    if base is None or any(
        isinstance(s, Grid) and abs(s.lsb / step - 1) < 0.02 for s in base.stages
    ):
        return None
    return next(
        (t for t in base.terms if isinstance(t, OfIntegral) and abs(t.Q / want - 1) < 0.02), None
    )


def _edges(x, y, *, reach: int = 4) -> np.ndarray:
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

    def levels(at):
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


def _fill(rest, bad, above, below, coarse, smooth, rng, grid):
    if not (above[0].any() or below[0].any()):
        return impute(rest, bad, smooth, rng)
    # the limits hold for the whole signal: for the rest of it they move with what was set aside
    whole = impute(rest, bad | above[0] | below[0], smooth, rng)
    out = impute(
        rest,
        bad,
        smooth,
        rng,
        above=(above[0], above[1] - float(np.median(coarse[above[0]]))) if above[0].any() else None,
        below=(below[0], below[1] - float(np.median(coarse[below[0]]))) if below[0].any() else None,
    )
    if grid is not None:  # clipped samples were rounded, too
        step, offset = grid
        out = np.where(
            above[0] | below[0],
            offset + np.rint((out + coarse - offset) / step) * step - coarse,
            out,
        )
    return np.where(bad & ~above[0] & ~below[0], whole, out)
