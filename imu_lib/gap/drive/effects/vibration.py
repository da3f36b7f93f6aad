"""`vibration`: see `cause`."""

from __future__ import annotations

from .base import Effect


class Vibration(Effect):
    name = "vibration"
    cause = "Noise of a channel that follows the speed: engine, tyres, a loose mount."
    words = "innovations grow with speed"


EFFECT = Vibration()
