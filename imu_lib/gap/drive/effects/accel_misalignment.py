"""`accel_misalignment`: see `cause`."""

from __future__ import annotations

from .base import Linear


class AccelMisalignment(Linear):
    name = "accel_misalignment"
    cause = "The accelerometer axes are not at right angles to each other."
    key = "matrix"
    words = "velocity innovations of one axis grow with the specific force of another"
    unexcited = "the drive has too little specific force along the other axis"


EFFECT = AccelMisalignment()
