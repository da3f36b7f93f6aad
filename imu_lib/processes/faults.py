"""What happens to a record and to its sensor: rows that are lost, knocks, tilts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.ndimage import uniform_filter1d

from imu_lib.arrays import Array
from imu_lib.errors import InputError

from .base import FREE, Parameter, Process


def _names(process: Process, channels: Any) -> tuple[str, ...]:
    if isinstance(channels, str) or not all(isinstance(c, str) for c in channels):
        raise InputError(f"process {process.name}: `channels` must be a list of channel names")
    return tuple(channels)


def _numbers(process: Process, name: str, values: Any, count: int | None) -> tuple[float, ...]:
    try:
        out = tuple(float(v) for v in np.atleast_1d(np.asarray(values, dtype=object)).tolist())
    except (TypeError, ValueError):
        raise InputError(f"process {process.name}: `{name}` must hold numbers") from None
    if not np.isfinite(out).all() or count is not None and len(out) != count:
        raise InputError(
            f"process {process.name}: `{name}` must hold "
            f"{'finite numbers' if count is None else f'{count} finite numbers'}, not {values!r}"
        )
    return out


@dataclass(frozen=True)
class Dropout(Process):
    """Rows that are no measurement: a constant, or a copy of the row before, or nothing.

    Parameters
    ----------
    fraction : float, 0 to 1, of the samples
    value : float or sequence of float, one a channel, optional, unit of the channel
        What stands in their place; NaN where neither it nor `held` is given.
    held : bool, optional
        The row before stands there.
    period : int, samples, optional
        They come as evenly as that, some left out; at random where not given.
    start, stop : float, s from the first sample, optional; `from` and `to` in a file
        The output stands still, or is lost, from the one to the other and nowhere else.
    channels : sequence of str
    """

    fraction: float = FREE
    value: Any = None
    held: bool | None = None
    period: int | None = None
    channels: tuple[str, ...] = ()
    start: float | None = None
    stop: float | None = None
    name: ClassVar[str] = "dropout"
    keys: ClassVar[dict[str, str]] = {"from": "start", "to": "stop"}
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "fraction", "of the samples"),
        Parameter("period", "count", "from one to the next, samples", optional=True),
        Parameter("start", "other", "from, s", optional=True),
        Parameter("stop", "other", "to, s", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "channels", _names(self, self.channels))
        if self.fraction is not None and not 0 <= self.fraction < 1:
            raise InputError("process dropout: `fraction` must lie between 0 and 1")
        if self.period is not None and self.period < 1:
            raise InputError("process dropout: `period` counts samples, 1 or more")
        if self.value is not None:
            values = _numbers(self, "value", self.value, None)
            if len(values) not in (1, len(self.channels)):
                raise InputError("process dropout: `value` is one number, or one a channel")
            object.__setattr__(self, "value", values[0] if len(set(values)) == 1 else values)

    @property
    def complete(self) -> bool:
        return self.fraction is not None and bool(self.channels)

    def to_json(self) -> dict[str, Any]:
        entry = super().to_json()
        if self.value is not None:
            entry["value"] = list(self.value) if isinstance(self.value, tuple) else self.value
        if self.held:
            entry["held"] = True
        for key, field in self.keys.items():
            if field in entry:
                entry[key] = entry.pop(field)
        return {**entry, "channels": list(self.channels)}

    @property
    def at_once(self) -> bool:
        """Whether it is one stretch of the record, not rows all over it."""
        return self.start is not None or self.stop is not None

    def stretch(self, n: int, fs: float) -> tuple[int, int]:
        """First row and the one behind the last of that stretch, among `n` at `fs` Hz."""
        first = 0 if self.start is None else int(np.ceil(self.start * fs - 1e-6))
        last = n if self.stop is None else int(np.ceil(self.stop * fs - 1e-6))
        return min(max(first, 0), n), min(max(last, 0), n)

    def rows(self, n: int, fs: float, rng: np.random.Generator) -> Array:
        """One draw of the rows that are lost: bool, shape (n,)."""
        self._require()
        if self.at_once:
            out = np.zeros(n, dtype=bool)
            out[slice(*self.stretch(n, fs))] = True
            return out
        if self.period is None:
            return rng.random(n) < self.fraction
        at = np.arange(int(rng.integers(self.period)), n, self.period)
        out = np.zeros(n, dtype=bool)
        out[at[rng.random(len(at)) < self.fraction * self.period]] = True
        return out

    def act(
        self, signals: dict[str, Array], fs: float, rng: np.random.Generator
    ) -> dict[str, Array]:
        """The signals (name -> ndarray, shape (n,)) at `fs` Hz with one draw of the rows lost."""
        n = len(next(iter(signals.values())))
        lost = self.rows(n, fs, rng)
        if self.held:
            lost[0] = False
        last = np.maximum.accumulate(np.where(lost, 0, np.arange(n)))
        out = dict(signals)
        for i, channel in enumerate(self.channels):
            if channel not in signals:
                continue
            if self.held:
                out[channel] = signals[channel][last]
            else:
                value = self.value[i] if isinstance(self.value, tuple) else self.value
                out[channel] = np.where(lost, np.nan if value is None else value, signals[channel])
        return out


@dataclass(frozen=True)
class Disturbance(Process):
    """A knock or handling: it was touched, from `start` on for `duration`.

    Parameters
    ----------
    start : float, s from the first sample
    duration : float, s
    peak : sequence of float, one a channel, unit of the channel
        Largest deviation, with its sign.
    channels : sequence of str
    """

    start: float = FREE
    duration: float = FREE
    peak: Any = ()
    channels: tuple[str, ...] = ()
    name: ClassVar[str] = "disturbance"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("start", "other", "s from the first sample"),
        Parameter("duration", "time", "s"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "channels", _names(self, self.channels))
        peak = _numbers(self, "peak", self.peak, None)
        if len(peak) == 1:
            peak = peak * len(self.channels)
        object.__setattr__(self, "peak", _numbers(self, "peak", peak, len(self.channels)))

    @property
    def complete(self) -> bool:
        return self.start is not None and self.duration is not None and bool(self.channels)

    def to_json(self) -> dict[str, Any]:
        return {**super().to_json(), "peak": list(self.peak), "channels": list(self.channels)}

    def on(self, n: int, fs: float, rng: np.random.Generator) -> dict[str, Array]:
        """What each of its channels gets of one draw: noise that dies away, name -> (n,)."""
        self._require()
        first = int(round(self.start * fs))
        size = max(1, int(round(self.duration * fs)))
        envelope = np.exp(-4.0 * np.arange(size) / size)
        low, high = max(first, 0), min(first + size, n)
        out = {}
        for channel, peak in zip(self.channels, self.peak):
            shake = uniform_filter1d(rng.standard_normal(size), max(1, size // 12)) * envelope
            at = int(np.argmax(np.abs(shake)))
            shake = shake * (peak / shake[at])
            x = np.zeros(n)
            if high > low:
                x[low:high] = shake[low - first : high - first]
            out[channel] = x
        return out


@dataclass(frozen=True)
class Tilt(Process):
    """The sensor was turned by a small angle and stays so: the gyros see the turn, the
    accelerometers another part of gravity.

    Parameters
    ----------
    time : float, s from the first sample
        When the turn begins.
    angles : sequence of 3 floats, rad
        Rotation vector in the body's axes.
    duration : float, s, optional
        Of the turn; 1 where not given.
    force : sequence of 3 floats, m/s^2, optional
        The specific force before; level, (0, 0, -g), where not given.
    """

    time: float = FREE
    angles: Any = ()
    duration: float | None = None
    force: Any = None
    name: ClassVar[str] = "tilt"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("time", "other", "when it begins, s"),
        Parameter("duration", "time", "of the turn, s", optional=True),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.angles):
            object.__setattr__(self, "angles", _numbers(self, "angles", self.angles, 3))
        if self.force is not None:
            object.__setattr__(self, "force", _numbers(self, "force", self.force, 3))

    @property
    def complete(self) -> bool:
        return self.time is not None and len(self.angles) == 3

    def to_json(self) -> dict[str, Any]:
        entry = {**super().to_json(), "angles": list(self.angles)}
        if self.force is not None:
            entry["force"] = list(self.force)
        return entry

    def on(self, n: int, fs: float, *, first: int = 0) -> dict[str, Array]:
        """What the six channels get from sample `first` on, name -> ndarray, shape (n,)."""
        from scipy.spatial.transform import Rotation

        self._require()
        angles = np.array(self.angles)
        force = np.array((0.0, 0.0, -9.80665) if self.force is None else self.force)
        t = np.arange(first, first + n) / fs
        length = max(1.0 if self.duration is None else self.duration, 1.0 / fs)
        part = np.clip((t - self.time) / length, 0.0, 1.0)
        done = 0.5 - 0.5 * np.cos(np.pi * part)
        inside = (part > 0) & (part < 1)
        rate = np.where(inside, 0.5 * np.pi / length * np.sin(np.pi * part), 0.0)
        out = {f"gyro_{a}": angles[i] * rate for i, a in enumerate("xyz")}
        # a body that turns by the rotation vector sees the force turned back
        change = np.zeros((n, 3))
        moved = done > 0
        # only the turn itself needs the exact rotation sample by sample
        some = np.flatnonzero(inside)
        if len(some):
            turned = Rotation.from_rotvec(-done[some, None] * angles).apply(force)
            change[some] = turned - force
        change[moved & ~inside] = Rotation.from_rotvec(-angles).apply(force) - force
        return out | {f"accel_{a}": change[:, i] for i, a in enumerate("xyz")}
