"""`gyro_misalignment`: see `cause`."""

from __future__ import annotations

from .base import Linear


class GyroMisalignment(Linear):
    name = "gyro_misalignment"
    cause = (
        "The gyro axes are not at right angles to each other, or are turned against the "
        "accelerometers."
    )
    key = "matrix"
    words = "tilt is gained in turns, and with it velocity"
    unexcited = "the drive has too little turning about the other axis"


EFFECT = GyroMisalignment()
