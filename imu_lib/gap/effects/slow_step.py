"""A change of the bias from one level to another that takes its time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import Data
from imu_lib.gap.state import State
from imu_lib.processes import Step as Process

from .drift import Drift

if TYPE_CHECKING:
    from imu_lib.gap.absorbed import FreeBase

#: Shares of the record that the change may last, and that there is of each level at the least.
SHARES, LEVEL = (0.04, 0.08, 0.16, 0.3), 0.08
#: Trial beginnings in the length of a change.
BEGINNINGS = 4
#: Logarithms of the length about one that is tried.
LENGTHS = np.linspace(-0.35, 0.35, 5)


class SlowStep(Drift):
    name = "step"
    key = "step:slow"
    red = True
    event = True
    single = True
    cause = (
        "Something changed within minutes: the mount settled, the table sank, the sun came round."
    )
    shape = "time"

    def shapes(self, data: Data) -> list[Any]:
        span, out = data.duration, []
        for share in SHARES:
            if share * span < 4 * data.m / data.fs:
                continue
            begin = np.arange(LEVEL, 1.0 - LEVEL - share, share / BEGINNINGS)
            out += [
                Process(amplitude=1.0, time=float(b * span), duration=float(share * span))
                for b in begin
            ]
        return out

    def around(self, process: Any, data: Data, reach: float, points: int) -> list[Any]:
        length = process.duration
        shift = np.linspace(-reach, reach, 9 if points < 100 else points) * length / BEGINNINGS
        factor = np.exp(min(reach, 1.0) * LENGTHS) if points < 100 else np.ones(1)
        low, high = LEVEL * data.duration, (1.0 - LEVEL) * data.duration
        out = []
        for f in factor:
            middle = process.time + 0.5 * length + shift
            begin = np.clip(middle - 0.5 * f * length, low, max(low, high - f * length))
            out += [
                process.with_(time=float(b), duration=float(f * length)) for b in np.unique(begin)
            ]
        return out

    def penalty(self, data: Data, snr: float) -> float:
        # of a straight change: sd of its middle about its length over the signal-to-noise ratio, of
        # its length likewise; uniform before, the latter in its logarithm
        snr = max(snr, 1.0)
        share = float(np.mean(SHARES))
        return float(
            np.log(np.sqrt(2 * np.pi) * share / snr)
            + np.log(np.sqrt(2 * np.pi) / (snr * np.log(SHARES[-1] / SHARES[0])))
        )

    def absorbed(self, base: FreeBase) -> bool:
        return False

    def where(self, state: State, candidate: Candidate) -> str:
        p = candidate.process
        return (
            f"mean of the signal: a change from {p.time:.0f} to {p.time + p.duration:.0f} s from "
            "one level to another"
        )


EFFECTS = (SlowStep(),)
