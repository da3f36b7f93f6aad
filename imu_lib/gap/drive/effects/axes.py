"""`axes`: see `cause`."""

from __future__ import annotations

from .base import Effect


class Axes(Effect):
    name = "axes"
    cause = "The file's axes are not forward, right, down."
    words = "the readings follow the fixes' accelerations and turns in another order of axes"


EFFECT = Axes()
