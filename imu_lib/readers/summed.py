"""Increments beside the interval over which each was summed, delta_angle and delta_angle_dt:
readings, whatever the stamps say of the interval.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from imu_lib.readers import names
from imu_lib.readers.meaning import INCREMENT, WORD, Meaning
from imu_lib.readers.raw import Raw

#: Units of an increment and of the rate that it makes.
RATES = {"rad": "rad/s", "deg": "deg/s", "m/s": "m/s^2", "g*s": "g"}
MICRO = 50.0  # from which on a whole number is an interval in microseconds


def divided(raw: Raw, told: list[Meaning], headings, values, load: Callable) -> list[Meaning]:
    """Such increments over their intervals, in place; as they are where they have none."""
    place = {h.name.strip().lower(): i for i, h in enumerate(headings) if h.kind == "number"}
    out = list(told)
    for kind, increment in INCREMENT.items():
        there = [i for i, m in enumerate(told) if m.quantity == increment and m.axis]
        stems = {
            re.sub(r"[\[(_. ]*[xyz0-3][\])]?$", "", headings[i].name.strip().lower()) for i in there
        }
        beside = [place[f"{s}_dt"] for s in stems if f"{s}_dt" in place]
        if len(stems) != 1 or not beside:
            continue
        step = np.asarray(load(beside)[beside[0]], dtype=float)
        if not (np.isfinite(step).all() and (step > 0).all()):
            continue
        unit = names.spelled_unit(headings[beside[0]].name)
        per = names.TIME_UNITS.get(unit, 1e-6 if np.median(step) > MICRO else 1.0)
        for i in there:
            values[i] = np.asarray(values[i], dtype=float) / (step * per)
            said = f"{told[i].why}; over `{headings[beside[0]].name}`"
            rate = RATES.get(told[i].unit, told[i].unit)
            out[i] = replace(told[i], quantity=kind, unit=rate, why=said)
        raw.notes += (
            f"The increments of the {WORD[kind]} were divided by `{headings[beside[0]].name}`, "
            "each by its own interval.",
        )
    return out
