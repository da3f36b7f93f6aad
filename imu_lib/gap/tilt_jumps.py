"""Jumps of several accelerometers at one time: the unit was tilted by less than the search for
tilts needs, or by less than the gyros can show. One cause, not a step a channel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.faults.finding import seconds
from imu_lib.faults.tilt import MEANS, angle_in_words
from imu_lib.faults.turn import rotation
from imu_lib.gap.effects.step import Step as Jump
from imu_lib.gap.ramped import Ramp, ramp_of
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
#: Confidence where the gyros show the turn, and where they are too noisy to show any; of a level of
#: one axis that takes its time, which a tilt about another axis changes as well.
SHOWN, HIDDEN, EITHER = 0.95, 0.8, 0.5


def as_tilts(
    results: dict[str, ChannelResult], about: Prepared
) -> tuple[dict[str, ChannelResult], list[Step]]:
    """Results by channel without the steps that are tilts, and the tilts as steps of the record."""
    accels = [f"accel_{a}" for a in "xyz"]
    if any(c not in about.raw for c in accels):
        return results, []
    jumps = [
        (c, s, _ramp(s, about.raw[c], about.fs))
        for c in accels
        if c in results
        for s in results[c].steps
        if s.effect == Jump.name
    ]
    jumps.sort(key=lambda item: item[1].parameters["time"])
    force = np.array([np.nanmedian(about.raw[c]) for c in accels])
    out, moved, at = dict(results), [], about.ready.start
    while jumps:
        group = _event(jumps)
        jumps = [j for j in jumps if j not in group]
        named = [(c, s) for c, s, _ in group]
        change = np.zeros(3)
        for c, s in named:
            change[accels.index(c)] += s.parameters["amplitude"]
        angles = _angles(change, force)
        if angles is None:
            continue
        ramp = max(group, key=lambda j: abs(j[1].parameters["amplitude"]))[2]
        shown = _gyros_show(angles, ramp, about)
        if shown is False:
            continue
        if len({c for c, _ in named}) < 2 and not shown:
            # it may be the electronics of one axis as well
            for c, s in named:
                kept = [_or_tilt(other, ramp) if other is s else other for other in out[c].steps]
                out[c] = replace(out[c], steps=kept)
            continue
        moved.append(_tilt(named, angles, at, ramp, shown))
        for c, s in named:
            kept = [other for other in out[c].steps if other is not s]
            out[c] = replace(out[c], steps=kept)
    return out, moved


def _ramp(step: Step, x: Array, fs: float) -> Ramp:
    """From when to when the level changes."""
    time, duration = step.parameters["time"], step.parameters.get("duration")
    return Ramp(time, time + duration) if duration else ramp_of(x, fs, time)


def _event(jumps: list[tuple[str, Step, Ramp]]) -> list[tuple[str, Step, Ramp]]:
    """The jumps of the moment of the first; of one axis more than one only where a slow change is
    told as several.
    """
    _, first, ramp = jumps[0]
    near = [j for j in jumps if _together(first, ramp, j[1], j[2])]
    if any(j[2].slow for j in near):
        return near
    channels = [c for c, _, _ in near]
    return [j for k, j in enumerate(near) if j[0] not in channels[:k]]


def _together(a: Step, of_a: Ramp, b: Step, of_b: Ramp) -> bool:
    reach = APART
    for s in (a, b):
        low, high = s.intervals.get("time", (0.0, 0.0))
        reach += 0.5 * (high - low)
    return of_a.meets(of_b, reach)


def _angles(change: Array, force: Array) -> np.ndarray | None:
    """Angles by which a tilt makes the change, rad; None where none does."""
    up = force / np.linalg.norm(force)
    if abs(change @ up) > ALONG * np.linalg.norm(change):
        return None
    return rotation(force, force + change - (change @ up) * up)


def _or_tilt(step: Step, ramp: Ramp) -> Step:
    """A step that may be a tilt as well; no more than even where it takes its time, as no
    electronics do.
    """
    other = replace(step, indistinguishable=[*dict.fromkeys([*step.indistinguishable, "tilt"])])
    return other.capped(EITHER) if ramp.slow else other


def _tilt(
    group: list[tuple[str, Step]], angles: Array, begin: float, ramp: Ramp, shown: bool | None
) -> Step:
    """The jumps of one event as a tilt, `begin` s after the first sample the times count from."""
    channels = list(dict.fromkeys(c for c, _ in group))
    size = angle_in_words(float(np.linalg.norm(angles)))
    seen = "the gyros turn with them" if shown else "by less than the gyros can show"
    sure = SHOWN if shown else HIDDEN
    time = float(np.median([s.parameters["time"] for _, s in group]))
    when = f"jump together at {seconds(begin + time)} s"
    if ramp.slow:
        time = 0.5 * (ramp.start + ramp.stop)
        when = f"change together from {begin + ramp.start:.0f} to {begin + ramp.stop:.0f} s"
    return Step(
        "tilt",
        {"time": begin + time, "angles": [float(a) for a in angles]},
        {},
        f"mean of the signal: {', '.join(channels)} {when} as gravity does in a tilt of {size}, "
        f"{seen}",
        min(sure, max(s.confidence for _, s in group)),
        {"effect": "step", "confidence": round(1.0 - sure, 4)},
        [] if shown else ["step"],
        gain=float(sum(s.gain or 0.0 for _, s in group)),
        cause=MEANS,
    )


def _gyros_show(angles: Array, ramp: Ramp, about: Prepared) -> bool | None:
    """Whether the gyros turn by the angles; None where their noise is larger."""
    gyros = [f"gyro_{a}" for a in "xyz"]
    if any(c not in about.raw for c in gyros):
        return None
    off, seen = [], []
    for c, angle in zip(gyros, angles):
        x, fs = about.raw[c], about.fs
        turn, level = int(TURN * fs) + 1, int(LEVEL * fs) + 1
        first, last = max(0, int(ramp.start * fs) - turn), int(ramp.stop * fs) + turn
        level = max(level, 3 * (last - first))
        sides = np.r_[x[max(0, first - level) : first], x[last : last + level]]
        inside = x[first:last]
        if len(sides) < level or not len(inside):
            return None
        turned = np.nansum(inside - np.nanmedian(sides)) / fs
        blocks = sides[: len(sides) // len(inside) * len(inside)].reshape(-1, len(inside))
        sd = float(np.nanstd(np.nansum(blocks - np.nanmedian(sides), axis=1))) / fs
        # a step of the converter for one sample is no turn
        sd = max(sd, _step(sides) / fs, 1e-12)
        off.append(abs(turned - angle) / sd)
        seen.append(abs(angle) / sd)
    if max(seen) < SEEN:
        return None
    return bool(max(off) < OFF or max(off) < 0.3 * max(seen))


def _step(x: Array) -> float:
    """Least distance of two samples that differ."""
    levels = np.unique(x[np.isfinite(x)])
    return float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0
