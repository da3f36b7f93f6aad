"""All that is random fitted at once: the levels of a noise without a model, and the changes held.

A change that is fitted beside levels which were fitted without it comes out too small, as they hold
a part of it, and its interval too narrow. All climb together by scores: the log-likelihood of a
fix is differentiated, and the sum of the squares is the information (Berndt et al. 1974).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array
from imu_lib.navigation.side_by_side import each

from . import levels, random_effects

if TYPE_CHECKING:
    from .problem import Noise
    from .state import State

STEP = 0.03  # of the logarithms: differences


@dataclass(frozen=True)
class Joint:
    """Logarithms of the levels (b,) and of the changes' values, of a state, side by side.

    ratios : levels of the fixes' errors; middle, width (k,): of the priors; parts : where each
    change's values are
    """

    state: State
    ratios: tuple[str, ...]
    start: np.ndarray
    middle: np.ndarray
    width: np.ndarray
    parts: tuple[slice, ...]

    @classmethod
    def of(cls, state: State) -> Joint:
        """Of a state: where it stands is the start."""
        ratios = tuple(levels.unstated(state)) if state.free else ()
        own = levels.of(state.noise, ratios) if state.free else np.zeros(0)
        usual = levels.start(ratios) if state.free else np.zeros(0)
        wide = np.full(own.size, levels.PRIOR)
        wide[4:] = np.inf
        values = [np.log(c.values) for c in state.changes]
        ends = own.size + np.cumsum([0, *(v.size for v in values)])
        return cls(
            state,
            ratios,
            np.concatenate([own, *values]),
            np.concatenate([usual, *(c.change.middle for c in state.changes)]),
            np.append(wide, np.full(ends[-1] - own.size, random_effects.PRIOR)),
            tuple(slice(a, b) for a, b in zip(ends[:-1], ends[1:])),
        )

    def entered(self, x: Array) -> Noise:
        """The noise at x (k,)."""
        noise = self.state.noise
        if self.state.free:
            noise = levels.entered(noise, x[: 4 + len(self.ratios)], self.ratios)
        for part, held in zip(self.parts, self.state.changes):
            noise = held.change.enter(noise, np.exp(x[part]))
        return noise

    def by_fix(self, x: Array) -> Array:
        """Log-likelihood of each fix, nats (f,)."""
        return self.state.evaluate(self.entered(x)).by_fix

    def value(self, x: Array) -> float:
        """Log-likelihood with the priors, nats."""
        pull = 0.5 * float(np.sum(((x - self.middle) / self.width) ** 2))
        value = float(self.by_fix(x).sum()) - pull
        return value if np.isfinite(value) else -1e12

    def slope(self, x: Array) -> tuple[Array, Array]:
        """Slope (k,) and information (k, k) at x."""
        steps = STEP * np.eye(x.size)
        both = np.array(each(self.by_fix, [x + s * d for d in steps for s in (1.0, -1.0)]))
        scores = (both[::2] - both[1::2]) / (2.0 * STEP)
        prior = self.width**-2.0
        return scores.sum(axis=1) - prior * (x - self.middle), scores @ scores.T + np.diag(prior)

    def follow(self, part: slice) -> Array:
        """By how much all logarithms move, (k, p), with those of one part as the likelihood has
        them.
        """
        mine = np.zeros(self.start.size, bool)
        mine[part] = True
        return following(self.slope(self.start)[1], mine)


@dataclass(frozen=True)
class Effort:
    """Of an ascent: steps at most, the longest of them and the shares of it that are tried, in
    logarithms, and nats that a further one would gain.
    """

    steps: int
    longest: float
    shares: tuple[float, ...]
    close: float


WHOLE = Effort(steps=10, longest=1.0, shares=(1.0, 0.5, 0.2, 0.05), close=0.03)


def climb(joint: Joint) -> Array:
    """The logarithms at the maximum."""
    x = joint.start
    return ascent(joint, x, np.ones(x.size, bool), WHOLE)[0]


def ascent(joint: Joint, x: Array, free: Array, effort: Effort) -> tuple[Array, float, Array]:
    """(x, its value, information about it) with the logarithms that are `free`, (k,) bool, led to
    their best by scores.
    """
    value = joint.value(x)
    for _ in range(effort.steps):
        slope, information = joint.slope(x)
        seen = free & (np.diag(information) > 0.0)
        step = np.zeros(x.size)
        step[seen] = np.linalg.solve(information[np.ix_(seen, seen)], slope[seen])
        if 0.5 * float(slope @ step) < effort.close:
            break
        step *= min(1.0, effort.longest / np.abs(step).max())
        tried = [x + share * step for share in effort.shares]
        values = each(joint.value, tried)
        best = int(np.argmax(values))
        if values[best] <= value:
            break
        gained, value, x = values[best] - value, values[best], tried[best]
        if gained < effort.close:
            break
    return x, value, information


def following(information: Array, mine: Array) -> Array:
    """By how much all logarithms move, (k, p), with those of `mine`, (k,) bool, that are held."""
    out = np.eye(len(mine))[:, mine]
    rest = ~mine & (np.diag(information) > 0.0)
    out[rest] = -np.linalg.solve(information[np.ix_(rest, rest)], information[np.ix_(rest, mine)])
    return out
