"""A tone whose frequency goes from one end of its band to the other is one source, in however many
pieces it was found.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.vibrations.behaviour import SWEEPS
from imu_lib.vibrations.sources import Source

#: Share of the record between two pieces, and of the wider band between their bands, at the most;
#: share of the record at its ends that a tone may lack and be there all the time.
PAUSE, APART, ENDS = 0.1, 0.3, 0.05


def joined(found: list[Source], duration: float) -> list[Source]:
    """The sources, those that sweep one after the other on the same channels as one; `duration` s
    is that of the record.
    """
    swept = sorted((s for s in found if s.strange == SWEEPS), key=lambda s: s.place.start)
    out = [s for s in found if s.strange != SWEEPS]
    chain: list[Source] = []
    for s in swept:
        if chain and _follows(s, chain[-1], duration):
            chain[-1] = _one(chain[-1], s, duration)
        else:
            chain.append(s)
    return sorted([*out, *chain], key=lambda s: -s.gain)


def _span(s: Source, duration: float) -> tuple[float, float]:
    return (s.spans[0][0], s.spans[-1][1]) if s.spans else (0.0, duration)


def _follows(s: Source, last: Source, duration: float) -> bool:
    pause = _span(s, duration)[0] - _span(last, duration)[1]
    gap = max(s.place.low, last.place.low) - min(s.place.high, last.place.high)
    near = gap < APART * max(s.bandwidth, last.bandwidth)
    return set(s.channels) == set(last.channels) and near and abs(pause) < PAUSE * duration


def _one(a: Source, b: Source, duration: float) -> Source:
    """Two pieces as one source, their power by how long each lasts."""
    parts = [_span(s, duration) for s in (a, b)]
    weight = np.array([stop - start for start, stop in parts])
    weight = weight / weight.sum()
    start, stop = min(p[0] for p in parts), max(p[1] for p in parts)
    whole = start < ENDS * duration and stop > (1 - ENDS) * duration
    low, high = min(a.place.low, b.place.low), max(a.place.high, b.place.high)

    def mean(of_a: dict[str, float], of_b: dict[str, float]) -> dict[str, float]:
        return {c: float(np.sqrt(weight @ [of_a[c] ** 2, of_b[c] ** 2])) for c in of_a}

    return replace(
        a,
        place=replace(a.place, low=low, high=high, start=start, stop=stop),
        frequency=0.5 * (low + high),
        bandwidth=high - low,
        spans=() if whole else ((start, stop),),
        amplitude=mean(a.amplitude, b.amplitude),
        sd=mean(a.sd, b.sd),
        gain=a.gain + b.gain,
        strength=max(a.strength, b.strength),
    )
