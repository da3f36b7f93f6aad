"""A turn of the sensor: the change of gravity on the accelerometers beside the pulse of the gyros.

A turn by the small rotation vector `a` changes the specific force of a body at rest by -a x f.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.faults.blocks import Blocks, peaks, sudden

#: Blocks on each side of a candidate, and blocks of the turn itself left out on each side.
WIDTHS = (8, 32, 120)
GUARDS = (1, 2, 4, 8, 16, 32, 48, 72, 100)
#: Standard deviations: of a change of the accelerometers, and of the gyros' pulse.
CHANGED, TURNED = 6.0, 4.5
#: Deviation of the two turns from each other: standard deviations and share of the turn.
AGREE, SHARE = 3.5, 0.15
#: rad of a change of direction that no step of the electronics makes.
LARGE = 0.1
#: Share by which the length of the specific force may change in it.
LENGTH = 0.1
#: Blocks of a turn from which on the gyros' slow noise is more than their white one.
SLOW = 40
#: Blocks of a touched span from which on they tell how it was shaken.
SHAKEN = 6
#: Stretches of a record that tell what the gyros do in as long a time, at the least.
FEWEST = 20
#: Tilts looked for at the most beyond those where it was touched.
MOST = 20


@dataclass
class Turn:
    """A candidate: blocks [low, high), rotation vector (rad), change of the specific force."""

    low: int
    high: int
    angles: np.ndarray
    change: np.ndarray
    score: float
    pulse: float


class Bench:
    """Means of both sensors, and what changes of the accelerometers are usual."""

    def __init__(self, f: Blocks, w: Blocks | None, gravity: float):
        self.f, self.w, self.gravity = f, w, gravity
        self.wander = {}
        for width in WIDTHS:
            for guard in GUARDS:
                if guard <= 2 * width and f.k >= 3 * width:
                    change = f.change(width, guard)
                    self.wander[width, guard] = sudden(change, 2 * (width + guard))
        self._candidates: list[int] | None = None
        self._levels: dict[tuple[int, int], np.ndarray] = {}

    def candidates(self) -> list[int]:
        """Boundaries of blocks at which an accelerometer changes for good, the clearest MOST."""
        if self._candidates is None:
            at: dict[int, float] = {}
            for (width, guard), (off, scale) in self.wander.items():
                score = np.max(np.abs(off) / scale, axis=0)
                for i in peaks(score, CHANGED, width + guard):
                    at[i] = max(at.get(i, 0.0), float(score[i]))
            best = sorted(at, key=lambda i: -at[i])[: 3 * MOST]
            self._candidates = sorted(best)
        return self._candidates

    def step(self, at: int, limits: tuple[int, int]) -> Turn | None:
        """The change at a boundary as a turn: the shortest that has nearly all of it."""
        return _shortest([self.turn(at - g, at + g, limits, touched=False) for g in GUARDS])

    def widest(self, low: int, high: int, limits: tuple[int, int]) -> Turn | None:
        """The change about blocks [low, high) in which it was touched: the turn may have begun
        before and go on after.
        """
        more = [g for g in (0, *GUARDS) if g < SLOW]
        spans = sorted(((low - i, high + j) for i in more for j in more), key=lambda s: s[1] - s[0])
        turns = [self.turn(*span, limits, touched=True) for span in spans]
        return _shortest([t for t in turns if t is None or t.pulse > TURNED or t is turns[0]])

    def turn(self, low: int, high: int, limits: tuple[int, int], *, touched: bool) -> Turn | None:
        """Blocks [low, high) as a turn, by the means of both sides within `limits`; None where it
        is none.
        """
        best: Turn | None = None
        for width in WIDTHS:
            left, right = min(width, low - limits[0]), min(width, limits[1] - high)
            if min(left, right) < 4 or min(left, right) < width // 4:
                continue
            turn = self._turn(low, high, left, right, touched)
            if turn is not None and (best is None or turn.score > 1.5 * best.score):
                best = turn
        return best

    def _turn(self, low, high, left, right, touched) -> Turn | None:
        f, w = self.f, self.w
        before, after = f.mean(low - left, low), f.mean(high, high + right)
        change = after - before
        usual = self._usual(left, low, high)
        if np.all(np.abs(change) < CHANGED * usual):  # told before what takes longer
            return None
        sides = np.sqrt(1 / left + 1 / right)
        sd = np.maximum(_scatter(f, low - left, high + right) * sides, usual)
        score = float(np.max(np.abs(change) / sd))
        if score < CHANGED:
            return None
        length = abs(np.linalg.norm(after) - np.linalg.norm(before)) / self.gravity
        minimal = rotation(before, after)
        if np.linalg.norm(minimal) > LARGE and length < LENGTH:
            return Turn(low, high, minimal, change, score, np.inf)
        if w is None:
            return Turn(low, high, minimal, change, score, 0.0) if touched else None
        span = high - low
        first, last = w.mean(low - left, low), w.mean(high, high + right)
        turn = (w.mean(low, high) - 0.5 * (first + last)) * span * w.dt
        noise = _scatter(w, low - left, high + right) * w.dt
        noise = noise * np.sqrt(span) * np.sqrt(1 + span * (1 / left + 1 / right) / 4)
        if touched and span >= SHAKEN:
            noise = np.maximum(noise, _scatter(w, low, high) * w.dt * np.sqrt(span))
        if span > SLOW:
            noise = np.maximum(noise, self._wandering(span, left, right))
        mean_force = 0.5 * (before + after)
        told = -np.cross(turn, mean_force)
        told_sd = np.sqrt(_crossed(noise**2, mean_force**2))
        pulse = float(np.max(np.abs(told) / np.maximum(told_sd, 1e-300)))
        both = np.sqrt(sd**2 + told_sd**2)
        agree = np.all(np.abs(change - told) < AGREE * both + SHARE * np.linalg.norm(change))
        # the level of the gyros themselves may have changed: that is no pulse
        shifted = np.linalg.norm((last - first) * span * w.dt) > 0.5 * np.linalg.norm(turn)
        if pulse > TURNED and agree and not shifted:
            # gravity tells the tilt better than the pulse; a turn about it the gyros alone
            up = mean_force / np.linalg.norm(mean_force)
            about = float(turn @ up)
            if abs(about) < TURNED * float(np.sqrt(noise**2 @ up**2)):
                about = 0.0
            return Turn(low, high, minimal + about * up, change, score, pulse)
        if not (told_sd > 0).any():
            return None
        expected = np.linalg.norm(change) / max(float(np.median(told_sd[told_sd > 0])), 1e-300)
        if touched and expected < TURNED and score > 1.5 * CHANGED:
            return Turn(low, high, minimal, change, score, pulse)
        return None

    def _wandering(self, span, left, right) -> np.ndarray:
        """What the gyros seem to turn in as long while nothing happens: standard deviations of the
        rotation vector, shape (3,); 0 where the record is too short to tell.
        """
        w = self.w
        i = np.arange(left, w.k - span - right + 1, max(1, span // 4))
        if len(i) < FEWEST:
            return np.zeros(3)
        sides = 0.5 * (w.mean(i - left, i) + w.mean(i + span, i + span + right))
        off = (w.mean(i, i + span) - sides) * span * w.dt
        return 1.4826 * np.median(np.abs(off - np.median(off, axis=1)[:, None]), axis=1)

    def _usual(self, width, low, high) -> np.ndarray:
        """What a level wanders in as long beyond white noise: standard deviations, shape (3,)."""
        guard = (high - low + 1) // 2
        asked = width, guard
        if asked not in self._levels:
            keys = [k for k in self.wander if k[0] <= max(width, WIDTHS[0])]
            key = min(keys, key=lambda k: (abs(k[0] - width), abs(k[1] - guard)), default=None)
            scale = self.wander[key][1][:, 0] if key else np.zeros(3)
            self._levels[asked] = np.where(np.isfinite(scale), scale / np.sqrt(1.5), 0.0)
        return self._levels[asked]


def _shortest(turns: list[Turn | None]) -> Turn | None:
    """Of turns, the longer ones later, the first that has nearly all of the change."""
    there = [t for t in turns if t is not None]
    size = [float(np.linalg.norm(t.change)) for t in there]
    return next((t for t, s in zip(there, size) if s > 0.9 * max(size)), None)


def _scatter(b: Blocks, low: int, high: int) -> np.ndarray:
    """Standard deviation of a block mean around there, from neighbours' differences."""
    part = b.means[:, max(0, low) : max(high, 0)]
    if part.shape[1] < 6:
        part = b.means
    return 1.4826 * np.median(np.abs(np.diff(part, axis=1)), axis=1) / np.sqrt(2)


def _crossed(a, b) -> np.ndarray:
    """Variances of a cross product of independent errors `a` with exact numbers, squares given."""
    return np.array(
        [a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2], a[0] * b[1] + a[1] * b[0]]
    )


def rotation(before, after) -> np.ndarray:
    """The smallest rotation vector that makes the specific force `before` the one `after`."""
    axis = np.cross(after, before)
    size = np.linalg.norm(axis)
    if size == 0:
        return np.zeros(3)
    return axis / size * float(np.arctan2(size, np.dot(before, after)))
