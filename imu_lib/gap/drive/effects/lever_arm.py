"""`lever_arm`: see `cause`."""

from __future__ import annotations

from .base import Linear


class LeverArm(Linear):
    name = "lever_arm"
    cause = "The antenna stands away from the IMU."
    key = "arm"
    words = "innovations follow the heading and, in velocity, the turn rate"
    unexcited = "the drive keeps one direction"


EFFECT = LeverArm()
