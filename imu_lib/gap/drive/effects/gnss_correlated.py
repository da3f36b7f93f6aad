"""`gnss_correlated`: see `cause`."""

from __future__ import annotations

from .base import Effect


class GnssCorrelated(Effect):
    name = "gnss_correlated"
    cause = "Errors of the positions that last (multipath, atmosphere)."
    words = "position innovations that keep their sign for many fixes"


EFFECT = GnssCorrelated()
