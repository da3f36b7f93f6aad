"""`gyro_bias`: see `cause`."""

from __future__ import annotations

from .base import Linear


class GyroBias(Linear):
    name = "gyro_bias"
    cause = "A gyro has a constant error beyond what the model allows at switch-on."
    key = "bias"
    words = "the attitude drifts steadily from the first seconds on"
    unexcited = "the drive does not show the attitude about the axis"


EFFECT = GyroBias()
