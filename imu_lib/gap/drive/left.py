"""What of a drive is left: parameters that it does not show, and what no effect accounts for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation import fix_faults, lateness
from imu_lib.units import DEG

from . import columns, correct, displaced, readings, select, vehicle
from .battery import Battery
from .effects import CATALOGUE, LINEAR

if TYPE_CHECKING:
    from .state import State

Turned = tuple[Array, Array]  # angles of the mounting and their standard deviations, rad

ABSURD = 100.0  # times the model's level
NEAR = 2.0  # s between a jump of the fixes and the shock that it looks like
STEADY = 0.5  # s by which stamps of two halves may be late apart
SEEN = 3.0 * DEG  # of a mounting angle: what the drive does not show of it is said
SMOOTHED = "other: receiver's velocity is smoothed"
ALIKE = 3.0  # nats
APART = 3.5  # standard deviations from which on two time offsets are two
ANGLES = ("roll", "pitch", "yaw")


def invisible(state: State, turned: Turned | None) -> list[dict[str, Any]]:
    """Parameters that the drive does not excite, with upper limits; turned: the mounting's angles
    and their standard deviations, or None.
    """
    out = _angles_unseen(turned)
    for effect in LINEAR.values():
        if effect.name in ("gyro_bias", "accel_bias"):
            continue
        price = select.PER_EFFECT + select.PER_PARAMETER * len(effect.columns)
        seen = select.seen(state.reg, state.kept, effect.name)
        for i, x, sd, wide in zip(effect.columns, *seen):
            fixless = columns.ALL[i].component == "velocity_offset"
            if fixless and not state.use[:, 3].any():
                continue
            if effect.name in state.kept and abs(x) > APART * wide:
                continue  # larger than is usual, and seen for that
            # one as large as is usual would not gain the price of its name
            usual = 0.5 * max((columns.ALL[i].prior / sd) ** 2 - 1.0, 0.0)
            if usual < price:
                out.append(
                    {
                        "effect": effect.name,
                        "parameter": columns.ALL[i].component,
                        "why": effect.unexcited,
                        "upper_limit": float(abs(x) + 1.96 * wide),
                    }
                )
    return out


def _angles_unseen(turned: Turned | None) -> list[dict[str, Any]]:
    """Entries of the mounting's angles that would have to be larger than SEEN to be named."""
    if turned is None:
        why = "the drive is too slow for its direction to show the case's"
        return [
            {"effect": "mounting", "parameter": a, "why": why, "upper_limit": float(np.pi)}
            for a in ANGLES[1:]
        ]
    why = (
        "the path's own attitude is not known well enough: the fixes are too rough, or the "
        "drive turns and brakes too little"
    )
    return [
        {"effect": "mounting", "parameter": a, "why": why, "upper_limit": float(abs(x) + 1.96 * s)}
        for a, x, s, least in zip(ANGLES, *turned, vehicle.TURNED)
        if least * s > SEEN and abs(x) < least * s and a != "roll"
    ]


def unexplained(state: State, after: Battery) -> str | None:
    """None, or what is left: where on the drive, and in which innovation."""
    parts: list[str] = []
    jumps, sizes = fix_faults.jumps(state.drive) if state.restarts else ((), ())
    for when in state.restarts:
        near = [k for k, t in enumerate(jumps) if abs(t - when) < NEAR]
        if near:
            size = ", ".join(f"{v:.0f}" for v in sizes[near[0]])
            parts.append(
                f"at {jumps[near[0]]:.1f} s the fixes jump by {size} m (north, east, down) and "
                "stay there: another datum, base station or solution"
            )
            continue
        parts.append(
            f"a shock at {when:.0f} s: there the innovations are those of a filter that lost its "
            "motion at once, and of no effect in the catalogue"
        )
    for effect in state.kept:
        if effect.startswith("other: "):
            index = _index(state)
            x, _, _ = state.reg.solve(index)
            sizes = ", ".join(
                f"{columns.ALL[i].component} {x[index.index(i)]:.3g}"
                for i in columns.GROUPS[effect]
            )
            late = smoothed_delay(state) if effect == SMOOTHED else None
            sizes += "" if late is None else f"; late by {late:.3g} s"
            if effect == columns.STEP and state.step_at is not None:
                sizes += f"; at {state.step_at:.0f} s"
            if effect == columns.MOVED:
                sizes += f" m; from {state.moved_at:.1f} s on"
            parts.append(
                f"{effect.removeprefix('other: ')} ({sizes}), which is no effect of the catalogue"
            )
    parts += _unnamed(state)
    late = late_or_smoothed(state)
    if late is not None:
        parts.append(
            f"the velocities are late by {late:.3g} s and the positions are not: a receiver that "
            "smooths its velocities makes them as late, and this drive does not tell which"
        )
    parts += displaced.in_a_row(state)
    name, z = after.worst()
    if not after.right:
        parts.append(f"{name} ({abs(z):.0f} standard deviations from what a right filter shows)")
    return "; ".join(parts) or None


def _unnamed(state: State) -> list[str]:
    """What is said of changes of what is random that have no name in the catalogue."""
    return [
        f"{c.change.effect.removeprefix('other: ')} from fix to fix ({c.values[0]:.2g} m/s over "
        f"{c.values[1]:.2g} s, beside {state.noise.velocity:.2g} times the stated errors), "
        "which is no effect of the catalogue"
        for c in state.changes
        if c.change.effect not in CATALOGUE
    ]


def clocks(state: State, after: Battery) -> str | None:
    """None, or that the stamps of the fixes are not late by one time all along: nothing that
    innovations which are those of a right filter would leave unsaid.
    """
    if after.right:
        return None
    halves = lateness.of_halves(correct.corrected(state.drive, state.theta, state.moved_at))
    if halves is None or abs(halves[1] - halves[0]) < STEADY:
        return None
    return (
        f"beyond what was found, the fixes are {halves[0]:+.1f} s late in the first half of the "
        f"drive and {halves[1]:+.1f} s in the second: one of the clocks jumps or drifts"
    )


def _index(state: State) -> list[int]:
    """Numbers of the columns of all that is held."""
    return [i for e in state.kept for i in columns.GROUPS[e]]


def absurd(found: Sequence[dict[str, Any]], state: State, after: Battery) -> str | None:
    """What is said where the only noise that accounts for the innovations is one that no sensor
    has, or None: not of a white noise that the readings show as well, nor of one that is slower
    where the innovations are those of a right filter with it.
    """
    for step in found:
        p = step["parameters"]
        if step["effect"] == "bias_model" and p["name"] != "correlation_time" and p["from"]:
            white = p["process"] == "white_noise"
            shown = readings.shows(state.problem, p["channel"], p["to"]) if white else after.right
            if p["to"] > ABSURD * p["from"] and not shown:
                return (
                    f"{p['process']} of {p['channel']} would be {p['to'] / p['from']:.0f} times "
                    "the model's, which is no noise of a sensor: "
                    "the fixes and the readings are not of one time, body or unit, or the model "
                    "is of another sensor"
                )
    return None


def limited(
    found: Sequence[dict[str, Any]], unseen: Sequence[dict[str, Any]], given: Array | None
) -> None:
    """Give the components of found effects that the drive does not show the interval that their
    upper limit leaves; given (3,): the file's lever arm, beyond which that limit is.
    """
    lever = np.zeros(3) if given is None else given
    for step in found:
        for entry in unseen:
            key, _, part = entry["parameter"].partition(" ")
            if entry["effect"] != step["effect"] or key not in step["intervals"]:
                continue
            limit = entry["upper_limit"]
            if not part:
                step["intervals"][key] = [-limit, limit]
                continue
            names = [columns.ALL[i].component for i in columns.of(step["effect"])]
            k = names.index(entry["parameter"])
            middle = float(lever[k]) if step["effect"] == "lever_arm" else 0.0
            step["intervals"][key][k] = [middle - limit, middle + limit]


def worse(ratio: float) -> str:
    """What is said where the effects found make withheld outages worse."""
    return (
        f"what was found makes withheld outages worse ({ratio:.1f} times the error), so that "
        "the model file does not hold it"
    )


def smoothed_delay(state: State) -> float | None:
    """s, by which velocities that the receiver smooths are late, where the positions are not: its
    filter's own delay, and no offset of the stamps. None elsewhere.
    """
    if not {"gnss_time_offset", SMOOTHED} <= set(state.kept):
        return None
    index = _index(state)
    x, cov, _ = state.reg.solve(index)
    position, velocity = (index.index(i) for i in columns.of("gnss_time_offset"))
    if abs(x[position]) > APART * np.sqrt(cov[position, position]):
        return None
    return float(x[velocity])


def late_or_smoothed(state: State) -> float | None:
    """s, by which velocities are late where positions are not, if smoothing by a filter of that
    time constant does as well as stamps of their own: None elsewhere.
    """
    if "gnss_time_offset" not in state.kept or SMOOTHED in state.kept or not state.use[:, 3].any():
        return None
    index = [*_index(state), *columns.GROUPS[SMOOTHED]]
    x, cov, _ = state.reg.solve(index)
    position, velocity = (index.index(i) for i in columns.of("gnss_time_offset"))
    late = float(x[velocity])
    if abs(x[position]) > APART * np.sqrt(cov[position, position]) or late <= 0.0:
        return None
    part = slice(len(index) - len(columns.SMOOTHED), None)
    # one filter is a weight of one on its time constant, shared with a neighbour if it lies between
    above = int(np.clip(np.searchsorted(columns.SMOOTHED, late), 1, len(columns.SMOOTHED) - 1))
    one = np.zeros((11, len(columns.SMOOTHED)))
    one[:, above] = np.linspace(0.0, 1.0, 11)
    one[:, above - 1] = 1.0 - one[:, above]
    apart = [0.5 * d @ np.linalg.solve(cov[part, part], d) for d in (x[part], *(x[part] - one))]
    return late if min(apart[1:]) - apart[0] < ALIKE else None
