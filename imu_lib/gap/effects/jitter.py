"""Jitter of the time stamps."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from imu_lib.arrays import Array
from imu_lib.faults.clock import rate_change
from imu_lib.processes import Jitter as Process
from imu_lib.record import Record

from .base import Effect, Finding

#: Share of a sampling interval below which the scatter of the stamps is none.
LEAST = 2e-4


class Jitter(Effect):
    name = "jitter"
    cause = "The host stamps the samples when it gets to them, not when they were taken."
    domain = "timing"

    def detect(self, record: Record) -> Finding | None:
        if record.time is None:
            return None
        slots = record.slots().astype(float)
        changed = rate_change(record.times())
        late = _late(slots, record.time, None if changed is None else changed[0])
        sd = float(np.std(late))
        unit = np.diff(np.unique(np.round(np.diff(record.time[:20000]), 9)))
        grain = float(unit.min()) if len(unit) and unit.min() > 1e-9 else 0.0
        # stamps printed with few digits are off by up to half a digit, which is no jitter
        if changed is None and (sd < LEAST / record.rate or sd < 0.5 * grain):
            return None
        n = len(late)
        low = 1.4826 * float(np.median(np.abs(late - np.median(late))))
        found = Finding(
            self,
            Process(sd=max(sd, 1e-9)),
            None,
            f"timing: the stamps scatter by {1e3 * sd:.3g} ms around an even clock",
            {"sd": [sd * (1 - 1.96 / np.sqrt(2 * n)), sd * (1 + 1.96 / np.sqrt(2 * n))]},
        )
        if changed is not None:
            found.doubt = (
                f"timing: the clock changes its rate at {changed[0]:.1f} s, from {changed[1]:.5g} "
                f"to {changed[2]:.5g} Hz"
            )
            return found
        rho = float(np.corrcoef(late[:-1], late[1:])[0, 1])
        excess = float(np.mean((late / sd) ** 4) - 3)
        if (
            abs(rho) > 0.1 + 5 / np.sqrt(n)
            and norm.sf(abs(rho) * np.sqrt(n)) < 1e-6
            and sd < 0.2 / record.rate
            or abs(low / sd - 1) > 0.3
            or excess > 3
        ):
            found.doubt = (
                "timing: the stamps wander or come in bursts; that is no independent normal jitter"
            )
        return found


def is_even(found: Finding, rate: float) -> bool:
    """Whether a finding of the stamps, at `rate` Hz, is that their clock changes its rate and does
    nothing else.
    """
    return found.effect.name == Jitter.name and bool(found.process.sd * rate < LEAST)


def _late(slots: Array, time: Array, changes: float | None) -> np.ndarray:
    """Stamps against an even clock, or against two where the rate `changes` at a time, s."""
    if changes is None:
        return np.asarray(time - np.polyval(np.polyfit(slots, time, 1), slots))
    late = np.zeros(len(time))
    after = time - time[0] >= changes
    for part in (p for p in (after, ~after) if p.sum() > 2):
        t = time[part]
        step = np.diff(t)
        own = np.r_[0.0, np.cumsum(np.rint(step / np.median(step)))]
        late[part] = t - np.polyval(np.polyfit(own, t, 1), own)
    return late
