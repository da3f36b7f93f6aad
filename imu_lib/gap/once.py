"""One slow change from a level to another, for which a noise process has been taken."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.effects.step import Step as Jump
from imu_lib.gap.steps import Step
from imu_lib.units import G

if TYPE_CHECKING:
    from imu_lib.gap.channel import ChannelResult
    from imu_lib.gap.prepared import Prepared

#: Processes whose path a single change may be.
PROCESSES = ("gauss_markov", "gauss_markov_2", "random_walk", "flicker", "autoregressive")
#: Means of the record in which the change is looked for, and of them at the least on each level.
BLOCKS, LEVEL = 100, 15
#: Share of the variance of the means that the change explains, and its size in standard deviations
#: of what it leaves. Of 300 paths each, no random walk and no Gauss-Markov process does as much,
#: and of second order 1 % of those with a correlation time of a fifth of the record, 6 % of a
#: third, 21 % of the whole: such a record cannot tell.
SHARE, SIZE = 0.985, 12.0
#: Confidence of the process where a single change explains it as well.
DOUBTED = 0.5


def change(x: Array, fs: float) -> tuple[float, float, float] | None:
    """(from s, to s, size) of the one change of `x` (n,) from a level to another, by a straight
    line between them; None where that does not explain it.
    """
    size = len(x) // BLOCKS
    if size < 2:
        return None
    means = np.nanmean(x[: size * BLOCKS].reshape(BLOCKS, size), axis=1)
    if not np.isfinite(means).all():
        return None
    index = np.arange(BLOCKS)
    best = np.inf, 0, 0, 0.0
    total = float(np.sum((means - means.mean()) ** 2))
    for first in range(LEVEL, BLOCKS - LEVEL):
        for last in range(first, BLOCKS - LEVEL, 2):
            shape = np.clip((index - first + 0.5) / (last - first + 1), 0.0, 1.0)
            centred = shape - shape.mean()
            height = float(centred @ means / (centred @ centred))
            left = total - height**2 * float(centred @ centred)
            if left < best[0]:
                best = left, first, last, height
    left, first, last, height = best
    sd = np.sqrt(max(left, 0.0) / (BLOCKS - 4))
    if left > (1.0 - SHARE) * total or abs(height) < SIZE * sd:
        return None
    return first * size / fs, (last + 1) * size / fs, height


def doubted(results: dict[str, ChannelResult], about: Prepared) -> dict[str, ChannelResult]:
    """Results by channel in which a process is in doubt where one change has all of its power."""
    out, begin = dict(results), about.ready.start
    force = {c: float(np.nanmedian(x)) for c, x in about.raw.items() if c.startswith("accel")}
    gravity = np.linalg.norm(list(force.values())) if len(force) == 3 else None
    for name, result in results.items():
        named = [s for s in result.steps if s.effect in PROCESSES]
        if not named or any(s.effect == Jump.name for s in result.steps):
            continue
        found = change(about.raw[name], about.fs)
        if found is None:
            continue
        accel = bool(name in force and gravity is not None and abs(force[name]) < 0.3 * gravity)
        told = _words(name, begin, found, accel)
        steps = [_in_doubt(s, told, accel) if s in named else s for s in result.steps]
        out[name] = replace(result, steps=steps)
    return out


def _in_doubt(step: Step, told: str, accel: bool) -> Step:
    rivals = [*step.indistinguishable, Jump.name, *(["tilt"] if accel else [])]
    return replace(
        step.capped(DOUBTED),
        runner_up={"effect": Jump.name, "confidence": DOUBTED},
        indistinguishable=list(dict.fromkeys(rivals)),
        evidence=told,
    )


def _words(name: str, begin: float, found: tuple[float, float, float], accel: bool) -> str:
    start, stop, height = found
    gyro = name.startswith("gyro")
    size = f"{np.rad2deg(height):.3g} deg/s" if gyro else f"{height:.3g} m/s^2"
    tilt = f", as a slow tilt by {1e3 * abs(height) / G:.2g} mrad makes it" if accel else ""
    return (
        f"one slow change of the level by {size} from {begin + start:.0f} to {begin + stop:.0f} s"
        f"{tilt}"
    )
