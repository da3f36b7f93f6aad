"""Axes of one sensor that state units of their own: each is read in its own."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from imu_lib.readers import names
from imu_lib.readers.raw import Raw
from imu_lib.readers.streams import PAIR


def one_each(raw: Raw, flags: Mapping[str, str | None]) -> None:
    """Bring axes that state different units, all of them known, to one, with a word. What the call says
    of a sensor's unit goes for all of its axes.
    """
    for kind, families in PAIR.items():
        for family in families:
            there = raw.axes(family)
            said = {c: raw.units[c] for c in there}
            known = names.UNITS[family]
            if (
                flags.get(kind)
                or len(set(said.values())) < 2
                or not set(said.values()) <= set(known)
            ):
                continue
            first = said[there[0]]
            for c in there[1:]:
                factor = known[said[c]] / known[first]
                raw.columns[c] = np.asarray(raw.columns[c], dtype=float) * factor
                raw.units[c] = first
            each = ", ".join(f"`{raw.headings[c]}` {said[c]}" for c in there)
            word = "gyro" if kind == "gyro" else "accelerometer"
            raw.notes += (f"The axes of the {word} state different units ({each}); each was read in its own.",)  # fmt: skip
