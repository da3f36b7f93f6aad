"""An oscillation too slow to be a line of the spectrum."""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import Sinusoid as Process

from .drift import Drift
from .sinusoid import FIRST

#: Fewest cycles in a record: fewer are a drift of any kind.
FEWEST = 3
#: Trial phases over half a turn.
PHASES = 6
#: Share of the orders of a drift's cosine coefficients that hold a wave: its skirts need the
#: others.
SHARE = 0.4


def _most(data: Data) -> float:
    """Most cycles in a record of which the coefficients of drifts show a wave."""
    return min(FIRST + 1.0, SHARE * data.orders)


class SlowSinusoid(Drift):
    name = "sinusoid"
    key = "sinusoid:slow"
    cause = (
        "The surroundings are heated and cooled in turn: air conditioning, a thermostat, "
        "cycling of another device."
    )
    shape = "frequency"

    def bounds(self, data: Data) -> tuple[float, float]:
        return np.log(FEWEST / data.duration), np.log(_most(data) / data.duration)

    def shapes(self, data: Data) -> list[Any]:
        cycles = np.arange(FEWEST, _most(data) + 0.25, 0.5)
        return [
            Process(amplitude=1.0, frequency=float(c / data.duration), phase=float(p))
            for c in cycles
            for p in np.arange(PHASES) * np.pi / PHASES
        ]

    def around(self, process: Any, data: Data, reach: float, points: int) -> list[Any]:
        # the phase in the middle of the record hangs least on the frequency
        low, high = np.exp(self.bounds(data))
        f = np.unique(
            np.clip(
                process.frequency + np.linspace(-reach, reach, points) * 0.5 / data.duration,
                low,
                high,
            )
        )
        turn = np.pi * (process.frequency - f) * data.duration
        shift = (
            np.linspace(-reach, reach, 9 if points < 100 else 1) * np.pi / PHASES * (points < 100)
        )
        return [
            process.with_(frequency=float(v), phase=float(np.mod(process.phase + t + s, 2 * np.pi)))
            for v, t in zip(f, turn)
            for s in shift
        ]

    def upright(self, process: Any) -> Any:
        return process.with_(phase=float(np.mod(process.phase + np.pi, 2 * np.pi)))

    def penalty(self, data: Data, snr: float) -> float:
        # Cramer-Rao: sd of the frequency sqrt(12) / (2 pi T snr), of the phase 1 / snr; uniform
        # before the record is seen
        snr = max(snr, 1.0)
        return float(
            np.log(np.sqrt(12 / (2 * np.pi)) / snr / (FIRST - FEWEST))
            - np.log(np.sqrt(2 * np.pi) * snr)
        )

    def where(self, state: State, candidate: Candidate) -> str:
        period = 1 / candidate.process.frequency
        return f"mean of the signal: it swings with a period of {period:.4g} s"


EFFECTS = (SlowSinusoid(),)
