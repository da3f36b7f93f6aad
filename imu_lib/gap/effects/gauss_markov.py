"""A bias that is disturbed at random and relaxes with one time constant, such as thermal exchange
with the surroundings.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.state import State
from imu_lib.processes import GaussMarkov as Process

from .base import Effect
from .competitor import Spectral, most_beside_filter, near_record

#: A dwell's squared signal-to-noise ratio below which two levels look like a Gauss-Markov process,
#: in white noise and in a drift (tests/test_gap_telegraph.py).
BURIED, BURIED_IN_DRIFT = 3.0, 8.0


def buried_telegraph(state: State, candidate: Candidate) -> bool:
    """Whether a telegraph of the same spectrum would look the same, its dwells being lost in the
    noise.
    """
    at = state.assembly.place(candidate)
    process, others = state.fit.terms[at], [t for k, t in enumerate(state.fit.terms) if k != at]
    corner = np.array([0.5 / (np.pi * process.correlation_time)])
    noise = sum(float(t.psd(corner, state.data.fs)[0]) for t in others) / 2
    # beside a drift the likelihood of two levels is a lower bound, short by some tens
    drift = any(not t.fast for t in others)
    dwell = 2 * process.sigma**2 * process.correlation_time / noise
    return bool(dwell < (BURIED_IN_DRIFT if drift else BURIED))


class GaussMarkov(Spectral):
    name = "gauss_markov"
    red = True
    cause = (
        "A bias that is disturbed at random and relaxes with one time constant, such as "
        "thermal exchange with the surroundings."
    )
    domain = "allan"
    process = Process
    amplitude = "sigma"

    def grid(self, fs: float, duration: float) -> list[Any]:
        return [
            Process(sigma=1.0, correlation_time=t) for t in np.geomspace(2 / fs, duration / 3, 20)
        ]

    def levels(self, state: State, candidate: Candidate) -> list[tuple[float, float]]:
        process = state.fit.terms[state.assembly.place(candidate)]
        rate, distance = 0.5 / process.correlation_time, 2 * process.sigma
        return [(distance, rate), (distance, 0.4 * rate)]

    def alike(self, state: State, candidate: Candidate) -> dict[str, float]:
        return {"telegraph": 0.5} if buried_telegraph(state, candidate) else {}

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        return most_beside_filter(parameters, beside)

    def log_prior(self, state: State, candidate: Candidate) -> float:
        return near_record(state, candidate)


EFFECTS = (GaussMarkov(),)
