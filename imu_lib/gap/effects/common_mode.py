"""Noise that several channels share."""

from .base import Effect


class CommonMode(Effect):
    name = "common_mode"
    cause = (
        "Supply or reference voltage, or vibration of the mounting, disturbs several channels "
        "at once."
    )
    domain = "coherence"
