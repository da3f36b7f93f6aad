"""A low-pass filter in the sensor."""

from __future__ import annotations

import numpy as np

from imu_lib.gap.engine import Slot
from imu_lib.processes import LowPass as Stage

from .base import Effect


class LowPass(Effect):
    name = "low_pass"
    cause = "The sensor filters its output, with a moving average or an analogue or digital filter of some order."
    domain = "psd"

    def candidates(self, fs) -> list:
        """Filters from whose shapes the best start is chosen."""
        moving = [Stage(taps=k, rate=fs) for k in (*range(2, 13), 15, 16, 20, 24, 32, 48, 64)]
        # white noise averaged over ten times as many taps at ten times the rate is the same behind
        # the sampling, and over
        # less than a sampling interval it stays white
        inner = [
            Stage(taps=k, rate=10 * fs) for k in (*range(11, 64), *range(64, 120, 4)) if k % 10
        ]
        cutoffs = np.geomspace(0.01, 0.47, 22) * fs
        kinds = ({"smoothing": 1}, *({"order": k} for k in (1, 2, 3, 4)))
        return (
            moving
            + inner
            + [
                Stage(**kind, cutoff=float(c), rate=rate)
                for rate in (fs, 10 * fs)
                for kind in kinds
                for c in cutoffs
            ]
        )

    def slot(self, fs) -> Slot:
        """The cutoff of a filter of given order."""
        return Slot(-1, ("cutoff",), (np.log(0.003 * fs),), (np.log(0.495 * fs),), (np.log(100.0),))


EFFECTS = (LowPass(),)
