"""It was tilted: the accelerometers' gravity changes for good, and the gyros show the pulse that
turned it. A step of an accelerometer alone is the electronics'.
"""

from __future__ import annotations

import numpy as np

from imu_lib.faults.blocks import Blocks
from imu_lib.faults.finding import Finding, seconds
from imu_lib.faults.turn import MOST, TURNED, Bench, Turn

#: Ends of a turn that are tried in a search for its shape, at the most.
ENDS = 80
MEANS = (
    "The sensor moved: the accelerometers see another part of gravity from then on. Taken for one "
    "record, it is a step, and slow noise that there is not."
)


def find(
    x: dict[str, np.ndarray], time: np.ndarray, rate: float, spans: list[tuple[float, float]]
) -> list[Finding]:
    """Tilts within one stretch without holes. `spans` (s) are those in which it was touched."""
    accels = [c for c in (f"accel_{a}" for a in "xyz") if c in x]
    gyros = [c for c in (f"gyro_{a}" for a in "xyz") if c in x]
    if len(accels) < 3:
        return []
    f = Blocks(np.stack([x[c] for c in accels]), rate)
    w = Blocks(np.stack([x[c] for c in gyros]), rate) if len(gyros) == 3 else None
    gravity = float(np.linalg.norm(np.median(f.means, axis=1))) if f.k else 0.0
    if f.k < 24 or not gravity > 5.0:
        return []
    bench = Bench(f, w, gravity)
    cuts = _blocks_of(spans, f, time)
    found = []
    for i, (low, high) in enumerate(cuts):
        limits = cuts[i - 1][1] if i else 0, cuts[i + 1][0] if i + 1 < len(cuts) else f.k
        found.append(bench.widest(low, high, limits))
    found += _untouched(bench, cuts)
    return [_finding(t, f, time) for t in sorted(filter(None, found), key=lambda t: t.low)]


def _blocks_of(spans, f: Blocks, time) -> list[tuple[int, int]]:
    """Spans in blocks, those that touch joined."""
    out: list[tuple[int, int]] = []
    for start, stop in sorted(spans):
        low = int(np.searchsorted(time, start)) // f.size
        high = -(-int(np.searchsorted(time, stop)) // f.size) + 1
        if out and low <= out[-1][1] + 4:
            out[-1] = (out[-1][0], max(high, out[-1][1]))
        else:
            out.append((low, min(high, f.k)))
    return out


def _untouched(bench: Bench, cuts: list[tuple[int, int]]) -> list[Turn]:
    """Tilts that no disturbance gave away, the largest first; each ends what the next may use."""
    edges = [0, *(e for cut in cuts for e in cut), bench.f.k]
    found: list[Turn] = []
    open_stretches = list(zip(edges[::2], edges[1::2]))
    while open_stretches and len(found) < MOST:
        low, high = open_stretches.pop()
        at = [a for a in bench.candidates() if low + 4 <= a <= high - 4]
        turns = [t for t in (bench.step(a, (low, high)) for a in at) if t is not None]
        if turns:
            best = max(turns, key=lambda t: float(np.linalg.norm(t.change)))
            found.append(best)
            open_stretches += [(low, best.low), (best.high, high)]
    return found


def _span(turn: Turn, f: Blocks) -> tuple[int, int]:
    """Blocks [low, high) in which the turn went on: the ramp of gravity that fits best."""
    low, high = max(0, turn.low), min(f.k, turn.high)
    if high - low < 3:
        return low, high
    first, last = max(0, low - 8), min(f.k, high + 8)
    before = f.mean(first, low) if low > first else f.means[:, low]
    done = turn.change @ (f.means[:, first:last] - before[:, None]) / (turn.change @ turn.change)
    at = np.arange(first, last) + 0.5
    best, out = np.inf, (low, high)
    ends = range(low, high + 1, -(-(high - low) // ENDS))
    for i in ends[:-1]:
        for j in (k for k in ends if k > i):
            left = float(np.sum((done - np.clip((at - i) / (j - i), 0.0, 1.0)) ** 2))
            if left < best:
                best, out = left, (i, j)
    return out


def _finding(turn: Turn, f: Blocks, time) -> Finding:
    low, high = _span(turn, f)
    low, high = low * f.size, min(high * f.size, len(time) - 1)
    start, stop = float(time[low]), float(time[high])
    angle = float(np.linalg.norm(turn.angles))
    seen = (
        "the gyros' pulse and the change of gravity agree"
        if np.isfinite(turn.pulse) and turn.pulse > TURNED
        else "gravity changed its direction"
        if not np.isfinite(turn.pulse)
        else "after a knock gravity stays changed, by less than the gyros can show"
    )
    return Finding(
        "tilt",
        tuple(f"accel_{a}" for a in "xyz"),
        start,
        stop,
        {"time": start, "angles": [float(a) for a in turn.angles]},
        {
            "change_over_noise": turn.score,
            "pulse_over_noise": turn.pulse if np.isfinite(turn.pulse) else None,
            "change": [float(c) for c in turn.change],
        },
        f"The sensor was tilted by {angle_in_words(angle)} at {seconds(start)} s: {seen}.",
        MEANS,
        np.arange(low, high + 1),
    )


def angle_in_words(angle: float) -> str:
    degrees = np.degrees(angle)
    return f"{degrees:.3g} deg" if degrees >= 0.5 else f"{60 * degrees:.3g} arcmin"
