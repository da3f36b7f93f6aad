"""`heading`: see `cause`."""

from __future__ import annotations

from .base import Effect


class Heading(Effect):
    name = "heading"
    cause = "The heading given at the start is wrong."
    words = "the heading of the path against the one given at the start"


EFFECT = Heading()
