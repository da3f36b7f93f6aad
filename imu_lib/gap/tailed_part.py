"""Tails that were counted in all of a channel's fast noise, as its own white noise has them: what
else is in it (noise of the record, rounding, noise with a memory) is normal, and makes the tails of
the sum the lighter.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from imu_lib.gap.effects.base import Finding
from imu_lib.gap.state import State
from imu_lib.processes import CommonMode, HeavyTails, ReadOutNoise, WhiteNoise, folded

#: Share of the variance from which on it is all of it.
ALL = 0.97


def of_white_noise(findings: list[Finding], state: State) -> list[Finding]:
    """The findings, those of tails with what the white noise of the state's model has."""
    white = [t for t in state.fit.terms if isinstance(t, WhiteNoise)]
    own = [t for t in white if not isinstance(t, (CommonMode, ReadOutNoise))]
    if not own:
        return findings
    return [_of_part(f, own, state) if isinstance(f.process, HeavyTails) else f for f in findings]


def _of_part(found: Finding, own: list[Any], state: State) -> Finding:
    """Tails of all the noise as its part `own` has them.

    A response h in front of the samples makes normal what it adds up: of an excess it leaves the
    share sum(h^4) / sum(h^2)^2, as normal noise beside it does that is the square of its share.
    """
    data, low_pass = state.data, state.fit.low_pass
    if found.variance is not None:
        response = np.ones(1) if low_pass is None else folded.response(low_pass, data.fs)
        power = np.sum(response**2)
        part = sum(t.N**2 for t in own) * data.fs * power / found.variance
        part = min(part, 1.0) * np.sqrt(np.sum(response**4)) / power
    else:
        k = data.layout.slow
        ratio = data.layout.spectrum(own, low_pass) / state.fit.expected
        part = np.average(ratio[k:], weights=data.layout.half[k:])
    if part > ALL or found.levels is None:
        return found
    worth = -np.inf if found.process.lean else np.inf
    tails, intervals = found.levels.tails(worth, float(part)).with_intervals()
    return replace(found, process=tails, intervals=intervals)
