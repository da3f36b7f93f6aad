"""The gap on a drive, from the file to the report: axes, large time errors, the search, what a
vehicle cannot do, and what the answer is worth in outages that the search has not seen.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.navigation import axes, lateness
from imu_lib.navigation.held import Held
from imu_lib.units import DEG

from . import (
    admission,
    base_model,
    columns,
    correct,
    evidence,
    left,
    outage,
    reliability,
    search,
    select,
    steps,
    vehicle,
)
from .battery import battery
from .problem import Noise, turn_on_of, with_constants

REFITS = 3  # of the noise fitted to the drive, which holds what was not yet found
SEEN = 0.1  # s: from this offset of the fixes on, the search starts where the turns match best


@dataclass(frozen=True)
class DriveReport:
    """What was found on a drive. steps, invisible : tuples of dict (the command's JSON); model :
    the error model with its key `drive`; before, after : `battery.Battery`; outages : `Outages` or
    None; unexplained : None or a sentence; state, first : for pictures.
    """

    drive: Drive
    given: bool
    steps: tuple
    invisible: tuple
    model: Model
    before: object
    after: object
    outages: object
    unexplained: str | None
    notes: tuple
    state: object
    first: object

    def to_json(self):
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
    seed=0,
    heading=None,
    judge=True,
    random=True,
    say=None,
):
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
    notes = []
    drive = admission.one_solution(drive, notes)
    turn = axes.of(drive)
    say(f"axes {' '.join(turn[0])}")
    right = correct.axes_put_right(drive, turn[0])
    windows = outage.withheld(right)
    state, first, noise, original = _searched(right, model, (windows, random), notes, say)
    given = model is not None
    before = battery(first.problem, first.result.e, first.use, rng)
    after = battery(state.problem, state.result.e, state.use, rng)
    if not (state.kept or state.changes or state.restarts):
        before = after  # of one hypothesis there is one index, about the path as it is in the end
    found = steps.of(state, first, noise, rng, before)
    if found:  # the same innovations, and not their approximation about the path as it is
        found[-1]["gap_after"] = after.index
    if turn[0] != axes.IDENTITY:
        found.insert(0, steps.axes(*turn, before))
        notes.append(steps.TURNED_BEFORE)
    turned = vehicle.mounting(state.problem, attitude_sd(state))
    found += steps.mounting(turned, after)
    found += _heading(state, drive, heading, (_mount(found), after))
    steps.arm_of_vehicle(found, right, _mount(found))
    unseen = left.invisible(state, turned)
    left.limited(found, unseen, np.zeros(3) if drive.lever_arm is None else drive.lever_arm)
    fitted = _ratios(state.noise, drive)
    whole = original if given else noise.model
    whole = whole.with_drive((*fitted, *_effects(found)))
    original = original.with_drive(tuple(fitted))
    unexplained = left.unexplained(state, after)
    unexplained = "; ".join(t for t in (left.clocks(state), unexplained) if t) or None
    result = None
    if windows and judge:
        say("outages before and after")
        result, more = outage.compare(
            drive, with_constants(original), with_constants(whole), windows
        )
        notes += more
    if result is not None and (result.ratio() or {"low": 0.0})["low"] > 1.0:
        # nothing is taken that does not predict what the search has not seen
        whole, unexplained = original, left.worse(result.ratio()["value"], unexplained)
    elif result is not None and result.ratio():
        notes += evidence.unproven(found, result.ratio())
    unexplained = "; ".join(t for t in (left.absurd(found), unexplained) if t) or None
    reliability.give(found, unexplained is not None)
    notes += evidence.share(found, select.ridges(state.reg, state.kept))
    notes += evidence.widening(found)
    return DriveReport(
        drive, given, tuple(found), tuple(unseen), whole, before, after, result, unexplained,
        tuple(notes), state, first,
    )  # fmt: skip


def _searched(drive, model, asked, notes, say):
    """(state, first, noise, original): what is held at the end and before anything was, the noise
    under what is found, and the model before; asked: windows to withhold, and whether what is
    random is searched.
    """
    windows, random = asked
    theta, noise, given, original = _start(drive, model, notes)
    state = search.State(
        drive, noise, theta, withhold=tuple((w.start, w.duration) for w in windows)
    )
    _start_time(state, say)
    first = replace(state, theta=np.zeros_like(theta), kept=())
    first.rebuild()
    if not given:
        if state.kept:  # the noise of a path that is seconds off says nothing
            state.rebuild()
        state.noise = first.noise = base_model.fit(state if state.kept else first, say)
        original = first.noise.model
        first.weigh()
    search.run(state, given=given, random=random, say=say)
    noise = first.noise
    for _ in range(REFITS if not given else 0):
        again = base_model.anew(state, noise, say)
        if again is None:
            break
        noise = again
        search.run(state, given=given, random=random, say=say)
    return state, first, noise, original


def _heading(state, drive, heading, known):
    """The step, in a list, of a wrong heading at the start; known: the mounting's angles and
    the battery.
    """
    mount, after = known
    given, whose = heading, ""
    if given is None and drive.reference_attitude is not None:
        given, whose = float(drive.reference_attitude[0, 2]), " by the reference's first attitude"
    if given is None:
        return []
    apart = vehicle.heading_error(state.problem, given, mount, state.noise)
    return [] if apart is None else steps.heading(*apart, after, whose)


def _start_time(state, say):
    """Start where the turns of the fixes match those felt best, if the innovations agree: on roads
    without turns, or where fixes jump, a match is chance.
    """
    late, likeness, _ = lateness.best_match(correct.corrected(state.drive, state.theta))
    if abs(late) < SEEN:
        return
    moved = replace(state, theta=state.theta.copy(), kept=("gnss_time_offset",))
    moved.theta[columns.of("gnss_time_offset")] += late
    costs = []
    for tried in (state, moved):
        tried.rebuild()
        costs.append(tried.cost() / tried.use.sum())
    if costs[1] < costs[0]:
        state.take(moved)  # with its heading: that of a path seconds off is none
        state.result = None
        say(f"fixes are about {late:.1f} s late (turns agree by {likeness:.2f})")
    else:
        state.result = None


def _start(drive, model, notes):
    """Values, noise, whether a model was given, and the model without what it holds."""
    theta = np.zeros(len(columns.ALL))
    if model is None:
        plain = base_model.guess(drive)
        return theta, Noise(plain), False, plain
    missing = [c for c in columns.CHANNEL_NAMES if c not in model]
    if missing:
        raise InputError(
            f"the error model {model.name or ''} has no channel {missing[0]}; a drive needs all six"
        )
    noise = Noise(model.with_drive(()))
    angles = Held.of(model.drive).mounting
    turn = Rotation.identity() if angles is None else Rotation.from_euler("ZYX", angles[::-1])
    for effect in model.drive:
        values = effect.parameters
        part = columns.of(effect.name)
        if effect.name == "lever_arm":
            given = np.zeros(3) if drive.lever_arm is None else drive.lever_arm
            # of the vehicle's axes into the case's, in which the search runs
            theta[part] = turn.inv().apply(values["arm"]) - given
        elif effect.name == "gnss_time_offset":
            theta[part] = values["offset"], values.get("velocity_offset", values["offset"])
        elif part:
            theta[part] = np.ravel(next(iter(values.values())))
        elif effect.name == "gnss_noise":
            noise = noise.with_(**{values["of"]: values["ratio"]})
        elif effect.name == "gnss_correlated":
            noise = noise.with_(sigma=values["sigma"], tau=values["correlation_time"])
        elif effect.name == "gnss_outliers":
            noise = noise.with_(fraction=values["fraction"], scale=values["scale"])
        else:
            notes.append(f"{effect.name} of the model's key `drive` is searched for anew.")
    return theta, noise, True, model.with_drive(())


def _ratios(noise, drive):
    """Ratios of the fixes' errors to the usual ones, fitted where the drive states none."""
    return [
        DriveEffect("gnss_noise", {"ratio": getattr(noise, of), "of": of})
        for of in ("position", "velocity")
        if getattr(drive, f"gnss_{of}_sd") is None and getattr(noise, of) != 1.0
    ]


def attitude_sd(state):
    """How well the path knows its attitude, rad (3,): from the filter's own covariance."""
    return np.minimum(np.median(state.problem.attitude_sd, axis=0), 20 * DEG)


def _mount(found):
    for step in found:
        if step["effect"] == "mounting":
            return np.array([step["parameters"][k] for k in ("roll", "pitch", "yaw")])
    return np.zeros(3)


def _effects(found):
    for step in found:
        yield DriveEffect.from_json(step)


__all__ = ["DriveReport", "close", "turn_on_of"]
