"""What the search on a drive holds at a moment: values, noise, and the path, innovations and
regression under them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.navigation import fix_rounding
from imu_lib.navigation.side_by_side import each
from imu_lib.units import DEG

from . import columns, correct, in_variables, regression, vehicle
from .path import build
from .problem import Noise, Problem

if TYPE_CHECKING:
    from . import random_effects
    from .problem import Innovations

NOT_YET: Any = None  # what `rebuild` makes, before it was first called
TURNED = 3.0 * DEG  # by which a heading at the start may be off before the path starts anew
LOST = 1.2  # times the size of the innovations: from here on a path has lost what another had


@dataclass
class Change:
    """An accepted change of what is random: its `random_effects.Change`, values and gain."""

    change: random_effects.Change
    values: np.ndarray
    gain: float
    before: Noise
    rivals: list[tuple[str, float, tuple[str, ...]]] = field(default_factory=list)
    noise: Noise = NOT_YET


@dataclass
class State:
    """What is held, and the drive under it; apart: nats that a rival on a path of its
    own lacks; loose, least: trust in positions and velocities for the path, and its least factor;
    heading: rad at its start, where one is held; base: the noise without the changes that are
    held; fitted_under: what was held each time that it was fitted again; step_at:
    s, from where on biases may be others; moved_at: s by the fixes' own stamps, from where on they
    may be displaced; free: whether the noise of the sensors is fitted to the drive.
    """

    drive: Drive
    noise: Noise
    theta: np.ndarray
    other: np.ndarray = field(default_factory=lambda: np.zeros(len(columns.ALL)))
    kept: tuple[str, ...] = ()
    changes: list[Change] = field(default_factory=list)
    restarts: tuple[float, ...] = ()
    problem: Problem = NOT_YET
    result: Innovations = NOT_YET
    use: np.ndarray = NOT_YET
    reg: regression.Regression = NOT_YET
    withhold: tuple[tuple[float, float], ...] = ()
    heading: float | None = None
    apart: dict[tuple[str, str], float] = field(default_factory=dict)
    loose: np.ndarray = field(default_factory=lambda: np.ones(2))
    least: np.ndarray = field(default_factory=lambda: np.ones(2))
    base: Noise = NOT_YET
    fitted_under: tuple[tuple[object, ...], ...] = ()
    step_at: float | None = None
    moved_at: float = np.inf
    free: bool = False

    def rebuild(self) -> None:
        """The path, innovations and regression at what is held now.

        Fixes that the last path could not follow are trusted less for the next, and no more again
        where the path then loses them. A path that starts with a heading far from what it finds
        later is built again from there.
        """
        before, size = self.loose, np.inf if self.result is None else self.size()
        self._build(self._trust())
        if self.heading is None and self._turn():
            self._build(self.loose)
        if self.size() > LOST * size and np.any(self.loose < before):
            self.least = np.maximum(self.least, before)
            self._build(self.least)

    def _trust(self) -> Array:
        """By how much less than stated positions and velocities are to be trusted, (2,)."""
        loose = self.least.copy()
        if self.result is not None:
            e2 = np.where(self.use, self.result.e, np.nan) ** 2
            for k in (0, 1):
                part = e2[:, 3 * k : 3 * k + 3]
                if np.isfinite(part).any():
                    loose[k] = np.clip(np.sqrt(np.nanmean(part)), loose[k], 30.0)
        return loose

    def _turn(self) -> bool:
        """Hold the heading at the start as the path has it later, if that is another: whether
        so.
        """
        path = self.problem.path
        found = vehicle.heading_since(self.problem, path["time"][0])
        if found is None or found[1] > TURNED:
            return False
        apart = abs((found[0] - path["attitude"][0, 2] + np.pi) % (2.0 * np.pi) - np.pi)
        if apart < TURNED:
            return False
        self.heading = found[0]
        return True

    def _build(self, loose: Array) -> None:
        self.loose = loose
        self.problem = build(
            correct.corrected(self.drive, self.theta, self.moved_at),
            self.noise,
            heading=self.heading,
            velocity_shift=correct.velocity_shift(self.theta),
            restarts=self.restarts,
            loose=loose,
            step_at=self.stepped,
            moved_at=self.moved_at - correct.value(self.theta, "gnss_time_offset")[0],
            steps=fix_rounding.steps(self.drive),  # what is put right lies on no grid
        )
        away = np.zeros(self.problem.time.size, bool)
        for start, duration in self.withhold:
            away |= (self.problem.time > start) & (self.problem.time <= start + duration)
        self.use = self.problem.use & ~away[:, None]
        self.weigh()

    @property
    def stepped(self) -> float:
        """From where on biases may be others, s: the middle of the drive if nothing is known."""
        middle = 0.5 * float(self.drive.time[0] + self.drive.time[-1])
        return middle if self.step_at is None else self.step_at

    def copy(self) -> State:
        """The same, and apart from it: what is changed in place is copied."""
        return replace(
            self,
            theta=self.theta.copy(),
            other=self.other.copy(),
            changes=[replace(c) for c in self.changes],
        )

    def take(self, other: State) -> None:
        """Be where another state is: values, path, innovations and regression."""
        for name in (
            "theta",
            "other",
            "kept",
            "problem",
            "result",
            "use",
            "reg",
            "loose",
            "least",
            "heading",
            "step_at",
            "moved_at",
        ):
            setattr(self, name, getattr(other, name))

    def size(self) -> float:
        """Mean square of the innovations."""
        return float(np.mean(self.result.e[self.use & np.isfinite(self.result.e)] ** 2))

    def cost(self) -> float:
        """Misfit of the innovations, nats, of which those far out are not let decide."""
        good = self.use & np.isfinite(self.result.e)
        e, s = np.abs(self.result.e[good]), self.result.s[good]
        far = np.where(
            e < regression.HUBER, 0.5 * e**2, regression.HUBER * (e - 0.5 * regression.HUBER)
        )
        return float(np.mean(far + 0.5 * np.log(s))) * self.use.sum()

    def weigh(self) -> None:
        """Innovations and regression under the noise held now, on the path as it is."""
        parts: tuple[Callable[[], Any], ...] = (
            lambda: self.evaluate(self.noise, sens=True),
            lambda: in_variables.squares(self.problem, self.noise, self.use),
        )
        result, noisy = each(lambda part: part(), parts)
        self.reg = regression.of(self.problem, result, self.theta + self.other, self.use, noisy)
        self.result = replace(result, jac=None)  # large, and in the regression

    def evaluate(self, noise: Noise, sens: bool = False) -> Innovations:
        """Innovations under a noise, causes outside the catalogue taken out."""
        return self.problem.evaluate(noise, sens=sens, use=self.use, held=self.other)
