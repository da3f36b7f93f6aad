"""`imu_clock`: see `cause`."""

from __future__ import annotations

from .base import Linear


class ImuClock(Linear):
    name = "imu_clock"
    cause = "The IMU's clock runs fast or slow against GNSS time."
    key = None
    words = "innovations along the track grow with speed and with the time since the start"
    unexcited = "the drive is too short or too slow"


EFFECT = ImuClock()
