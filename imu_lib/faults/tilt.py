"""It was tilted: the accelerometers' gravity changes for good, and the gyros show the pulse that
turned it. A step of an accelerometer alone is the electronics'.

A turn by the small rotation vector `a` changes the specific force of a body at rest by -a x f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.faults.blocks import Blocks, peaks, sudden
from imu_lib.faults.finding import Finding, seconds

#: Blocks on each side of a candidate, and blocks of the turn itself left out on each side.
WIDTHS = (8, 32, 120)
GUARDS = (1, 2, 4, 8, 16, 32)
#: Standard deviations: of a change of the accelerometers, and of the gyros' pulse.
CHANGED, TURNED = 6.0, 4.5
#: Deviation of the two turns from each other: standard deviations and share of the turn.
AGREE, SHARE = 3.5, 0.15
#: rad of a change of direction that no step of the electronics makes.
LARGE = 0.1
#: Share by which the length of the specific force may change in it.
LENGTH = 0.1
#: s on each side of a hole that tell the attitude, and rad of a change told at the least.
ASIDE, LEAST_IN_HOLE = 60.0, 3e-3
MEANS = (
    "The sensor moved: the accelerometers see another part of gravity from then on. Taken for one "
    "record, it is a step, and slow noise that there is not."
)


@dataclass
class Turn:
    """A candidate: blocks [low, high), rotation vector (rad), change of the specific force."""

    low: int
    high: int
    angles: np.ndarray
    change: np.ndarray
    score: float
    pulse: float


def find(
    x: dict[str, np.ndarray], time: np.ndarray, rate: float, knocks: list[tuple[float, float]]
) -> list[Finding]:
    """Tilts within one stretch without holes. `knocks` are spans (s) in which it was touched."""
    accels = [c for c in (f"accel_{a}" for a in "xyz") if c in x]
    gyros = [c for c in (f"gyro_{a}" for a in "xyz") if c in x]
    if len(accels) < 3:
        return []
    f = Blocks(np.stack([x[c] for c in accels]), rate)
    w = Blocks(np.stack([x[c] for c in gyros]), rate) if len(gyros) == 3 else None
    if f.k < 24:
        return []
    gravity = float(np.linalg.norm(np.median(f.means, axis=1)))
    if not gravity > 5.0:
        return []
    found: list[Turn] = []
    wander = {
        (width, guard): sudden(f.change(width, guard), 2 * (width + guard))
        for width in WIDTHS
        for guard in GUARDS
        if guard <= 2 * width
    }
    for at in _candidates(f, wander):
        turn = _judge(f, w, at, gravity, wander, _touched(at, f, time, knocks))
        if turn is not None:
            found.append(turn)
    return [_finding(t, f, w, time) for t in _apart(found)]


def _candidates(f: Blocks, wander: dict) -> list[int]:
    """Boundaries of blocks at which an accelerometer changes for good."""
    at: list[int] = []
    for (width, guard), (off, scale) in wander.items():
        if f.k >= 3 * width:
            at += peaks(np.max(np.abs(off) / scale, axis=0), CHANGED, width + guard)
    at.sort()
    # nearby ones are one candidate each four blocks at the most
    return [a for i, a in enumerate(at) if i == 0 or a - at[i - 1] > 2]


def _touched(at: int, f: Blocks, time, knocks) -> bool:
    t = time[min(at * f.size, len(time) - 1)]
    return any(low - 3.0 <= t <= high + 3.0 for low, high in knocks)


def _scatter(b: Blocks, low: int, high: int) -> np.ndarray:
    """Standard deviation of a block mean around there, from neighbours' differences."""
    part = b.means[:, max(0, low) : max(high, 0)]
    if part.shape[1] < 6:
        part = b.means
    return 1.4826 * np.median(np.abs(np.diff(part, axis=1)), axis=1) / np.sqrt(2)


def _judge(f, w, at: int, gravity: float, wander: dict, touched: bool) -> Turn | None:
    best: Turn | None = None
    for width in WIDTHS:
        for guard in GUARDS:
            if guard > 2 * width or at - guard < 4 or at + guard > f.k - 4:
                continue
            turn = _turn(f, w, at, (width, guard), gravity, wander[width, guard][1], touched)
            if turn is None:
                continue
            if best is None or turn.score > 1.5 * best.score:
                best = turn
    return best


def _turn(f, w, at, scale_of, gravity, wander, touched) -> Turn | None:
    width, guard = scale_of
    before = f.mean(at - guard - width, at - guard)
    after = f.mean(at + guard, at + guard + width)
    change = after - before
    left, right = min(width, at - guard), min(width, f.k - at - guard)
    sides = np.sqrt(1 / left + 1 / right)
    scale = _scatter(f, at - guard - width, at + guard + width) * sides
    # what the level wanders beyond white noise in as long
    sd = np.maximum(scale, np.where(np.isfinite(wander[:, 0]), wander[:, 0] / np.sqrt(1.5), 0.0))
    score = float(np.max(np.abs(change) / sd))
    if score < CHANGED:
        return None
    length = abs(np.linalg.norm(after) - np.linalg.norm(before)) / gravity
    angle = float(np.arctan2(np.linalg.norm(np.cross(before, after)), np.dot(before, after)))
    minimal = _rotation(before, after)
    if angle > LARGE and length < LENGTH:
        return Turn(at - guard, at + guard, minimal, change, score, np.inf)
    if w is None:
        return Turn(at - guard, at + guard, minimal, change, score, 0.0) if touched else None
    span = 2 * guard * w.dt
    bias = 0.5 * (w.mean(at - guard - width, at - guard) + w.mean(at + guard, at + guard + width))
    turn = (w.mean(at - guard, at + guard) - bias) * span
    noise = _scatter(w, at - guard - width, at + guard + width) * w.dt
    noise = noise * np.sqrt(2 * guard) * np.sqrt(1 + 2 * guard * (1 / left + 1 / right) / 4)
    mean_force = 0.5 * (before + after)
    told = -np.cross(turn, mean_force)
    told_sd = np.sqrt(_crossed(noise**2, mean_force**2))
    pulse = float(np.max(np.abs(told) / np.maximum(told_sd, 1e-300)))
    expected = np.linalg.norm(change) / max(float(np.median(told_sd[told_sd > 0])), 1e-300)
    sd_of_both = np.sqrt(sd**2 + told_sd**2)
    agree = np.all(np.abs(change - told) < AGREE * sd_of_both + SHARE * np.linalg.norm(change))
    if pulse > TURNED and agree:
        return Turn(at - guard, at + guard, turn, change, score, pulse)
    if touched and expected < TURNED and score > 1.5 * CHANGED:
        return Turn(at - guard, at + guard, minimal, change, score, pulse)
    return None


def _crossed(a, b) -> np.ndarray:
    """Variances of a cross product of independent errors `a` with exact numbers, squares given."""
    return np.array(
        [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
    )


def _rotation(before, after) -> np.ndarray:
    """The smallest rotation vector that makes the specific force `before` the one `after`."""
    axis = np.cross(after, before)
    size = np.linalg.norm(axis)
    if size == 0:
        return np.zeros(3)
    return axis / size * float(np.arctan2(size, np.dot(before, after)))


def _apart(turns: list[Turn]) -> list[Turn]:
    """Of turns that overlap the clearest."""
    kept: list[Turn] = []
    for t in sorted(turns, key=lambda t: -t.score):
        if all(t.high + 4 < k.low or t.low > k.high + 4 for k in kept):
            kept.append(t)
    return sorted(kept, key=lambda t: t.low)


def _span(turn: Turn, f: Blocks, w: Blocks | None) -> tuple[int, int]:
    """Blocks [low, high) in which the turn went on: from 5 to 95 % of it."""
    low, high = max(0, turn.low), min(f.k, turn.high)
    if high - low < 3:
        return low, high
    if w is not None and np.isfinite(turn.pulse) and turn.pulse > TURNED:
        part = turn.angles @ (w.means[:, low:high] - np.median(w.means, axis=1)[:, None])
        done = np.cumsum(part)
    else:
        done = turn.change @ (
            f.means[:, low:high] - f.means[:, max(0, low - 8) : low + 1].mean(axis=1)[:, None]
        )
        done = np.maximum.accumulate(done)
    if not done[-1] > 0:
        return low, high
    inside = np.flatnonzero((done > 0.05 * done[-1]) & (done < 0.95 * done[-1]))
    if not len(inside):
        at = low + int(np.argmax(done >= 0.5 * done[-1]))
        return at, at + 1
    return low + int(inside[0]), low + int(inside[-1]) + 2


def _finding(turn: Turn, f: Blocks, w: Blocks | None, time) -> Finding:
    low, high = _span(turn, f, w)
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
        f"The sensor was tilted by {_angle(angle)} at {seconds(start)} s: {seen}.",
        MEANS,
        np.arange(low, high + 1),
    )


def _angle(angle: float) -> str:
    degrees = np.degrees(angle)
    return f"{degrees:.3g} deg" if degrees >= 0.5 else f"{60 * degrees:.3g} arcmin"


def in_hole(x: dict[str, np.ndarray], time: np.ndarray, at: int) -> Finding | None:
    """Whether the attitude changed between the rows `at` and `at` + 1, before and after a hole."""
    accels = [f"accel_{a}" for a in "xyz"]
    if any(c not in x for c in accels):
        return None
    first = int(np.searchsorted(time, time[at] - ASIDE))
    last = int(np.searchsorted(time, time[at + 1] + ASIDE, side="right"))
    first, last = min(first, max(0, at - 9)), max(last, min(len(time), at + 11))
    left = np.stack([x[c][first : at + 1] for c in accels])
    right = np.stack([x[c][at + 1 : last] for c in accels])
    if min(left.shape[1], right.shape[1]) < 4:
        return None
    before, after = np.median(left, axis=1), np.median(right, axis=1)
    turn = _rotation(before, after)
    angle = float(np.linalg.norm(turn))
    error = np.sqrt(left.var(axis=1) / left.shape[1] + right.var(axis=1) / right.shape[1])
    size = float(np.linalg.norm(before))
    if not size > 5.0:
        return None
    sure = angle * size / max(float(np.median(error)), 1e-300)
    if angle < LEAST_IN_HOLE or sure < 2 * CHANGED:
        return None
    start, stop = float(time[at]), float(time[at + 1])
    return Finding(
        "tilt",
        tuple(accels),
        start,
        stop,
        {"time": 0.5 * (start + stop), "angles": [float(a) for a in turn]},
        {"change_over_noise": sure, "change": [float(c) for c in after - before]},
        f"Within the hole from {seconds(start)} to {seconds(stop)} s the attitude changed by "
        f"{_angle(angle)}.",
        MEANS,
    )
