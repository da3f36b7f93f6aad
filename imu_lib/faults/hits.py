"""Places in which channels stand out of their noise."""

from __future__ import annotations

from dataclasses import dataclass

#: Chance alarms allowed in a record on one channel alone.
ALONE = 1e-4


@dataclass
class Hit:
    """Rows [low, high) in which channels (indices) stand out, by how much."""

    low: int
    high: int
    channels: frozenset
    score: float
    slow: bool = False


def merged(hits: list[Hit], join: int) -> list[Hit]:
    out: list[Hit] = []
    for h in sorted(hits, key=lambda h: h.low):
        if out and h.low <= out[-1].high + join:
            last = out[-1]
            out[-1] = Hit(
                last.low,
                max(last.high, h.high),
                last.channels | h.channels,
                max(last.score, h.score),
                last.slow or h.slow,
            )
        else:
            out.append(h)
    return out
