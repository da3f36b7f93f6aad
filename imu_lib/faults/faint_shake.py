"""What is told of a shake that no single window shows: one somebody walks or drives by."""

from __future__ import annotations

import numpy as np

from imu_lib.faults.finding import Finding, named, seconds
from imu_lib.faults.levels import Prepared


def finding(
    members: tuple[str, ...],
    channels: dict[str, Prepared],
    part: slice,
    span: tuple[float, float],
    evidence: dict[str, float],
    likeness: str,
) -> Finding:
    """A faint shake as a disturbance.

    members : channels that felt it. part : its rows. span : from when to when, s. evidence : what
    it was found by. likeness : what it looks like where it is left in
    """
    peaks = []
    for c in members:
        x = channels[c].x[part]
        off = x - np.median(x)
        peaks.append(float(off[np.argmax(np.abs(off))]))
    score = max(float(np.abs(channels[c].fast[part]).max()) for c in members)
    start, stop = span
    return Finding(
        "disturbance",
        members,
        start,
        stop,
        {"start": start, "duration": stop - start, "peak": peaks, "channels": list(members)},
        {"peak_over_noise": score, **evidence},
        f"A faint shake at {seconds(start)} s, {stop - start:.2g} s long, on {named(members)}.",
        f"It is no error of the sensor; left in, it looks like {likeness}. It is masked.",
        np.arange(part.start, part.stop),
    )
