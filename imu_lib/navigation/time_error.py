"""Are the fixes stamped when they were taken? Turns that the gyros feel and the course shows, then
the innovations of a filter that estimates the offset.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect

from . import fix_noise, lateness, turns
from .filter import LooselyCoupled
from .filter_model import FilterModel
from .free import priors
from .innovations import LOST
from .preparation import Gnss

LEVER_SD = 1.5  # m: an antenna forward of the sensor looks like an early fix at constant speed
ROUNDS = 4
MOVING = 0.3  # s by which an offset may still move at the last of them


@dataclass(frozen=True)
class TimeError:
    """Offset of the stamps of the fixes, s (positive: late), of positions and of velocities (None
    without them), their standard deviations, the nats that the innovations gain by it, divided by
    the number of fixes that the correlation left in them makes worth one, and how fixes are taken
    without and with it, their standard deviations as large as the innovations ask.
    """

    offset: float
    velocity_offset: float | None
    sd: float
    velocity_sd: float | None
    gain: float
    gnss: Gnss
    corrected: Gnss

    @property
    def found(self):
        """Whether the fixes are late or early beyond doubt, by more than a few hundredths."""
        return self.gain > 20.0 and (
            abs(self.offset) > max(0.05, 4.0 * self.sd)
            or (
                self.velocity_offset is not None
                and abs(self.velocity_offset) > max(0.05, 4.0 * self.velocity_sd)
            )
        )

    def __str__(self):
        own = self.velocity_offset
        apart = own is not None and abs(own - self.offset) > 0.03
        said = (
            f"the fixes' positions are {_late(self.offset)}"
            if apart
            else f"the fixes are {_late(self.offset)}"
        )
        flags = f"--latency {self.offset:.2f}"
        if apart:
            said += f", their velocities {_late(own)}"
            flags += f" --velocity-latency {own:.2f}"
        return f"By the innovations {said} ({self.gain:.0f} nats): run again with {flags}."

    def notes(self):
        """Sentences on the fixes: how much larger than stated their errors are, and when they are
        stamped.
        """
        out = []
        for part, what, unit in (("position", "positions", "m"), ("velocity", "velocities", "m/s")):
            ratio = getattr(self.gnss, f"{part}_ratio")
            extra = getattr(self.gnss, f"{part}_extra")
            if extra > 0.01:
                out.append(
                    f"{extra:.2g} {unit} are added to the stated standard deviations of the "
                    f"fixes' {what}, as their innovations ask (--as-stated leaves them)."
                )
            if abs(ratio - 1.0) > 0.05:
                out.append(
                    f"The file states no standard deviations of the fixes' {what}; the usual ones "
                    f"are taken {ratio:.2g} times (--as-stated leaves them)."
                )
        return (*out, str(self)) if self.found else tuple(out)


def _late(offset):
    return f"stamped {abs(offset):.2f} s too {'late' if offset > 0.0 else 'early'}"


def whitened_length(innovations):
    """How many fixes one is worth, from the correlation of the innovations from one fix to the
    next: (1 + rho) / (1 - rho) of the largest of their six.
    """
    x = innovations.normalised[innovations.freedom > 0]
    rho = 0.0
    for column in x.T:
        column = column[np.isfinite(column)]
        if column.size > 50 and column.std() > 0.0:
            column = column - column.mean()
            rho = max(rho, float(column[1:] @ column[:-1] / (column @ column)))
    rho = min(rho, 0.98)
    return (1.0 + rho) / (1.0 - rho)


def time_error(drive: Drive, model: FilterModel, *, gnss: Gnss, **options) -> TimeError:
    """The offset of the fixes' stamps that the innovations ask for, with a lever arm estimated
    beside it.

    model, gnss, options : as for `LooselyCoupled`; offsets are beyond what they hold
    """
    own = drive.gnss_velocity is not None and gnss.velocity
    groups = ("gnss_time_offset", *(("velocity_offset",) if own else ()))
    free = {**priors(*groups), "lever_arm": LEVER_SD}
    start = turns.late(drive)
    if start is None:  # a road without turns: where the fixes' accelerations are those felt
        start = lateness.late(drive)[0]
    start = 0.0 if abs(start) < 0.5 else start
    held = model.held
    before = held.value("gnss_time_offset", "offset", 0.0)
    before = (before, held.value("gnss_time_offset", "velocity_offset", before))

    def run(at, free, gnss):
        offset = DriveEffect(
            "gnss_time_offset",
            {"offset": before[0] + at[0], "velocity_offset": before[1] + at[1]},
        )
        changed = model.with_(effects=(*model.effects, offset), free=free)
        return LooselyCoupled(drive, changed, gnss=gnss, **options).solve(moments=[])

    enlarged, base = fix_noise.settled(partial(run, (0.0, 0.0), {}), drive, gnss)
    at, taken = np.array([start, start]), enlarged
    for _ in range(ROUNDS):
        taken, solution = fix_noise.settled(
            partial(run, at, free), drive, gnss, start=taken, rounds=1
        )
        found = solution.estimates()
        value = found["gnss_time_offset offset"]
        velocity = found["velocity_offset velocity_offset"] if own else value
        step = np.array([value[0], velocity[0]])
        at = at + np.clip(step, -0.5, 0.5)
        if np.abs(step).max() < 0.01:
            break
    corrected, best = fix_noise.settled(partial(run, at, {}), drive, gnss)
    keep = np.zeros(len(drive.gnss_time), bool)
    keep[np.intersect1d(base.innovations.index, best.innovations.index)] = True
    length = whitened_length(best.innovations)
    gain = (best.innovations.total(keep) - base.innovations.total(keep)) / length
    if np.mean(best.innovations.rejected) > LOST or np.abs(step).max() > MOVING:
        gain = 0.0  # of a filter that has lost the drive, or an offset that it has not found
    return TimeError(
        float(at[0]),
        float(at[1]) if own else None,
        float(value[1]),
        float(velocity[1]) if own else None,
        float(gain),
        enlarged,
        corrected,
    )
