"""What an effect on a drive answers: which columns or noise it is, how it is written, how a drive
is put right for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from imu_lib.arrays import Array

from .. import columns


@dataclass(frozen=True)
class Effect:
    """name : in the model file; cause : one sentence; words : where it shows."""

    name: ClassVar[str]
    cause: ClassVar[str]
    words: ClassVar[str]


@dataclass(frozen=True)
class Linear(Effect):
    """An effect whose parameters are columns of the innovations.

    key : its vector parameter, or None where each component is a parameter of its own; unexcited :
    what a drive lacks where a component cannot be seen
    """

    key: ClassVar[str | None] = None
    unexcited: ClassVar[str]

    @property
    def columns(self) -> list[int]:
        return columns.of(self.name)

    def parameters(self, values: Array) -> dict[str, Any]:
        """The model file's parameters from the columns' values (k,)."""
        if self.key:
            return {self.key: [float(v) for v in values]}
        names = [columns.ALL[i].component for i in self.columns]
        return {n: float(v) for n, v in zip(names, values)}

    def intervals(self, values: Array, sd: Array) -> dict[str, Any]:
        low, high = np.asarray(values) - 1.96 * sd, np.asarray(values) + 1.96 * sd
        pairs = [[float(a), float(b)] for a, b in zip(low, high)]
        if self.key:
            return {self.key: pairs}
        names = [columns.ALL[i].component for i in self.columns]
        return dict(zip(names, pairs))
