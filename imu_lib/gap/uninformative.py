"""Channels that say nothing of a noise of their own: missing, stuck, rounded away, a copy."""

from __future__ import annotations

import numpy as np

from imu_lib.faults import Finding
from imu_lib.faults.standing import stands
from imu_lib.record import Record

#: Beyond these shares a channel is left out (missing; stuck at one value; one value scattered all
#: over): there is no noise left to compare.
MOST_LOST, LONGEST_STUCK, MOST_ALIKE = 0.5, 0.1, 0.95


def says_nothing(record: Record, findings: tuple[Finding, ...]) -> dict[str, str]:
    """Channels that say nothing of a noise of their own, and why in words."""
    still = {c for f in findings if stands(f) for c in f.channels}
    out = _silent(record, still)
    for f in findings:
        if f.kind == "copied":
            sign = " with the sign reversed" if f.parameters["sign"] < 0 else ""
            of = f.parameters["of"]
            out[f.channels[0]] = f"is {of} again{sign}, one measurement in two columns"
        for c in f.channels if f.kind == "dead_zone" else ():
            value = f.parameters["value"]
            out[c] = (
                f"stands at {value:.4g} in {np.mean(record.channels[c] == value):.0%} of its "
                "samples between values on both sides, a dead zone that hides its noise"
            )
    return out


def _silent(record: Record, still: set[str]) -> dict[str, str]:
    """Channels that say next to nothing, and why; those of `still` stand still for a part that is
    known and masked.
    """
    out = {}
    for channel, x in record.channels.items():
        lost = np.isnan(x).mean()
        edges = np.flatnonzero(np.concatenate([[True], np.diff(x) != 0, [True]]))
        run = np.diff(edges).max() / len(x)
        same = (x == np.nanmedian(x)).mean()
        reason = (
            f"is missing in {lost:.0%} of the samples"
            if lost > MOST_LOST
            else "never changes"
            if same == 1
            else f"is stuck at one value for {run:.0%} of the record"
            if run > LONGEST_STUCK and channel not in still
            else f"has one value in {same:.0%} of its samples, which hides its noise"
            if same > MOST_ALIKE
            else None
        )
        if reason:
            out[channel] = reason
    return out
