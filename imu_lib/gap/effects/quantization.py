"""Increments of a rounded angle or velocity are read out."""

from __future__ import annotations

from typing import Any

from imu_lib.processes import Quantization as Process

from .base import Effect, Finding
from .competitor import SLOPE_BESIDE_FILTER, Spectral


class Quantization(Spectral):
    name = "quantization"
    single = True
    rounds = True
    cause = (
        "Increments of a rounded angle or velocity are read out: the rounding error of the "
        "integral is differenced."
    )
    domain = "psd"
    process = Process
    amplitude = "Q"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [Process(Q=1.0)]

    def of_differences(self, parameters: dict[str, Any]) -> bool:
        return True

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        return SLOPE_BESIDE_FILTER if any(e.rolls_off for e in beside) else 1.0

    def on_grid(self, process: Process, levels: int, doubt: str | None = None) -> Finding:
        """What is found where the grid of the output is that of a rounded integral."""
        return Finding(
            self,
            process,
            None,
            f"power spectral density rising as the square of the frequency, and {levels} distinct "
            "samples on one grid: increments of a rounded integral",
            {"Q": [process.Q * (1 - 1e-6), process.Q * (1 + 1e-6)]},
            doubt=doubt,
        )


EFFECTS = (Quantization(),)
