"""What acts on several channels of a record, or on its clock."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from imu_lib.arrays import Array
from imu_lib.errors import InputError

from .base import FREE, Parameter, Process
from .white import WhiteNoise


@dataclass(frozen=True)
class CommonMode(WhiteNoise):
    """White noise that several channels share (supply, reference voltage, vibration).

    Parameters
    ----------
    N : float, signal unit / sqrt(Hz)
    channels : sequence of str
    filtered : int, optional
        1: it enters before the channels' low-pass filters; else behind them.
    """

    channels: tuple[str, ...] = ()
    filtered: int | None = None
    name: ClassVar[str] = "common_mode"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *WhiteNoise.parameters,
        Parameter("filtered", "count", "1: before the channels' filters", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.channels, str) or not all(isinstance(c, str) for c in self.channels):
            raise InputError("process common_mode: `channels` must be a list of channel names")
        object.__setattr__(self, "channels", tuple(self.channels))

    @property
    def behind_filter(self) -> bool:
        return not self.filtered

    def to_json(self) -> dict[str, Any]:
        return {**super().to_json(), "channels": list(self.channels)}

    def on(
        self, filters: dict[str, Any], n: int, fs: float, rng: np.random.Generator
    ) -> dict[str, Any]:
        """What each of its channels (name -> low-pass filter or None) gets of one draw: name ->
        ndarray, shape (n,).
        """
        filters = {name: f if self.filtered else None for name, f in filters.items()}
        grids = {name: (1, 0) if f is None else f.grid(fs) for name, f in filters.items()}
        fine = math.lcm(*(steps for steps, _ in grids.values()))
        lead = max((-(-before // steps) for steps, before in grids.values()), default=0)
        white = self.with_(channels=()).simulate((n + lead) * fine, fs * fine, rng)
        out = {}
        for name, (steps, before) in grids.items():
            x = white.reshape(-1, fine // steps).mean(axis=1)[lead * steps - before :]
            out[name] = x if filters[name] is None else filters[name].run(x, fs, n)
        return out


@dataclass(frozen=True)
class TimeGaps(Process):
    """A `fraction` of the samples is missing from the record, in runs of `length` samples.

    Parameters
    ----------
    fraction : float, 0 to 1
    length : int, optional, samples; 1 where not given
    """

    fraction: float = FREE
    length: int | None = None
    name: ClassVar[str] = "time_gaps"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "fraction", "of the samples that are missing"),
        Parameter("length", "count", "of a gap, samples", optional=True),
    )

    def keep(self, n: int, rng: np.random.Generator) -> Array:
        """Which samples are in the record: bool, shape (n,)."""
        self._require()
        length = max(self.length or 1, 1)
        starts = rng.random(n) < self.fraction / length
        gone = np.zeros(n, dtype=bool)
        for begin in np.flatnonzero(starts):
            gone[begin : begin + length] = True
        gone[:1] = gone[-1:] = False
        return ~gone


@dataclass(frozen=True)
class Jitter(Process):
    """The time stamps are off by normal errors of standard deviation `sd`; the samples are not.

    Parameters
    ----------
    sd : float, s
    """

    sd: float = FREE
    name: ClassVar[str] = "jitter"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("sd", "amplitude", "of the time stamps, s"),
    )

    def stamps(self, time: Array, rng: np.random.Generator) -> Array:
        """The stamps of the record, shape (n,), from the true times; kept in order."""
        self._require()
        return np.sort(time + self.sd * rng.standard_normal(len(time)))


def clock(
    processes: Iterable[Process], n: int, fs: float, rng: np.random.Generator
) -> tuple[Array | None, Array | None]:
    """Stamps, s, of `n` samples and which of them are kept, each None where no process of the
    record's has a say: jitter first, then gaps, one within what another left.
    """
    time = keep = None
    (own,) = rng.spawn(1)
    for process in processes:
        if isinstance(process, Jitter):
            time = process.stamps(np.arange(n) / fs if time is None else time, own)
            time = time - time[0]
    for process in processes:
        if isinstance(process, TimeGaps):
            present = process.keep(n if keep is None else int(keep.sum()), own)
            if keep is None:
                keep = present
            else:
                keep[np.flatnonzero(keep)[~present]] = False
    return time, keep
