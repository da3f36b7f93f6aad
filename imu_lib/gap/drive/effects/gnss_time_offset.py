"""`gnss_time_offset`: see `cause`."""

from __future__ import annotations

from .base import Linear


class TimeOffset(Linear):
    name = "gnss_time_offset"
    cause = (
        "The receiver stamps its fixes at another time than it took them, or the two clocks "
        "were laid over each other wrongly."
    )
    key = None
    words = "innovations of position grow with speed, and of velocity with acceleration"
    unexcited = "the drive keeps one speed and one direction"


EFFECT = TimeOffset()
