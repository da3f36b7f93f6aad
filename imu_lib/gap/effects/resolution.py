"""Rounding to a grid."""

from __future__ import annotations

import numpy as np

from imu_lib.processes import Resolution as Stage

from .base import Effect, Finding

#: Share of the samples whose values have to come again where some lie off the grid.
MOST = 0.97


def grid_of(x) -> tuple[float, float] | None:
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


class Resolution(Effect):
    name = "resolution"
    cause = (
        "The analogue-to-digital converter, or the number format of the output, rounds to a step."
    )
    domain = "distribution"

    def detect(self, x, sd: float, held: float | None) -> Finding | None:
        """`sd` is the standard deviation of the fast noise, `held` the step that the base model
        has.
        """
        found = grid_of(x)
        if found is None:
            return None
        step, _ = found
        single = np.spacing(np.float32(np.abs(x).max()))
        if held is not None and abs(step / held - 1) < 0.02:
            return None
        if step < sd / 100 or (step <= 4 * single and step < sd / 20):
            return None  # the number format of the file, not the sensor
        levels = len(np.unique(x))
        return Finding(
            self,
            Stage(lsb=step),
            None,
            f"distribution of the samples: {levels} distinct values, all on a grid of step {step:.4g}",
            {"lsb": [step * (1 - 1e-6), step * (1 + 1e-6)]},
            doubt=missing_codes(x, step),
        )


def missing_codes(x, step) -> str | None:
    """A sentence where the levels are occupied as no rounding of a smooth noise would occupy them."""
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
        return f"distribution of the samples: {np.count_nonzero(off & sure)} levels of the grid occupied unlike their neighbours"
    return None


EFFECTS = (Resolution(),)
