"""White noise, where the base model has none."""

from __future__ import annotations

from typing import Any

from imu_lib.processes import WhiteNoise as Process

from .competitor import Spectral


class WhiteNoise(Spectral):
    name = "white_noise"
    single = True
    cause = "Thermal and electronic noise of the sensing element."
    domain = "psd"
    process = Process
    amplitude = "N"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [Process(N=1.0)]


EFFECTS = (WhiteNoise(),)
