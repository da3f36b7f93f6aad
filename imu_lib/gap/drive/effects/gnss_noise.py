"""`gnss_noise`: see `cause`."""

from __future__ import annotations

from .base import Effect


class GnssNoise(Effect):
    name = "gnss_noise"
    cause = (
        "The receiver's errors are larger or smaller than the standard deviations that it states."
    )
    words = "innovations larger or smaller than stated, without memory from one fix to the next"


EFFECT = GnssNoise()
