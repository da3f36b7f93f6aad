"""A bias that runs away in a straight line."""

from __future__ import annotations

from imu_lib.processes import Ramp as Process

from .base import Drift


class Ramp(Drift):
    name = "ramp"
    cause = "Slow, even change of the surroundings or of the sensor: ageing, a discharging supply, a steady heating."
    amplitude = "R"

    def candidates(self, data):
        return [Process(R=1.0)]


EFFECTS = (Ramp(),)
