"""A bias that runs away in a straight line."""

from __future__ import annotations

from typing import Any

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import Ramp as Process

from .drift import Drift


class Ramp(Drift):
    name = "ramp"
    red = True
    single = True
    cause = (
        "Slow, even change of the surroundings or of the sensor: ageing, a discharging "
        "supply, a steady heating."
    )
    amplitude = "R"

    def shapes(self, data: Data) -> list[Any]:
        return [Process(R=1.0)]

    def least(self, state: State) -> float:
        # beside a transient whose time constant is not yet its own it gains only when both are
        # found anew
        return 0.0 if any(c.effect.transient for c in state.drifts) else super().least(state)

    def where(self, state: State, candidate: Candidate) -> str:
        return f"mean of the signal: a drift over the {state.data.duration:.0f} s of the record"


EFFECTS = (Ramp(),)
