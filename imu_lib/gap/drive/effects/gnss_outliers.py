"""`gnss_outliers`: see `cause`."""

from __future__ import annotations

from .base import Effect


class GnssOutliers(Effect):
    name = "gnss_outliers"
    cause = "Some positions are wild: reflections, a wrong ambiguity."
    words = "single position innovations far outside all others"


EFFECT = GnssOutliers()
