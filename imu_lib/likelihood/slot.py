"""A process some of whose parameters are free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import Process

from .layout import amplitude_of

Kind = TypeVar("Kind", bound=Process)
#: Index of the low-pass filter, which stands behind the terms.
FILTER = -1


@dataclass(frozen=True)
class Slot:
    """Free parameters of one process, on a logarithmic scale.

    Attributes
    ----------
    index : int
        The process among the terms of a model; `FILTER` for the low-pass filter.
    names : tuple of str
        The parameters; a kind of slot may write a process by other ones than its fields.
    low, high : tuple of float
        Bounds of their logarithms.
    widths : tuple of float
        Widths of their log-uniform priors, for the evidence.
    labels : tuple of str
        What they are called in a report; the names where it is empty.
    """

    index: int
    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    widths: tuple[float, ...] = ()
    labels: tuple[str, ...] = ()

    def read(self, process: Process) -> list[float]:
        """The vector of a process."""
        return [float(np.log(getattr(process, name))) for name in self.names]

    def write(self, process: Kind, vector: Array) -> Kind:
        """The process at a vector."""
        return process.with_(**{name: float(np.exp(v)) for name, v in zip(self.names, vector)})

    def relative(self, process: Process, name: str) -> Array:
        """Relative change of the process's parameter `name` with each entry of the vector."""
        return (np.array(self.names) == name).astype(float)

    def strength(self, process: Process) -> int | None:
        """Place of the parameter that scales the process, in the vector; None where it is held."""
        if self.index == FILTER or amplitude_of(process) not in self.names:
            return None
        return self.names.index(amplitude_of(process))
