"""What a better model is worth: errors in outages that the search has not seen, before and
after.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.navigation import outages
from imu_lib.navigation.filter import FilterModel
from imu_lib.navigation.preparation import Gnss
from imu_lib.navigation.statistics import paired
from imu_lib.navigation.windows import Window

FEWEST = 3  # outages that have an interval
#: Fixes are believed as stated, but for rounding.
GNSS = Gnss(position_floor=0.02, velocity_floor=0.005)


@dataclass(frozen=True)
class Outages:
    """Windows, the study with models "before" and "after", and the ratio of their errors."""

    duration: float
    windows: tuple[Window, ...]
    study: outages.OutageStudy
    against: str

    def medians(self) -> dict[str, float]:
        return {
            name: float(np.median(self.study.errors(name, against=self.against)))
            for name in self.study.models
        }

    def ratio(self) -> dict[str, float] | None:
        """After over before: {value, low, high}, geometric mean with Student's interval; None where
        there are too few outages: of two it reaches from nothing to a thousand.
        """
        if "before" not in self.study.models or len(self.windows) < FEWEST:
            return None
        before, after = (self.study.errors(n, against=self.against) for n in ("before", "after"))
        pair = paired(after, before, ("after", "before"))
        values = (pair.ratio, pair.low, pair.high)
        if pair.better == "before":
            values = (1 / pair.ratio, 1 / pair.high, 1 / pair.low)
        return dict(zip(("value", "low", "high"), (float(v) for v in values)))

    def to_json(self) -> dict[str, Any]:
        medians = self.medians()
        return {
            "duration": self.duration,
            "windows": len(self.windows),
            "median_max_error": {n: medians.get(n) for n in ("before", "after")},
            "ratio": self.ratio(),
            "against": self.against,
        }


def withheld(drive: Drive) -> tuple[Window, ...]:
    """Windows to withhold: of 30 s, one in 90 s; of 20 s, one in 60 s, on drives under 10 min."""
    short = drive.duration < 600.0
    duration, every = (20.0, 60.0) if short else (30.0, 90.0)
    settle = min(120.0, 0.25 * drive.duration)
    try:
        return outages.regular_windows(drive, duration=duration, every=every, settle=settle)
    except (InputError, ValueError):
        return ()


def compare(
    drive: Drive,
    before: Model,
    after: Model,
    windows: tuple[Window, ...],
    heading: float | None = None,
) -> tuple[Outages | None, list[str]]:
    """The study; without "before" where that filter does not even start."""
    filters = {}
    for name, model in (("before", before), ("after", after)):
        filters[name] = FilterModel.of(model)
    notes = []
    for names in (("before", "after"), ("after",)):
        try:
            study = outages.compare(
                drive, {n: filters[n] for n in names}, windows, gnss=GNSS, strict=False,
                heading=heading,
            )  # fmt: skip
            break
        except InputError as error:
            notes.append(str(error))
    else:
        return None, notes
    against = "reference" if "reference" in study.against else "full_gnss"
    return Outages(windows[0].duration, study.windows, study, against), notes
