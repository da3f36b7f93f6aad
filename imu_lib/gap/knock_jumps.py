"""Jumps of the bias at the moment of a knock: what was masked there is their cause."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from imu_lib.faults.finding import Finding, seconds
from imu_lib.gap.effects.step import Step as Jump
from imu_lib.gap.steps import Step

if TYPE_CHECKING:
    from imu_lib.gap.channel import ChannelResult
    from imu_lib.gap.prepared import Prepared

#: Seconds between a knock and the interval of a jump up to which they are one event.
APART = 0.5
#: How that is said after where the jump is.
WITH = ", with the knock at "
CAUSE = (
    "The knock moved the bias: stress in the package or in the mount was released, or the case was "
    "turned a little."
)


def with_causes(results: dict[str, ChannelResult], about: Prepared) -> dict[str, ChannelResult]:
    """Results by channel in which a jump that came with a knock says so."""
    knocks = [f for f in about.ready.findings if f.kind == "disturbance"]
    out = dict(results)
    for name, result in results.items() if knocks else ():
        steps = [_with_knock(s, knocks, about.ready.start) for s in result.steps]
        out[name] = replace(result, steps=steps)
    return out


def _with_knock(step: Step, knocks: list[Finding], begin: float) -> Step:
    """The step, its cause the knock where there was one; `begin` s the times of steps count
    from.
    """
    if step.effect != Jump.name or step.parameters.get("duration"):
        return step
    time = step.parameters["time"]
    low, high = step.intervals.get("time", (time, time))
    for knock in knocks:
        if knock.start - APART <= begin + high and begin + low <= knock.stop + APART:
            where = f"{step.where}{WITH}{seconds(knock.start)} s"
            return replace(step, where=where, cause=CAUSE)
    return step
