"""The static record: what an IMU at rest put out, with its rate, its time stamps and where it came
from.

Units are SI: rad/s, m/s^2, s, degC. A missing sample is NaN. A record never changes; every method
that alters one returns a new record whose `notes` say what was done.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from imu_lib import timing, units
from imu_lib.arrays import Array, frozen
from imu_lib.errors import InputError

CHANNELS = ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")


@dataclass(frozen=True, eq=False)
class Record:
    """A static record.

    channels: name -> ndarray (n,), names out of CHANNELS, rad/s and m/s^2, NaN where a sample is
    missing.
    rate: samples per second, Hz. time: ndarray (n,), s from the first sample, rising; None means
    evenly sampled at `rate`.
    temperature: ndarray (n,), degC, or None. notes: sentences on what reading or cutting did.
    seams: samples before which the logger began anew, after a pause of unknown length that the
    stamps bridge: no gaps, but nothing goes on across them.
    Raises ValueError naming the argument.
    """

    channels: Mapping[str, np.ndarray]
    rate: float
    time: np.ndarray | None = None
    temperature: np.ndarray | None = None
    name: str = ""
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    seams: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        unknown = [c for c in self.channels if c not in CHANNELS]
        if unknown:
            raise ValueError(f"`channels` has {unknown[0]!r}; the names are {', '.join(CHANNELS)}")
        if not self.channels:
            raise ValueError("`channels` is empty; at least one signal is needed")
        first = next(iter(self.channels))
        n = np.size(self.channels[first])
        if n < 2:
            raise ValueError(f"`{first}` has {n} sample(s); at least two are needed")
        channels = {c: frozen(self.channels[c], c, (n,)) for c in CHANNELS if c in self.channels}
        for name, x in channels.items():
            if np.isinf(x).any():
                raise ValueError(
                    f"`{name}` holds an infinite value at sample "
                    f"{int(np.flatnonzero(np.isinf(x))[0])}; NaN marks a missing sample"
                )
            if np.isnan(x).all():
                raise ValueError(f"`{name}` holds no number, only NaN")
        rate = float(self.rate)
        if not (np.isfinite(rate) and rate > 0):
            raise ValueError(f"`rate` must be a positive number of Hz, not {self.rate!r}")
        put = object.__setattr__
        put(self, "channels", MappingProxyType(channels))
        put(self, "rate", rate)
        put(self, "notes", tuple(self.notes))
        if self.time is not None:
            time = frozen(self.time, "time", (n,))
            wrong = np.flatnonzero(~(np.diff(time) > 0))
            if not np.isfinite(time[0]) or wrong.size:
                raise ValueError(
                    "`time` must rise from sample to sample; it does not at sample "
                    f"{int(wrong[0]) + 1 if wrong.size else 0}"
                )
            put(self, "time", time)
        if self.temperature is not None:
            put(self, "temperature", frozen(self.temperature, "temperature", (n,)))

    def __reduce__(self) -> tuple[Any, ...]:
        # a mapping proxy cannot be pickled, and records travel to worker processes
        return Record, (
            dict(self.channels),
            self.rate,
            self.time,
            self.temperature,
            self.name,
            self.source,
            self.notes,
            self.seams,
        )

    def __repr__(self) -> str:
        return (
            f"Record({self.name or 'unnamed'}: {', '.join(self.channels)}; {self.n} samples at "
            f"{self.rate:.6g} Hz, {self.duration:.6g} s)"
        )

    def __contains__(self, key: object) -> bool:
        return key in self.channels

    def __getitem__(self, key: str) -> np.ndarray:
        """One channel (n,), or `gyro` / `accel` as (n, 3) where all three axes are there. KeyError
        otherwise.
        """
        if key in ("gyro", "accel"):
            names = [f"{key}_{axis}" for axis in "xyz"]
            axes = [self.channels[name] for name in names if name in self.channels]
            if len(axes) < 3:
                raise KeyError(
                    f"the record has not all three axes of `{key}`, only {', '.join(self.channels)}"
                )
            return np.column_stack(axes)
        if key not in self.channels:
            raise KeyError(f"the record has no channel `{key}`, only {', '.join(self.channels)}")
        return self.channels[key]

    @property
    def channel_names(self) -> tuple[str, ...]:
        return tuple(self.channels)

    @property
    def n(self) -> int:
        """Number of samples."""
        return len(next(iter(self.channels.values())))

    @property
    def duration(self) -> float:
        """Seconds covered, the last sample's own interval included."""
        return (
            self.n / self.rate
            if self.time is None
            else float(self.time[-1] - self.time[0]) + 1.0 / self.rate
        )

    def times(self) -> np.ndarray:
        """Time of each sample from the first one, s, shape (n,)."""
        return np.arange(self.n) / self.rate if self.time is None else self.time - self.time[0]

    def with_note(self, *notes: str) -> Record:
        return replace(self, notes=self.notes + notes)

    def take(self, index: slice | Array, *notes: str) -> Record:
        """The samples of a slice or an index array; the time starts anew at 0."""
        time = None if self.time is None else self.time[index]
        return replace(
            self,
            channels={c: x[index] for c, x in self.channels.items()},
            time=None if time is None else time - time[:1],
            temperature=None if self.temperature is None else self.temperature[index],
            notes=self.notes + notes,
            seams=self._seams_of(np.arange(self.n)[index]) if self.seams else (),
        )

    def _seams_of(self, kept: Array) -> tuple[int, ...]:
        """The seams by the numbers that samples have among those `kept`."""
        at = np.searchsorted(kept, self.seams)
        return tuple(sorted({int(k) for k in at if 0 < k < len(kept)}))

    def slice(self, start: float | None = None, stop: float | None = None) -> Record:
        """The part from `start` to before `stop`, seconds from the first sample. ValueError where
        fewer than two samples are left.
        """
        t = self.times()
        low = 0 if start is None else int(np.searchsorted(t, start - 0.5e-6 / self.rate))
        high = self.n if stop is None else int(np.searchsorted(t, stop - 0.5e-6 / self.rate))
        if high - low < 2:
            raise ValueError(
                f"`start` {start} and `stop` {stop} leave fewer than two samples of a record of "
                f"{self.duration:.6g} s"
            )
        return self if (low, high) == (0, self.n) else self.take(slice(low, high))

    # -- gaps

    def slots(self) -> np.ndarray:
        """Number of each sample on the even grid at `rate`, shape (n,), int: a number left out is
        a missing sample.
        """
        return np.arange(self.n) if self.time is None else timing.slots(self.time, self.rate)

    def gaps(self) -> tuple[timing.Gap, ...]:
        """Every gap in the time stamps: where it begins (s), how long it is (s), how many samples
        are missing. A pause of unknown length (`seams`) is none.
        """
        time = self.times()
        found = timing.gaps(time, self.slots(), self.rate)
        anew = {float(time[k - 1]) for k in self.seams}
        return tuple(g for g in found if g.start not in anew)

    def missing(self) -> np.ndarray:
        """Samples in which at least one channel is NaN, shape (n,), bool."""
        bad = np.zeros(self.n, dtype=bool)
        for x in self.channels.values():
            bad |= np.isnan(x)
        return bad

    def enough(self, least: int = 100) -> Record:
        """The record itself; InputError where it has fewer samples than `least`: below, not even
        the white noise has an interval worth printing."""
        if self.n < least:
            raise InputError(
                f"{self.source or self.name or 'The record'} has {self.n} samples "
                f"({units.duration(self.duration)}) without a gap and at "
                f"least {least} are needed; record the sensor at rest for longer: minutes for "
                "white noise, hours for bias instability."
            )
        return self

    def uniform(self) -> Record:
        """The record on an even grid at `rate`: jitter of the stamps dropped, NaN where a sample
        is missing. ValueError where the gaps are so long that the grid would be over ten times the
        record."""
        if self.time is None:
            return self
        slots = self.slots()
        n = int(slots[-1]) + 1
        if n == self.n:
            return replace(self, time=None)
        if n > 10 * self.n + 1_000_000:
            raise ValueError(
                f"`time` leaves {n - self.n:,} of {n:,} samples missing; cut the record at its "
                "gaps first (start, stop)"
            )

        def spread(x: Array) -> Array:
            out = np.full(n, np.nan)
            out[slots] = x
            return out

        return replace(
            self,
            channels={c: spread(x) for c, x in self.channels.items()},
            time=None,
            temperature=None
            if self.temperature is None
            else timing.fill(spread(self.temperature), n)[0],
            seams=tuple(int(slots[k]) for k in self.seams),
            notes=self.notes + (f"{n - self.n:,} missing samples put in as NaN on an even grid.",),
        )

    def longest_stretch(self) -> Record:
        """The longest part without a gap in time and without NaN, on an even grid (`time` None)."""
        broken = np.flatnonzero(np.diff(self.slots()) != 1) + 1
        low, high = timing.longest_run(~self.missing(), broken)
        if high - low < 2:
            raise ValueError(
                "`channels` have no two neighbouring samples in which every channel is a number"
            )
        if (low, high) == (0, self.n):
            return replace(self, time=None)
        part = self.take(
            slice(low, high),
            f"Longest stretch without a gap: {(high - low) / self.rate:.6g} s from "
            f"{self.times()[low]:.6g} s on, of {self.duration:.6g} s.",
        )
        return replace(part, time=None)

    def continuous(self, *, fill: int = 10) -> Record:
        """What an estimator on `(x, fs)` may be given: evenly sampled, no NaN, nothing silent.

        Gaps of up to `fill` samples are bridged by straight lines, then the longest stretch is
        taken; `notes` say both.
        """
        if self.time is None and not self.missing().any():
            return self
        even, count = (
            self.longest_stretch()
            if len(self.slots()) and self.slots()[-1] > 10 * self.n
            else self.uniform(),
            0,
        )
        channels = {}
        for c, x in even.channels.items():
            channels[c], filled = timing.fill(x, fill)
            count = max(count, filled)
        if count:
            even = replace(
                even,
                channels=channels,
                notes=even.notes
                + (
                    f"{count:,} missing samples in short gaps (up to {fill}) bridged by straight "
                    "lines.",
                ),
            )
        return even.longest_stretch()
