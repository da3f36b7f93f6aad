"""`accel_scale`: see `cause`."""

from __future__ import annotations

from .base import Linear


class AccelScale(Linear):
    name = "accel_scale"
    cause = "An accelerometer reads a fixed share too much or too little."
    key = "scale"
    words = "velocity innovations grow with the specific force along the axis"
    unexcited = "the drive has too little specific force along the axis"


EFFECT = AccelScale()
