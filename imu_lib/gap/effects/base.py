"""What an entry of the catalogue is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from imu_lib.gap.engine import AMPLITUDE_WIDTH, TIME_WIDTH, Slot


class Effect:
    """An entry of the catalogue: its name in the model file, its physical cause in a sentence, the
    domain it shows in.
    """

    name: ClassVar[str] = ""
    cause: ClassVar[str] = ""
    domain: ClassVar[str] = "psd"

    @property
    def key(self) -> str:
        """The name, and behind a colon which of several effects of that name it is."""
        return self.name

    def beside(self, low_pass, fs: float) -> bool:
        """Whether the effect can stand beside a filter (or None) in the sensor."""
        return True


class Spectral(Effect):
    """A noise that is known by its spectrum: a process added to the sum, its parameters free."""

    def grid(self, fs: float, duration: float) -> list:
        """Processes of unit strength from whose shapes the best start is chosen, each with its
        amplitude's name.
        """
        raise NotImplementedError

    amplitude: ClassVar[str] = "sigma"
    #: Log odds against the effect before the record is seen.
    rarity: ClassVar[float] = 0.0

    def slot(self, index: int, fs: float, duration: float) -> Slot:
        """The free parameters of the process at `index`."""
        free = [p for p in self.process.parameters if not p.optional]
        names = tuple(p.name for p in free)
        low = tuple(np.log(1.5 / fs) if p.kind == "time" else -60.0 for p in free)
        high = tuple(np.log(duration / 3) if p.kind == "time" else 30.0 for p in free)
        widths = tuple(TIME_WIDTH if p.kind == "time" else AMPLITUDE_WIDTH for p in free)
        return Slot(index, names, low, high, widths)

    process: ClassVar[type]


@dataclass
class Finding:
    """An effect found in the raw samples: the process or stage, log-likelihood gain, what it
    touches, intervals, doubts.
    """

    effect: Effect
    process: object
    gain: float
    where: str
    intervals: dict = field(default_factory=dict)
    mask: np.ndarray | None = None
    doubt: str | None = None


class Drift(Effect):
    """A deterministic drift: a shape whose amplitude is a regression coefficient, perhaps with one
    shape parameter.

    `sharp` drifts reach into the fast end of the spectrum: where the samples show the edge, the
    record is cleaned of it
    before it is looked at again.
    """

    domain = "mean"
    amplitude: ClassVar[str] = "amplitude"
    shape: ClassVar[str | None] = None
    sharp: ClassVar[bool] = False

    def candidates(self, data) -> list:
        """Processes of amplitude 1 over the range of the shape parameter; empty where the record
        cannot hold the effect.
        """
        raise NotImplementedError

    def columns(self, processes, data) -> np.ndarray:
        """Their block means, shape (blocks, len(processes))."""
        return np.column_stack([p.mean(data.block_time, data.block_temperature) for p in processes])

    def penalty(self, data, snr: float) -> float:
        """Log of posterior over prior width of the shape parameter at a signal-to-noise ratio."""
        return 0.0

    def bounds(self, data) -> tuple[float, float]:
        """Range of the logarithm of the shape parameter."""
        return 0.0, 0.0

    def around(self, process, data, reach: float, points: int) -> list:
        """Drifts with shapes up to `reach` grid steps either side of that of `process`."""
        low, high = self.bounds(data)
        values = np.exp(
            np.clip(
                np.log(getattr(process, self.shape))
                + np.linspace(-reach, reach, points) * (high - low) / 13,
                low,
                high,
            )
        )
        return [process.with_(**{self.shape: float(v)}) for v in np.unique(values)]

    def upright(self, process):
        """The drift whose amplitude is negative as one whose amplitude is positive, where there is
        one.
        """
        return process
