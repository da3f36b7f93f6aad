"""The transient after switching on."""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import WarmUp as Process

from .drift import Drift


class WarmUp(Drift):
    name = "warm_up"
    red = True
    transient = True
    single = True
    cause = (
        "The sensor heats itself after switching on until it is in balance with its surroundings."
    )
    shape = "time_constant"

    def bounds(self, data: Data) -> tuple[float, float]:
        # beyond a third of the record an exponential is a ramp with a bend, and a ramp has one
        # parameter less
        return np.log(2 * data.m / data.fs), np.log(data.duration / 2.5)

    def shapes(self, data: Data) -> list[Any]:
        low, high = self.bounds(data)
        return [
            Process(amplitude=1.0, time_constant=float(t))
            for t in np.exp(np.linspace(low, high, 14))
        ]

    def penalty(self, data: Data, snr: float) -> float:
        return float(np.log(np.sqrt(2 * np.pi) * 2.0 / (max(snr, 1.0) * np.log(1e3))))

    def where(self, state: State, candidate: Candidate) -> str:
        span = 3 * candidate.process.time_constant
        return f"mean of the signal: a transient over the first {span:.0f} s"


EFFECTS = (WarmUp(),)
