"""A record made ready, and what its channels have in common, found before any of them is looked
at.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from imu_lib.ensembles import ensemble
from imu_lib.gap import absent, fault_masking, record_level, record_vibrations
from imu_lib.gap.absent import Absent
from imu_lib.gap.clock_rate import Pace, paced
from imu_lib.gap.coherence import Cross, cross_spectra
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.model_rate import at_rate
from imu_lib.gap.shared_noise import shared_noise
from imu_lib.gap.steps import Step
from imu_lib.model import Model
from imu_lib.processes import CommonMode, Process, Sum, Vibration
from imu_lib.record import Record


@dataclass(frozen=True, eq=False)
class Prepared:
    """What the channels are looked at with.

    Attributes
    ----------
    ready : fault_masking.Ready; None in what a process is sent
        The record without its faults, and the steps that name these.
    model : Model or None
        What was given, less what the record does not have.
    raw : dict
        Channel -> samples on an even grid at `fs` Hz, NaN where one is missing.
    temperature : ndarray or None
        On the same grid.
    shaking : list
        Findings of what shakes the record, those of the given model too.
    known : dict
        Channel -> what that puts into it, shape (n,).
    nameless : dict
        Channel -> sentence about what of that is no vibration and has no name.
    shared : processes.CommonMode or None
        Noise in common that the model does not have.
    note : dict
        How that was found.
    left : str or None
        A coherence that is left.
    noise : dict
        Channel -> density N of all noise in common.
    bands : frozenset
        Channels that a vibration shakes over a band.
    pace : Pace
        Whether the clock is right.
    whole : Model or None
        What was given.
    gone : tuple
        What of that the record does not have.
    unseen : tuple
        Vibrations of the given model that are too weak to be told.
    said : tuple
        Sentences on what of the given model has no place in the record.
    """

    ready: Any
    model: Model | None
    raw: dict[str, np.ndarray]
    fs: float
    temperature: np.ndarray | None
    pace: Pace
    shaking: list[Finding] = field(default_factory=list)
    known: dict[str, np.ndarray] = field(default_factory=dict)
    nameless: dict[str, Any] = field(default_factory=dict)
    shared: CommonMode | None = None
    note: dict[str, Any] = field(default_factory=dict)
    left: str | None = None
    noise: dict[str, float] = field(default_factory=dict)
    bands: frozenset[str] = frozenset()
    whole: Model | None = None
    gone: tuple[Absent, ...] = ()
    unseen: tuple[Vibration, ...] = ()
    said: tuple[str, ...] = ()

    @property
    def given(self) -> tuple[Process, ...]:
        """What the given model has on the record, and the record may have."""
        return () if self.model is None else tuple(self.model.record)

    @property
    def as_given(self) -> tuple[Process, ...]:
        """What the given model has on the record."""
        return () if self.whole is None else tuple(self.whole.record)

    @property
    def held(self) -> tuple[CommonMode, ...]:
        """Noise in common of the given model."""
        return tuple(p for p in self.given if isinstance(p, CommonMode))

    @property
    def filtered(self) -> bool:
        """Whether noise in common enters before the channels' filters."""
        return any(p.filtered for p in _all(self.held, self.shared))

    def base(self, name: str) -> Sum | None:
        """The given model of a channel, or None."""
        return self.model[name] if self.model is not None and name in self.model else None

    def held_noise(self, name: str) -> float:
        """Density of the noise in common that the given model has on a channel."""
        held = [p for p in self.as_given if isinstance(p, CommonMode)]
        return float(np.sqrt(sum(p.N**2 for p in held if name in p.channels)))

    def held_shaking(self, name: str) -> tuple[Vibration, ...]:
        """Vibrations of the given model on a channel."""
        return _of([p for p in self.as_given if isinstance(p, Vibration)], name)

    def shaking_of(self, name: str) -> tuple[Vibration, ...]:
        """All vibrations that a channel feels."""
        return _of([*(f.process for f in self.shaking), *self.unseen], name)

    def lacking(self, name: str) -> Sum | None:
        """The given model of a channel, where that has not all of its terms; or None."""
        if self.whole is None or not any(a.term and name in a.channels for a in self.gone):
            return None
        return self.whole[name]

    def alone(self, name: str) -> Prepared:
        """The same with one channel's samples only, without what was found on the way."""
        return replace(
            self,
            raw={name: self.raw[name]},
            known={name: self.known[name]} if name in self.known else {},
            shaking=[],
            ready=None,
        )

    @property
    def new(self) -> list[Finding]:
        """What shakes the record and is not in the given model."""
        return [f for f in self.shaking if not f.held]

    @property
    def steps(self) -> list[Step]:
        """What was found on the record."""
        clock = [] if self.pace.step is None else [self.pace.step]
        out = [*clock, *self.ready.steps, *map(record_vibrations.vibration_step, self.new)]
        if self.shared is not None:
            out.append(record_level.common_step(self.shared, self.note))
        return out

    @property
    def processes(self) -> tuple[Any, ...]:
        """The same for a model's `record`."""
        return _all([*self.ready.processes, *(f.process for f in self.new)], self.shared)


def _all(some: Iterable[Any], one: Any) -> tuple[Any, ...]:
    return (*some, *(() if one is None else (one,)))


def _of(vibrations: Iterable[Vibration], name: str) -> tuple[Vibration, ...]:
    """The vibrations on one channel alone, those that it feels."""
    return tuple(v for v in (p.of(name) for p in vibrations) if v is not None)


def prepared(record: Record, model: Model | None, channels: Sequence[str] | None) -> Prepared:
    """The record without its faults, on an even grid, with what its channels have in common.

    Raises
    ------
    ValueError, InputError
        As `gap.loop.close`.
    """
    names = _asked(record, channels)
    pace = paced(record, model)
    record, model = pace.record, at_rate(model, pace.record.rate)
    said: str | None = None
    if model is not None:
        model, said = absent.elsewhere(model, names)
    ready = fault_masking.ready(
        replace(record, channels={c: record.channels[c] for c in names}), model
    )
    even = ready.record.uniform()
    raw = record_vibrations.on_levels(
        {c: np.asarray(even.channels[c]) for c in ready.record.channel_names}
    )
    temperature = None if even.temperature is None else np.array(even.temperature)
    if temperature is not None and np.isnan(temperature).any():
        temperature = ensemble.filled(temperature)
    about = Prepared(ready, model, raw, even.rate, temperature, pace, whole=model)
    return _in_common(replace(about, said=(said,) if said else ()))


def _in_common(about: Prepared) -> Prepared:
    """With what shakes the record, then with noise that channels share."""
    found, known = record_vibrations.vibrations(
        about.ready.record, about.raw, about.fs, about.temperature, about.model
    )
    shaking, nameless = record_vibrations.parted(found)
    calm = {name: x - known.get(name, 0.0) for name, x in about.raw.items()}
    cross = cross_spectra(calm, about.fs)
    about = _without_absent(about, found, cross)
    bases = None if about.model is None else about.model.channels
    shared, note, left = shared_noise(cross, about.fs, about.held, bases)
    noise = {
        name: float(np.sqrt(sum(p.N**2 for p in _all(about.held, shared) if name in p.channels)))
        for name in about.raw
    }
    return replace(
        about,
        shaking=shaking,
        known=known,
        nameless=nameless,
        shared=shared,
        note=note,
        left=left,
        noise=noise,
        bands=frozenset(c for f in shaking if f.process.band for c in f.process.channels),
    )


def _without_absent(about: Prepared, found: list[Finding], cross: Cross) -> Prepared:
    """With the given model less what the record does not have."""
    model, raw, fs = about.model, about.raw, about.fs
    if model is None:
        return about
    gone = [
        *absent.of_faults(model, about.ready.findings, about.ready.record),
        *absent.of_vibrations(model, found, raw, fs),
        *absent.of_lines(model, raw, fs),
        *absent.of_spikes(model, raw, fs),
        *absent.of_common(model, cross, fs),
    ]
    left = absent.without(model, gone, found)
    seen = [f.process for f in found]
    unseen = [p for p in left.record if isinstance(p, Vibration)]
    unseen = [p for p in unseen if not any(p is s for s in seen)]
    return replace(about, model=left, gone=tuple(gone), unseen=tuple(unseen))


def _asked(record: Record, channels: Sequence[str] | None) -> list[str]:
    """Names of the channels to look at."""
    names = list(record.channel_names if channels is None else channels)
    for name in names:
        if name not in record:
            raise ValueError(f"`channels` has {name!r}, which the record lacks")
        if channels is not None and not np.nanstd(record.channels[name]) > 0:
            raise ValueError(
                f"`record` does not move in {name}; leave the channel out with `channels`"
            )
    return names
