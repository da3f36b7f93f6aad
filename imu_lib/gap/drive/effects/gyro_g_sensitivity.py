"""`gyro_g_sensitivity`: see `cause`."""

from __future__ import annotations

from .base import Linear


class GyroGSensitivity(Linear):
    name = "gyro_g_sensitivity"
    cause = "The gyros feel specific force."
    key = "matrix"
    words = "attitude drifts with the specific force: in braking, starting and curves"
    unexcited = "the drive has too little specific force along the axis"


EFFECT = GyroGSensitivity()
