"""A bias that follows the temperature."""

from __future__ import annotations

import numpy as np

from imu_lib.processes import Temperature as Process

from .base import Drift


class Temperature(Drift):
    name = "temperature"
    cause = "Stress in the package and the temperature coefficients of the electronics move the bias with the temperature."
    domain = "temperature"
    amplitude = "slope"

    def candidates(self, data):
        if data.temperature is None or not np.ptp(data.block_temperature) > 0:
            return []
        return [Process(slope=1.0, reference=float(np.mean(data.block_temperature)))]


EFFECTS = (Temperature(),)
