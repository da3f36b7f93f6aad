"""Rounding to a grid."""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import Resolution as Stage
from imu_lib.samples.uneven import uneven

from .base import Effect, Finding

#: Share of the samples whose values have to come again where some lie off the grid.
MOST = 0.97


def grid_of(x: Array) -> tuple[float, float] | None:
    """(step, offset) of the grid that the samples lie on, all but a few per cent, or None where
    they are continuous.
    """
    u, count = np.unique(x, return_counts=True)
    again = count > 1
    if count[again].sum() > MOST * len(x):  # spikes may be added behind the rounding
        u = u[again]
    if len(u) < 2 or len(u) > len(x) / 6:
        return None
    gap = np.diff(u)
    gap = gap[gap > 1e-7 * np.median(gap) + 4 * np.spacing(np.abs(u).max())]
    step = float(gap.min())
    for _ in range(2):  # refine: the least gap carries the rounding of two numbers
        k = np.rint((u - u[0]) / step)
        if k[-1] < 1:
            return None
        step = float(np.polyfit(k, u, 1)[0]) if len(u) > 2 else step
    off = np.abs((u - u[0]) / step - np.rint((u - u[0]) / step))
    if off.max() > 0.02 + 4 * np.spacing(np.abs(u).max()) / step:
        return None
    return step, float(u[0] - np.rint(u[0] / step) * step)


def printed(x: Array) -> float | None:
    """The step of the number format that the samples are printed in, however fine, or None where
    no two agree or they have no common step.
    """
    u = np.unique(x)
    if len(u) in (1, len(x)):
        return None
    gap = np.diff(u)
    step = float(gap[gap > 8 * np.spacing(np.abs(u).max())].min(initial=np.inf))
    place = (u - u[0]) / step
    return step if np.abs(place - np.rint(place)).max() < 0.05 else None


#: Concentration about the levels of a coarse grid from which on there is one under the printed
#: digits; cells of the histogram, and standard deviations in a step at the most.
CONCENTRATED, CELLS, WIDEST = 0.55, 8192, 2.8


def ladder(x: Array) -> tuple[float, float, np.ndarray] | None:
    """(step, width, samples on their levels) of a converter's grid that a calibration has blurred
    or bent and whose values are printed more finely, or None. `x` has shape (n,).

    Samples of a smooth distribution have no period; those of levels a step apart have one, which
    the transform of their histogram shows. `width` is the spread of the values about their level.
    """
    low, high = np.quantile(x, [0.002, 0.998])
    sd = 0.5 * float(np.diff(np.quantile(x, [0.16, 0.84]))[0])
    if not sd > 0:
        return None
    span = (high - low) * 1.0001
    count = np.bincount(
        ((x[(x >= low) & (x <= high)] - low) / span * CELLS).astype(int), minlength=CELLS
    )[:CELLS]
    strength = np.abs(np.fft.rfft(count, 4 * CELLS)) / count.sum()
    period = np.arange(len(strength)) / (4.0 * span)  # cycles per unit
    searched = (period > 1 / (WIDEST * sd)) & (period < CELLS / (8 * span))
    inside = np.flatnonzero(searched & (strength > CONCENTRATED))
    if len(inside) == 0:
        return None
    first = inside[inside < inside[0] + 40]
    step = 1.0 / period[first[int(np.argmax(strength[first]))]]
    levels, width = _levels(x, step)
    if levels is None or width > 0.2 * step:
        return None
    even = float(np.polyfit(np.arange(len(levels)), levels, 1)[0])
    whole = np.rint(np.interp(x, levels, np.arange(len(levels))))
    out = (x < levels[0]) | (x > levels[-1])
    whole[out] = np.rint((x[out] - levels[0]) / even)
    return even, width, levels[0] + even * whole


def _levels(x: Array, step: float) -> tuple[Array | None, float]:
    """Middles of the levels that lie about `step` apart, and how far samples scatter about them."""
    u, count = np.unique(x, return_counts=True)
    gap = np.flatnonzero(np.diff(u) > 0.35 * step)
    groups = np.split(np.arange(len(u)), gap + 1)
    middle = np.array([np.average(u[g], weights=count[g]) for g in groups])
    many = np.array([count[g].sum() for g in groups])
    keep = many > max(3, 1e-4 * len(x))
    middle, groups = middle[keep], [g for g, k in zip(groups, keep) if k]
    if len(middle) < 4:
        return None, np.inf
    jump = np.rint(np.diff(middle) / step)
    if np.any(jump != 1) and np.mean(jump == 1) < 0.7:
        return None, np.inf
    place = np.concatenate([[0], np.cumsum(np.maximum(jump, 1))])
    spread = np.sqrt(
        sum(np.sum(count[g] * (u[g] - m) ** 2) for g, m in zip(groups, middle))
        / sum(count[g].sum() for g in groups)
    )
    return np.interp(np.arange(place[-1] + 1), place, middle), float(spread)


class Resolution(Effect):
    name = "resolution"
    rounds = True
    of_design = "lsb"
    cause = (
        "The analogue-to-digital converter, or the number format of the output, rounds to a step."
    )
    domain = "distribution"

    def detect(self, x: Array, sd: float, held: float | None) -> Finding | None:
        """`sd` is the standard deviation of the fast noise, `held` the step that the base model
        has.
        """
        found = grid_of(x)
        if found is None:
            return None
        step, offset = found
        single = np.spacing(np.float32(np.abs(x).max()))
        if held is not None and abs(step / held - 1) < 0.02:
            return None
        if step < sd / 100 or (step <= 4 * single and step < sd / 20):
            return None  # the number format of the file, not the sensor
        levels, steps = len(np.unique(x)), uneven(x, step, offset)
        doubt = coarser(x, step)
        if doubt is None and steps is None:
            doubt = missing_codes(x, step)
        words = (
            ""
            if steps is None
            else f", whose steps are uneven: their widths scatter by {100 * steps.scatter:.2g} %"
        )
        return Finding(
            self,
            Stage(lsb=step),
            None,
            f"distribution of the samples: {levels} distinct values, all on one grid{words}",
            {"lsb": [step * (1 - 1e-6), step * (1 + 1e-6)]},
            doubt=doubt,
            counted=doubt is None,
        )


#: Parts of the samples in which the grid is looked at, share of them on a coarser one, and how much
#: coarser that is at the least.
PARTS, ON_IT, COARSER = 100, 0.98, 4


def coarser(x: Array, step: float) -> str | None:
    """A sentence where a part of the samples, at the end or at the beginning, has a coarser grid
    than the rest: the range was switched.
    """
    k = np.rint((x - x.min()) / step).astype(np.int64)
    if k.max() > 200_000 or len(k) < 20 * PARTS:
        return None
    for part, whole in ((k[-len(k) // 10 :], k[::-1]), (k[: len(k) // 10], k)):
        times = int(np.gcd.reduce(np.unique(part) - part.min()))
        if times < COARSER:
            continue
        on = (whole - part.min()) % times == 0
        share = on[: len(on) // PARTS * PARTS].reshape(PARTS, -1).mean(axis=1)
        length = int(np.argmax(share < ON_IT))
        if length < PARTS // 20 or share[length + 1 :].mean() > 0.5 + 1.0 / times:
            continue
        which = "first" if whole is k else "last"
        return (
            f"distribution of the samples: in the {which} {length} % of the record the steps are "
            f"{times} times as wide as in the rest"
        )
    return None


def missing_codes(x: Array, step: float) -> str | None:
    """A sentence where the levels are occupied as no rounding of a smooth noise would occupy
    them.
    """
    k = np.rint((x - x.min()) / step).astype(np.int64)
    if k.max() > 200_000:
        return None
    count = np.bincount(k).astype(float)
    if len(count) < 8:
        return None
    inner = count[2:-2]
    # the logarithm of a rounded normal's occupation is a parabola: each level against what its
    # neighbours foretell
    log = np.log(count + 0.5)
    want = np.exp((-log[:-4] + 4 * log[1:-3] + 4 * log[3:-1] - log[4:]) / 6)
    near = np.minimum.reduce([count[:-4], count[1:-3], count[3:-1], count[4:]])
    sure = np.maximum(want, inner) > 200
    sure &= (near > 50) | (inner > 50)
    if not sure.any():
        return None
    sd = want * np.sqrt(1 / np.maximum(want, 1) + 34 / 36 / (near + 0.5))
    off = np.abs(inner - want) > 8 * sd + 0.1 * want + 8 * np.sqrt(want)
    if np.count_nonzero(off & sure) >= 2:
        return (
            f"distribution of the samples: {np.count_nonzero(off & sure)} levels of the grid "
            "occupied unlike their neighbours"
        )
    return None


EFFECTS = (Resolution(),)
