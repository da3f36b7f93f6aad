"""A disturbed bias behind a second lag, so that it moves smoothly."""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.state import State
from imu_lib.processes import GaussMarkov2 as Process

from .base import Effect
from .competitor import Spectral, most_beside_filter, near_record


class GaussMarkov2(Spectral):
    name = "gauss_markov_2"
    red = True
    cause = "A disturbed bias behind a second lag, so that it moves smoothly."
    domain = "allan"
    process = Process
    amplitude = "sigma"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [
            Process(sigma=1.0, correlation_time=t) for t in np.geomspace(5 / fs, duration / 3, 18)
        ]

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        return most_beside_filter(parameters, beside)

    def log_prior(self, state: State, candidate: Candidate) -> float:
        return near_record(state, candidate)


EFFECTS = (GaussMarkov2(),)
