"""A stretch of a drive without a hole, along the filter's solution: its nodes and its fixes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.navigation import attitude
from imu_lib.navigation.stretch import Stretch

from .structures import Nominal

if TYPE_CHECKING:
    from imu_lib.navigation.preparation import Fixes
    from imu_lib.navigation.solution import Solution

LONGEST = 0.5  # s between nodes
FEWEST = 10  # epochs of a solution


@dataclass
class Leg:
    """stretch : of the IMU; first : its epoch at which the solution begins; position, velocity,
    angles, sd (k, 3) of the solution from there; fixes : rows of the fixes in it, a slice; epochs
    (f,) of these; node (n,) epochs at which the path is cut; drifts (s, 2) temperature and whether
    biases have stepped, at the stretch's intervals
    """

    stretch: Stretch
    first: int
    position: np.ndarray
    velocity: np.ndarray
    angles: np.ndarray
    sd: np.ndarray
    fixes: slice
    epochs: np.ndarray
    node: np.ndarray
    drifts: np.ndarray

    @classmethod
    def of(
        cls, drive: Drive, stretch: Stretch, solution: Solution, fixes: Fixes, step_at: float
    ) -> Leg | None:
        """None where the solution or the fixes of a stretch are too few; step_at : s, from where on
        biases may be others.
        """
        inside = (solution.time > stretch.time[0] - 1e-9) & (
            solution.time <= stretch.time[-1] + 1e-9
        )
        if inside.sum() < FEWEST:
            return None
        first = int(np.searchsorted(stretch.time, solution.time[inside][0] - 1e-9))
        epoch = np.searchsorted(stretch.time, fixes.time - 1e-9)
        mine = np.flatnonzero(
            (epoch > first) & (epoch < stretch.time.size) & (fixes.time > stretch.time[0])
        )
        if mine.size < 2:
            return None
        rows = slice(int(mine[0]), int(mine[-1]) + 1)
        return cls(
            stretch,
            first,
            solution.position[inside],
            solution.velocity[inside],
            solution.attitude[inside],
            solution.sd[inside, 6:9],
            rows,
            epoch[rows],
            _nodes(first, np.unique(epoch[rows]), max(int(round(LONGEST * drive.rate)), 1)),
            drifts(drive, stretch.time[:-1], step_at),
        )

    def at(self, epochs: Array) -> Nominal:
        """The solution at epochs of the stretch."""
        k = np.clip(epochs - self.first, 0, len(self.position) - 1)
        turned = Rotation.from_euler("ZYX", self.angles[k][:, ::-1])
        quat = turned.as_quat(scalar_first=True)
        return Nominal(self.position[k].copy(), self.velocity[k].copy(), quat)

    def at_nodes(self) -> dict[str, Array]:
        """What a problem keeps of the path there."""
        nominal = self.at(self.node)
        k = np.clip(self.node - self.first, 0, len(self.sd) - 1)
        return {
            "time": self.stretch.time[self.node],
            "position": nominal.position,
            "velocity": nominal.velocity,
            "attitude": attitude.euler(nominal.quaternion),
            "attitude_sd": self.sd[k],
        }


def _nodes(first: int, epochs: Array, longest: int) -> Array:
    """The first epoch, those of fixes, and between them as many as none is further than
    `longest`.
    """
    begin = np.concatenate([[first], epochs[:-1]])
    parts = [
        np.linspace(a, b, int(np.ceil((b - a) / longest)) + 1)[1:].round()
        for a, b in zip(begin, epochs)
        if b - a > longest
    ]
    return np.unique(np.concatenate([[first], epochs, *parts]).astype(np.int64))


def drifts(drive: Drive, time: Array, step_at: float) -> Array:
    """Temperature, and whether it is later than `step_at`, (n, 2)."""
    late = (time > step_at).astype(float)
    if drive.temperature is None:
        return np.column_stack([np.zeros(time.size), late])
    warmth = drive.temperature - np.mean(drive.temperature)
    return np.column_stack([np.interp(time, drive.time, warmth) / 10.0, late])
