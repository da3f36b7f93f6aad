"""`accel_bias`: see `cause`."""

from __future__ import annotations

from .base import Linear


class AccelBias(Linear):
    name = "accel_bias"
    cause = "An accelerometer has a constant error beyond what the model allows at switch-on."
    key = "bias"
    words = "the estimated bias lies outside what the model allows at switch-on"
    unexcited = "a tilt looks the same as long as the heading does not change"


EFFECT = AccelBias()
