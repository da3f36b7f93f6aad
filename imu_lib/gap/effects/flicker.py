"""Carrier traps and surface states in the electronics."""

from __future__ import annotations

from typing import Any

from imu_lib.processes import Flicker as Process

from .competitor import Spectral


class Flicker(Spectral):
    name = "flicker"
    red = True
    single = True
    cause = (
        "Carrier traps and surface states in the electronics: noise with equal power in every "
        "octave."
    )
    domain = "allan"
    process = Process
    amplitude = "B"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [Process(B=1.0)]


EFFECTS = (Flicker(),)
