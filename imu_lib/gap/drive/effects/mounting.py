"""`mounting`: see `cause`."""

from __future__ import annotations

from .base import Effect


class Mounting(Effect):
    name = "mounting"
    cause = "The sensor's case is turned against the vehicle."
    words = "the velocity in the case's axes lies aside of its x"


EFFECT = Mounting()
