"""`gyro_scale`: see `cause`."""

from __future__ import annotations

from .base import Linear


class GyroScale(Linear):
    name = "gyro_scale"
    cause = "A gyro reads a fixed share too much or too little."
    key = "scale"
    words = (
        "the heading falls behind or runs ahead in every turn, and velocity across the track "
        "with it"
    )
    unexcited = "the drive has too little turning about the axis"


EFFECT = GyroScale()
