"""Jumps of several accelerometers at one time: the unit was tilted by less than the search for
tilts needs, or by less than the gyros can show. One cause, not a step a channel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.faults.finding import seconds
from imu_lib.faults.tilt import MEANS, angle_in_words, rotation
from imu_lib.gap.effects.step import Step as Jump
from imu_lib.gap.steps import Step

if TYPE_CHECKING:
    from imu_lib.gap.channel import ChannelResult
    from imu_lib.gap.prepared import Prepared

#: Seconds that two jumps of one cause may seem apart, beside their own intervals.
APART = 2.0
#: Share of the change that may lie along gravity, which a tilt leaves as it is.
ALONG = 0.3
#: Seconds on each side of the jump in which the gyros turn, and that tell their level.
TURN, LEVEL = 2.0, 20.0
#: Standard deviations of the gyros' noise from which on a turn would be seen, and by which it may
#: be off.
SEEN, OFF = 6.0, 4.0
#: Confidence where the gyros show the turn, and where they are too noisy to show any.
SHOWN, HIDDEN = 0.95, 0.8


def as_tilts(
    results: dict[str, ChannelResult], about: Prepared
) -> tuple[dict[str, ChannelResult], list[Step]]:
    """Results by channel without the steps that are tilts, and the tilts as steps of the record."""
    accels = [f"accel_{a}" for a in "xyz"]
    if any(c not in about.raw for c in accels):
        return results, []
    jumps = [
        (c, s) for c in accels if c in results for s in results[c].steps if s.effect == Jump.name
    ]
    jumps.sort(key=lambda item: item[1].parameters["time"])
    force = np.array([np.nanmedian(about.raw[c]) for c in accels])
    out, moved, at = dict(results), [], about.ready.start
    while jumps:
        group = [j for j in jumps if _together(j[1], jumps[0][1])]
        jumps = [j for j in jumps if j not in group]
        change = _change(group, accels)
        angles = None if change is None else _angles(change, force)
        if angles is None:
            continue
        time = float(np.median([s.parameters["time"] for _, s in group]))
        shown = _gyros_show(angles, time, about)
        if shown is False:
            continue
        if len(group) < 2:  # it may be the electronics of one axis as well
            for c, s in group:
                kept = [_or_tilt(other) if other is s else other for other in out[c].steps]
                out[c] = replace(out[c], steps=kept)
            continue
        step = _tilt(group, angles, at + time, shown)
        moved.append(step)
        for c, s in group:
            kept = [other for other in out[c].steps if other is not s]
            out[c] = replace(out[c], steps=kept)
    return out, moved


def _together(a: Step, b: Step) -> bool:
    reach = APART
    for s in (a, b):
        low, high = s.intervals.get("time", (0.0, 0.0))
        reach += 0.5 * (high - low)
    return abs(a.parameters["time"] - b.parameters["time"]) < reach


def _change(group: list[tuple[str, Step]], accels: list[str]) -> np.ndarray | None:
    """Change of the specific force, m/s^2; None where one axis jumps twice."""
    channels = [c for c, _ in group]
    if len(channels) != len(set(channels)):
        return None
    change = np.zeros(3)
    for c, s in group:
        change[accels.index(c)] = s.parameters["amplitude"]
    return change


def _angles(change: Array, force: Array) -> np.ndarray | None:
    """Angles by which a tilt makes the change, rad; None where none does."""
    up = force / np.linalg.norm(force)
    if abs(change @ up) > ALONG * np.linalg.norm(change):
        return None
    return rotation(force, force + change - (change @ up) * up)


def _or_tilt(step: Step) -> Step:
    """A step that may be a tilt as well."""
    return replace(step, indistinguishable=[*dict.fromkeys([*step.indistinguishable, "tilt"])])


def _tilt(group: list[tuple[str, Step]], angles: Array, time: float, shown: bool | None) -> Step:
    """The jumps of one moment as a tilt."""
    channels = [c for c, _ in group]
    size = angle_in_words(float(np.linalg.norm(angles)))
    seen = "the gyros turn with them" if shown else "by less than the gyros can show"
    sure = SHOWN if shown else HIDDEN
    return Step(
        "tilt",
        {"time": time, "angles": [float(a) for a in angles]},
        {},
        f"mean of the signal: {', '.join(channels)} jump together at {seconds(time)} s as "
        f"gravity does in a tilt of {size}, {seen}",
        min(sure, max(s.confidence for _, s in group)),
        {"effect": "step", "confidence": round(1.0 - sure, 4)},
        [] if shown else ["step"],
        gain=float(sum(s.gain or 0.0 for _, s in group)),
        cause=MEANS,
    )


def _gyros_show(angles: Array, time: float, about: Prepared) -> bool | None:
    """Whether the gyros turn by the angles; None where their noise is larger."""
    gyros = [f"gyro_{a}" for a in "xyz"]
    if any(c not in about.raw for c in gyros):
        return None
    off, seen = [], []
    for c, angle in zip(gyros, angles):
        x, fs = about.raw[c], about.fs
        k, turn, level = int(time * fs), int(TURN * fs) + 1, int(LEVEL * fs) + 1
        sides = np.r_[x[max(0, k - turn - level) : k - turn], x[k + turn : k + turn + level]]
        inside = x[max(0, k - turn) : k + turn]
        if len(sides) < level or not len(inside):
            return None
        turned = np.nansum(inside - np.nanmedian(sides)) / fs
        blocks = sides[: len(sides) // len(inside) * len(inside)].reshape(-1, len(inside))
        sd = max(float(np.nanstd(np.nansum(blocks - np.nanmedian(sides), axis=1))) / fs, 1e-12)
        off.append(abs(turned - angle) / sd)
        seen.append(abs(angle) / sd)
    if max(seen) < SEEN:
        return None
    return bool(max(off) < OFF or max(off) < 0.3 * max(seen))
