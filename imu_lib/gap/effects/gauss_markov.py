"""A bias that is disturbed at random and relaxes with one time constant, such as thermal exchange
with the surroundings.
"""

from __future__ import annotations

import numpy as np

from imu_lib.processes import GaussMarkov as Process

from .base import Spectral


class GaussMarkov(Spectral):
    name = "gauss_markov"
    cause = "A bias that is disturbed at random and relaxes with one time constant, such as thermal exchange with the surroundings."
    domain = "allan"
    process = Process
    amplitude = "sigma"

    def grid(self, fs, duration):
        return [
            Process(sigma=1.0, correlation_time=t) for t in np.geomspace(2 / fs, duration / 3, 20)
        ]


EFFECTS = (GaussMarkov(),)
