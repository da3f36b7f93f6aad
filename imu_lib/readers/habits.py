"""How people number and name axes: from 0 or 1, alpha beside omega, and units that an application
never writes.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from imu_lib.readers.asking import Asked, suggestion, units_too
from imu_lib.readers.names import SIGNALS, UNKNOWN, Meaning
from imu_lib.readers.raw import Raw
from imu_lib.readers.tokens import ROTATION


def numbered(raw: Raw, told: list[Meaning], headings) -> list[Meaning]:
    """Axes that are numbers: 0, 1, 2 or 1, 2, 3 by what the file holds."""
    out = list(told)
    for kind in (*SIGNALS, "alpha"):
        there = [
            i for i, m in enumerate(told) if m.quantity == kind and m.axis and m.axis.isdigit()
        ]
        if not there:
            continue
        digits = {told[i].axis for i in there}
        if "0" in digits and "3" in digits:
            # four numbers in a row are no three axes
            for i in there:
                out[i] = Meaning(
                    why="four numbered columns are no three axes; name them with --columns"
                )
            continue
        base = 0 if "0" in digits else 1 if "3" in digits else None
        if base is None:
            raise Asked(
                f"{raw.source}: {', '.join(f'`{headings[i].name}`' for i in there)} may be counted "
                f"from 0 or from 1; {suggestion(told, headings)}{units_too(told)}."
            )
        for i in there:
            axis = "xyz"[int(told[i].axis) - base]
            out[i] = replace(told[i], axis=axis, why=f"{told[i].why}, axes counted from {base}")
    return out


def alpha(told: list[Meaning]) -> list[Meaning]:
    """alpha is the accelerometer where omega is the gyro and nothing else is the accelerometer."""
    is_accel = any(m.quantity == "gyro" for m in told) and not any(
        m.quantity == "accel" for m in told
    )
    return [
        m
        if m.quantity != "alpha"
        else replace(
            m, quantity="accel", why="alpha beside omega: the accelerometer, as Kalibr names it"
        )
        if is_accel
        else Meaning(
            why="alpha is an angular acceleration, or the accelerometer where omega is the gyro"
        )
        for m in told
    ]


def letter_g(raw: Raw, told: list[Meaning], headings, values) -> None:
    """InputError where three columns that only the letter g names (`G(x)`) have the length of
    gravity in g all the time, and the file has no accelerometer: a g-force, or a gyro.
    """
    there = [i for i, m in enumerate(told) if m.quantity == "gyro" and m.axis in ("x", "y", "z")]
    lone = all(
        re.fullmatch(r"g[_ ]?[\[(]?[xyz][\])]?", headings[i].name.strip().lower()) for i in there
    )
    if len(there) != 3 or not lone or any(m.quantity in ("accel", "dv") for m in told):
        return
    if any(told[i].unit for i in there):
        return
    x = np.column_stack([np.asarray(values[i], dtype=float) for i in there])
    size = np.linalg.norm(x, axis=1)
    middle = float(np.nanmedian(size))
    if abs(middle - 1.0) > 0.05 or not np.nanmean(np.abs(size - middle)) < 0.05 * middle:
        return
    force = [
        replace(m, quantity="accel", unit="g") if i in there else m for i, m in enumerate(told)
    ]
    raise Asked(
        f"{raw.source}: `{headings[there[0]].name}` may be a gyro or a g-force; its three axes "
        f"have a length of {middle:.3g} all the time, which is "
        f"gravity in g; {suggestion(force, headings)}{units_too(force)} (gyro_x, gyro_y, gyro_z "
        "if it is a gyro)."
    )


def _turns(told: list[Meaning], headings) -> list[Meaning]:
    """rx, ry, rz beside an accelerometer are a rotation where no other column is the gyro, an
    attitude or a velocity: v beside r is that of a position.
    """
    if any(
        m.quantity in ("gyro", "dtheta") or m.why in ("an attitude", "a velocity") for m in told
    ):
        return told
    there = {h.name.strip().lower().replace("_", ""): i for i, h in enumerate(headings)}
    force = {m.axis for m in told if m.quantity == "accel"}
    rest = [there.get(f"r{a}") for a in "xyz"]
    if force != set("xyz") or None in rest or any(told[i].why != UNKNOWN for i in rest):
        return told
    if {"vx", "vy", "vz"} & set(there):
        return told
    out = list(told)
    for axis, i in zip("xyz", rest):
        out[i] = Meaning("gyro", axis, rank=2, why=f"{ROTATION}, beside an accelerometer")
    return out


def habits(told: list[Meaning], headings) -> list[Meaning]:
    """Units that an application writes always and names never: Physics Toolbox has its g-force
    (gFx) in g and its rates (wx) in rad/s.
    """
    heads = {h.name.strip().lower() for h in headings}
    if {"delta_angle_dt", "delta_velocity_dt"} <= heads:
        units = {"dtheta": "rad", "dv": "m/s", "time": "us"}
        return [
            replace(
                m,
                unit=units[m.quantity],
                why="beside delta_angle_dt: PX4 writes rad, m/s and us",
            )
            if m.quantity in units and m.unit is None
            else m
            for m in told
        ]
    if {"timeus", "gyrx", "accx"} <= heads:
        return [
            replace(
                m,
                unit={"gyro": "rad/s", "accel": "m/s^2"}[m.quantity],
                why="beside TimeUS: ArduPilot writes rad/s and m/s^2",
            )  # fmt: skip
            if m.quantity in ("gyro", "accel") and m.unit is None
            else m
            for m in told
        ]
    told = _turns(told, headings)
    if "gfx" not in heads:
        return told
    return [
        replace(m, unit="rad/s", why="wx beside gFx: Physics Toolbox writes rad/s")
        if m.quantity == "gyro" and m.unit is None and h.name.strip().lower() in ("wx", "wy", "wz")
        else m
        for m, h in zip(told, headings)
    ]
