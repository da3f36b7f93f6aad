"""The gap on a drive, from the file to the report: axes, large time errors, the search, what a
vehicle cannot do, and what the answer is worth in outages that the search has not seen.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect
from imu_lib.model import Model
from imu_lib.navigation import axes

from . import (
    admission,
    evidence,
    left,
    outage,
    reliability,
    select,
    steps,
    vehicle,
    vehicle_steps,
    worth,
)
from .battery import Battery, battery
from .problem import turn_on_of, with_constants
from .searched import Searched, searched
from .start import Say
from .state import State
from .steps import Step


@dataclass(frozen=True)
class DriveReport:
    """What was found on a drive. steps, invisible : tuples of dict (the command's JSON); model :
    the error model with its key `drive`; before, after : `battery.Battery`; outages : `Outages` or
    None; unexplained : None or a sentence; state, first : for pictures; right : whether the
    innovations after are those of a right filter.
    """

    drive: Drive
    given: bool
    steps: tuple[Step, ...]
    invisible: tuple[dict[str, Any], ...]
    model: Model
    before: Battery
    after: Battery
    outages: outage.Outages | None
    unexplained: str | None
    notes: tuple[str, ...]
    state: State
    first: State
    right: bool

    def to_json(self) -> dict[str, Any]:
        """The content of `imu-lib gap DRIVE --json`."""
        return {
            "drive": {
                "name": self.drive.name,
                "steps": list(self.steps),
                "invisible": list(self.invisible),
                "innovations": {
                    "nis": {"before": self.before.nis, "after": self.after.nis},
                    "whiteness": {
                        "before": self.before.whiteness,
                        "after": self.after.whiteness,
                    },
                    "gap": {"before": self.before.index, "after": self.after.index},
                },
                "outages": None if self.outages is None else self.outages.to_json(),
                "unexplained": self.unexplained,
                "notes": list(self.notes),
            }
        }


def close(
    drive: Drive,
    model: Model | None = None,
    *,
    seed: int = 0,
    heading: float | None = None,
    judge: bool = True,
    random: bool = True,
    say: Say | None = None,
) -> DriveReport:
    """Find what the filter does not know about a drive.

    model : of the sensor; its key `drive` is where the search starts; None: white noise and walks
    alike on the three axes, fitted to the drive
    heading : rad at the start, as somebody gives it; the first `reference_attitude` otherwise
    judge : compare outages before and after; random : search for changes of what is random too;
    say : callable, told what is done
    Raises InputError where the drive has too little to be searched.
    """
    say = say or (lambda text: None)
    rng = np.random.default_rng(seed)
    admission.check(drive)
    notes: list[str] = []
    drive = admission.one_solution(drive, notes)
    known = searched(drive, model, random, notes, say)
    state, noise, turned = known.state, known.noise, known.turned
    found, before, after = _named(known, rng)
    if known.turn[0] != axes.IDENTITY:
        notes.append(vehicle_steps.TURNED_BEFORE)
    found += vehicle_steps.mounting(turned, after)
    found += _heading(state, drive, heading, (_mount(found), after))
    notes += vehicle_steps.arm_of_vehicle(found, known.right, turned)
    unseen = left.invisible(state, turned)
    left.limited(found, unseen, drive.lever_arm)
    fitted = worth.ratios(state.noise, drive)
    original = known.original.with_drive(tuple(fitted))
    whole = noise.model if model is None else known.original
    whole = whole.with_drive((*fitted, *_effects(found)))
    wrong = left.absurd(found, state, after), left.clocks(state, after)
    rest, worse, result = left.unexplained(state, after), None, None
    if known.windows and judge:
        say("outages before and after")
        models = with_constants(original), with_constants(whole)
        result, more = outage.compare(drive, *models, known.windows)
        notes += more
    ratio = None if result is None else result.ratio()
    if ratio and ratio["low"] > 1.0:
        # nothing is taken that does not predict what the search has not seen
        whole, worse = original, left.worse(ratio["value"])
    elif ratio:
        notes += evidence.unproven(found, ratio)
    unexplained = "; ".join(t for t in (wrong[0], worse, wrong[1], rest) if t) or None
    right = after.right and not any((*wrong, worse))
    reliability.give(found, reliability.left(unexplained, right))
    notes += evidence.share(found, select.ridges(state.reg, state.kept))
    notes += evidence.widening(found)
    return DriveReport(
        drive, model is not None, tuple(found), tuple(unseen), whole, before, after, result,
        unexplained, tuple(dict.fromkeys(notes)), state, known.first, right,
    )  # fmt: skip


def _named(known: Searched, rng: np.random.Generator) -> tuple[list[Step], Battery, Battery]:
    """Steps of all but what the vehicle shows, and the batteries before and after."""
    state, first, noise = known.state, known.first, known.noise
    before = battery(first.problem, first.result.e, first.use, rng)
    after = battery(state.problem, state.result.e, state.use, rng)
    if not (state.kept or state.changes or state.restarts):
        before = after  # of one hypothesis there is one index, about the path as it is in the end
    found = steps.of(state, first, noise, rng, before)
    if found:  # the same innovations, and not their approximation about the path as it is
        found[-1]["gap_after"] = after.index
    if known.turn[0] != axes.IDENTITY:
        found.insert(0, vehicle_steps.axes(*known.turn, before))
    return found, before, after


def _heading(
    state: State, drive: Drive, heading: float | None, known: tuple[Array, Battery]
) -> list[Step]:
    """The step, in a list, of a wrong heading at the start; known: the mounting's angles and
    the battery.
    """
    mount, after = known
    given, whose = heading, ""
    if given is None and drive.reference_attitude is not None:
        given, whose = float(drive.reference_attitude[0, 2]), " by the reference's first attitude"
    if given is None:
        return []
    apart = vehicle.heading_error(state, given, mount)
    return [] if apart is None else vehicle_steps.heading(*apart, after, whose)


def _mount(found: Sequence[Step]) -> Array:
    """Angles of the mounting among the steps, rad (3,)."""
    for step in found:
        if step["effect"] == "mounting":
            return np.array([step["parameters"][k] for k in ("roll", "pitch", "yaw")])
    return np.zeros(3)


def _effects(found: Sequence[Step]) -> Iterator[DriveEffect]:
    """The steps as a model file holds them."""
    for step in found:
        yield DriveEffect.from_json(step)


__all__ = ["DriveReport", "close", "turn_on_of"]
