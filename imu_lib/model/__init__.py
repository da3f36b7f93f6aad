"""The error model of an IMU: a sum of processes for each channel, and what acts on several of
them.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from imu_lib import beside
from imu_lib.arrays import Array
from imu_lib.drive_effects import DriveEffect, from_entries
from imu_lib.errors import InputError, once
from imu_lib.processes import (
    CommonMode,
    Disturbance,
    Dropout,
    Process,
    RateError,
    Sum,
    Tilt,
    Vibration,
)
from imu_lib.processes.on_record import clock
from imu_lib.record import CHANNELS, Record

from .entries import TURN_ON, entries, turn_on

_RESERVED = ("rate", "record", "name", "source", "drive", "turn_on")


@dataclass(frozen=True)
class Model:
    """The error model of a record.

    Parameters
    ----------
    channels : mapping of channel name to Sum
    record : tuple of Process
        What acts on several channels or on the clock (`CommonMode`, `Vibration`, `TimeGaps`, ...).
    rate : float or None, Hz
        Sampling rate the model was made for.
    name, source : str
    extra : mapping
        Unknown reserved keys of a file, kept.
    drive : tuple of DriveEffect
        What is wrong with a drive beyond the noise of its sensors; the navigation filter holds it.
    turn_on : (gyro rad/s, accelerometer m/s^2) or None
        Standard deviation of the bias left at switch-on.
    """

    channels: Mapping[str, Sum]
    record: tuple[Process, ...] = ()
    rate: float | None = None
    name: str = ""
    source: str = ""
    extra: Mapping[str, object] = field(default_factory=dict)
    drive: tuple[DriveEffect, ...] = ()
    turn_on: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        ordered = {}
        for channel in CHANNELS:
            if channel in self.channels:
                entry = self.channels[channel]
                ordered[channel] = (
                    entry
                    if isinstance(entry, Sum)
                    else Sum.of(entry if isinstance(entry, Iterable) else [entry])
                )
        of_record = {c for process in self.record for c in getattr(process, "channels", ())}
        unknown = sorted({*self.channels, *of_record} - set(CHANNELS))
        if unknown:
            raise InputError(
                f"unknown channel {unknown[0]!r} in the error model; channels are "
                f"{', '.join(CHANNELS)}"
            )
        if not ordered:
            raise InputError("the error model has no channel; channels are " + ", ".join(CHANNELS))
        object.__setattr__(self, "channels", ordered)
        object.__setattr__(self, "record", tuple(self.record))
        object.__setattr__(self, "drive", tuple(self.drive))

    def __getitem__(self, channel: str) -> Sum:
        if channel not in self.channels:
            raise KeyError(
                f"the error model has no channel {channel!r}; it has {', '.join(self.channels)}"
            )
        return self.channels[channel]

    def __contains__(self, channel: object) -> bool:
        return channel in self.channels

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Names of the channels, in the order of the file format."""
        return tuple(self.channels)

    def with_channels(
        self, channels: Mapping[str, Sum], *, record: tuple[Process, ...] | None = None
    ) -> Model:
        """The same model with some channels (and the record's own processes) replaced."""
        return replace(
            self,
            channels={**self.channels, **channels},
            record=self.record if record is None else record,
        )

    def with_drive(self, effects: Iterable[DriveEffect]) -> Model:
        """The same model with other effects on the drive."""
        return replace(self, drive=tuple(effects))

    # -- files -----------------------------------------------------------------------------------
    @classmethod
    def from_json(cls, content: Mapping[str, Any], *, where: str = "the error model") -> Model:
        """From the decoded content of an error-model file.

        Raises
        ------
        InputError
            Naming `where`, the channel, the entry and what is wrong with it.
        """
        if not isinstance(content, Mapping):
            raise InputError(
                f"{where}: an error model is an object of channels, not {type(content).__name__}"
            )
        channels, extra = {}, {}
        for key, value in content.items():
            if key in _RESERVED:
                continue
            if key not in CHANNELS:
                if isinstance(value, list):
                    raise InputError(
                        f"{where}: unknown channel {key!r}; channels are {', '.join(CHANNELS)}"
                    )
                extra[key] = value
                continue
            channels[key] = Sum.of(entries(value, f"{where}, channel {key}", on_record=False))
        rate = content.get("rate")
        if rate is not None and (
            isinstance(rate, bool) or not isinstance(rate, (int, float)) or not 0 < rate < np.inf
        ):
            raise InputError(f"{where}: `rate` must be a positive number of Hz, not {rate!r}")
        try:
            return cls(
                channels,
                tuple(entries(content.get("record", []), f"{where}, record", on_record=True)),
                None if rate is None else float(rate),
                str(content.get("name", "")),
                str(content.get("source", "")),
                extra,
                from_entries(content.get("drive", []), "drive"),
                turn_on(content.get("turn_on"), where),
            )
        except InputError as error:
            raise InputError(f"{where}: {error}") from None

    def to_json(self) -> dict[str, Any]:
        """The content of the error-model file."""
        content: dict[str, Any] = {}
        for key in ("name", "source", "rate"):
            if getattr(self, key):
                content[key] = getattr(self, key)
        content.update(self.extra)
        content.update({channel: entry.to_json() for channel, entry in self.channels.items()})
        if self.record:
            content["record"] = [process.to_json() for process in self.record]
        if self.drive:
            content["drive"] = [effect.to_json() for effect in self.drive]
        if self.turn_on is not None:
            content["turn_on"] = dict(zip(("gyro", "accel"), self.turn_on))
        return content

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Model:
        """From a file, or a preset where `path` is `preset:NAME`.

        Raises
        ------
        InputError
            If it cannot be read as an error model.
        """
        text = str(path)
        if text.startswith("preset:"):
            from imu_lib.presets import preset

            return preset(text.removeprefix("preset:"))
        try:
            content = json.loads(
                Path(path).read_text(encoding="utf-8"),
                object_pairs_hook=lambda pairs: once(pairs, path),
            )
        except FileNotFoundError:
            raise InputError(
                f"{path}: no such file; give an error-model file (.json) or preset:NAME"
            ) from None
        except IsADirectoryError:
            raise InputError(
                f"{path} is a directory; give an error-model file (.json) or preset:NAME"
            ) from None
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise InputError(
                f"{path} is not text; give an error-model file (.json) or preset:NAME"
            ) from None
        except json.JSONDecodeError as error:
            raise InputError(
                f"{path}, line {error.lineno}, column {error.colno}: not valid JSON "
                f"({error.msg}); the file is damaged or cut off: "
                "write it anew, or give preset:NAME"
            ) from None
        return cls.from_json(content, where=str(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the error-model file; it appears whole or not at all. A symbolic link is followed,
        and a device or pipe is written through.
        """
        path = Path(path)
        if path.exists() and not (path.is_file() or path.is_dir()):
            path.write_text(json.dumps(self.to_json(), indent=2) + "\n", encoding="utf-8")
            return
        with beside.whole(path) as part:
            part.write_text(json.dumps(self.to_json(), indent=2) + "\n", encoding="utf-8")

    # -- realisations ----------------------------------------------------------------------------
    def simulate(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        channels: Iterable[str] | None = None,
    ) -> dict[str, np.ndarray]:
        """A realisation of the channels: dict of ndarray, shape (n,), at `fs` Hz.

        A channel's draw depends on the state of `rng` alone, not on which others are drawn.
        """
        generators = dict(zip((*CHANNELS, "record"), rng.spawn(len(CHANNELS) + 1)))
        wanted = self.channel_names if channels is None else tuple(channels)
        common: dict[str, Array | None] = {channel: None for channel in wanted}
        for process in self.record:
            if isinstance(process, (CommonMode, Vibration, Disturbance, Tilt)):
                if isinstance(process, (Vibration, Disturbance)):
                    parts = process.on(n, fs, generators["record"])
                elif isinstance(process, Tilt):
                    parts = process.on(n, fs)
                else:
                    filters = {c: self[c].low_pass for c in process.channels if c in self.channels}
                    parts = process.on(filters, n, fs, generators["record"])
                for channel, shared in parts.items():
                    if channel in common:
                        before = common[channel]
                        common[channel] = shared if before is None else before + shared
        out = {
            channel: self[channel].simulate(
                n, fs, generators[channel], temperature=temperature, common=common[channel]
            )
            for channel in wanted
        }
        for process in self.record:
            if isinstance(process, Dropout):
                out = process.act(out, fs, generators["record"])
        return out

    def simulate_record(
        self,
        n: int,
        fs: float,
        rng: np.random.Generator,
        *,
        temperature: Array | None = None,
        name: str = "",
        channels: Iterable[str] | None = None,
    ) -> Record:
        """A realisation as a `Record`, with the gaps and the jitter of the model's clock."""
        pace = next((p for p in self.record if isinstance(p, RateError)), RateError(1.0))
        true = self.with_channels({c: pace.paced(s) for c, s in self.channels.items()})
        signals = true.simulate(n, fs * pace.ratio, rng, temperature=temperature, channels=channels)
        time, keep = clock(self.record, n, fs, rng)
        if keep is not None:
            time = (np.arange(n) / fs if time is None else time)[keep]
            signals = {channel: x[keep] for channel, x in signals.items()}
            temperature = None if temperature is None else np.asarray(temperature)[keep]
        return Record(
            signals,
            fs,
            time=time,
            temperature=temperature,
            name=name or self.name,
            source=f"simulated from the error model {self.name or 'given'}",
        )


__all__ = ["TURN_ON", "Model"]
