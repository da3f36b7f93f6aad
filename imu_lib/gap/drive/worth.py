"""Whether a step of the search helps where it was not fitted: outages laid over the fixes that the
search may see. Those that the report tells stay withheld.

A noise is fitted to innovations from one fix to the next; an outage asks what is left of it after
half a minute. The two agree where the model is right, and only there.
"""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.drive_effects import DriveEffect
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.navigation import outages
from imu_lib.navigation.filter_model import FilterModel

from . import correct
from .effects import LINEAR
from .outage import GNSS
from .problem import Noise, with_constants
from .state import State
from .steps import KNOWN_WELL, usual

EVERY = 10.0  # s from one outage to the next
FEWEST = 5  # outages that say something


def ratios(noise: Noise, drive: Drive) -> list[DriveEffect]:
    """Ratios of the fixes' errors that are no findings: to the usual ones, fitted where the drive
    states none, and to the stated ones where these are nearly right.
    """
    out = []
    for of in ("position", "velocity"):
        ratio, stated = getattr(noise, of), getattr(drive, f"gnss_{of}_sd") is not None
        if ratio != 1.0 and (not stated or KNOWN_WELL[0] < ratio < KNOWN_WELL[1]):
            out.append(DriveEffect("gnss_noise", {"ratio": ratio, "of": of}))
    return out


def held(state: State) -> Model:
    """The model file that a state amounts to."""
    out = ratios(state.noise, state.drive)
    for effect in state.kept:
        if effect not in LINEAR:
            continue
        values = correct.value(state.theta, effect)
        if effect == "lever_arm" and state.drive.lever_arm is not None:
            values = values + state.drive.lever_arm
        out.append(DriveEffect(effect, LINEAR[effect].parameters(values)))
    for found in state.changes:
        if not usual(state, found):
            out.append(DriveEffect(found.change.effect, found.change.describe(found.values)))
    return with_constants(state.base.model.with_drive(out))


def no_worse(before: State, after: State) -> bool:
    """Whether errors in outages grow by no more than what chance makes of their mean: one standard
    error, on the logarithm (Breiman et al. 1984 choose by as much among models that do alike).
    """
    drive, withheld = after.drive, after.withhold
    if not withheld:
        return True
    duration = withheld[0][1]
    try:
        laid = outages.regular_windows(
            drive, duration=duration, every=EVERY, settle=min(120.0, 0.25 * drive.duration)
        )
    except InputError:
        return True
    free = [
        w
        for w in laid
        if all(w.start + duration <= start or w.start >= start + long for start, long in withheld)
    ]
    if len(free) < FEWEST:
        return True
    try:
        filters = {n: FilterModel.of(held(s)) for n, s in (("before", before), ("after", after))}
        study = outages.compare(drive, filters, free, gnss=GNSS, strict=False)
    except InputError:
        return True
    first, second = (study.errors(n, against="full_gnss") for n in filters)
    grown = np.log(np.maximum(second, 1e-3) / np.maximum(first, 1e-3))
    return bool(grown.mean() <= grown.std(ddof=1) / np.sqrt(grown.size))
