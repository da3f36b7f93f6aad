"""What the vehicle shows, as steps of the report: turned axes, a turned case, a wrong heading."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.drive import Drive
from imu_lib.units import DEG

from . import vehicle
from .battery import Battery
from .left import ANGLES, Turned
from .steps import SUREST, Step, step

SAME_ARM = 3.0  # standard deviations, of the arm and of the case's turn, by which arms differ
TURNED_BEFORE = (
    "The search turns the axes first: innovations before are those with the axes already turned, "
    "outages before those with the axes as they are in the file."
)


def axes(
    permutation: Sequence[str],
    sure: float,
    runner: Sequence[str],
    gain: float,
    alike: Sequence[Sequence[str]],
    before: Battery,
) -> Step:
    """The step of turned axes, from what `navigation.axes.of` finds."""
    where = (
        "the readings follow the fixes' accelerations and turns when x, y, z of the file are "
        f"taken as {', '.join(permutation)}"
    )
    out = step(
        "axes", ({"permutation": list(permutation)}, {}), sure,
        {"effect": f"axes {' '.join(runner)}", "confidence": float(1.0 - sure)}, [],
        (before.index, before.index), gain, where,
    )  # fmt: skip
    if alike:
        out["indistinguishable"] = [f"axes {' '.join(p)}" for p in alike]
    return out


def mounting(turned: Turned | None, after: Battery) -> list[Step]:
    """The step, in a list, where the case is turned beyond doubt."""
    if turned is None or not vehicle.beyond_doubt(turned):
        return []
    angles, sd = turned
    sizes = np.abs(angles) / sd
    names = ANGLES
    k = int(np.argmax(sizes))
    gain = 0.5 * float(np.sum(sizes**2))
    where = (
        f"on straights the velocity lies {abs(angles[2]) / DEG:.1f} deg aside of the case's x and "
        f"{abs(angles[1]) / DEG:.1f} deg above or below it ({names[k]} stands out most)"
    )
    return [
        step(
            "mounting",
            (
                {n: float(a) for n, a in zip(names, angles)},
                {
                    n: [float(a - 1.96 * s), float(a + 1.96 * s)]
                    for n, a, s in zip(names, angles, sd)
                },
            ),
            SUREST,
            {"effect": "nothing", "confidence": float(np.exp(-min(gain, 700.0)))},
            [],
            (after.index, after.index),
            gain,
            where,
        )  # fmt: skip
    ]


def heading(apart: float, sd: float, after: Battery, whose: str = "") -> list[Step]:
    """The step, in a list, where the heading given at the start is wrong beyond doubt; whose: words
    for where it was given.
    """
    sd = float(np.hypot(sd, 2.0 * DEG))
    if abs(apart) < 5.0 * sd:
        return []
    gain = 0.5 * (apart / sd) ** 2
    where = (
        "the path's own heading at the start, carried back by the gyros, is "
        f"{abs(apart) / DEG:.0f} deg off the one given{whose}"
    )
    return [
        step(
            "heading",
            ({"error": apart}, {"error": [apart - 1.96 * sd, apart + 1.96 * sd]}),
            SUREST,
            {"effect": "nothing", "confidence": 0.0},
            [],
            (after.index, after.index),
            gain,
            where,
        )  # fmt: skip
    ]


def arm_of_vehicle(found: list[Step], drive: Drive, turned: Turned | None) -> list[str]:
    """The lever arm in the vehicle's axes, with what the file gave. Where that is no other than the
    file's, in a case turned by `turned`, it is no effect: its step leaves, and a note says so.
    """
    one = next((one for one in found if one["effect"] == "lever_arm"), None)
    if one is None:
        return []
    given = np.zeros(3) if drive.lever_arm is None else np.asarray(drive.lever_arm)
    arm = given + np.array(one["parameters"]["arm"])
    half = np.array([0.5 * (b - a) for a, b in one["intervals"]["arm"]])
    if turned is not None:
        of_vehicle = Rotation.from_euler("ZYX", turned[0][::-1]).apply(arm)
        sd = np.hypot(half / 1.96, np.linalg.norm(given) * turned[1].max())
        if given.any() and np.all(np.abs(of_vehicle - given) < SAME_ARM * sd):
            found.remove(one)
            angles = ", ".join(f"{a / DEG:.1f}" for a in turned[0])
            return [
                "The file's lever arm holds, in the vehicle's axes: the case is turned against "
                f"them (roll, pitch, yaw {angles} deg)."
            ]
        if any(step["effect"] == "mounting" for step in found):
            arm = of_vehicle
    one["parameters"]["arm"] = [float(a) for a in arm]
    one["intervals"]["arm"] = [[float(a - h), float(a + h)] for a, h in zip(arm, half)]
    return []
