"""Increments of a rounded angle or velocity are read out."""
from __future__ import annotations

from imu_lib.processes import Quantization as Process

from .base import Spectral


class Quantization(Spectral):
    name = "quantization"
    cause = "Increments of a rounded angle or velocity are read out: the rounding error of the integral is differenced."
    domain = "psd"
    process = Process
    amplitude = "Q"

    def grid(self, fs, duration):
        return [Process(Q=1.0)]
