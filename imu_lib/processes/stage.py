"""What an output stage answers beyond a process: how it acts on the whole signal."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from imu_lib.arrays import Array

from .base import Process


class Stage(Process):
    """Base of the output stages."""

    #: Position in the chain.
    place: ClassVar[float] = 0

    def apply(self, x: Array, fs: float, rng: np.random.Generator) -> Array:
        """The signal behind the stage: ndarray, shape (n,), from `x`, shape (n,), at `fs` Hz."""
        raise NotImplementedError

    def added_variance(self, fs: float) -> float:
        """White variance that the stage adds to every sample, unit^2."""
        return 0.0
