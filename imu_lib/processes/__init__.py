"""The noise processes and what each knows of itself: spectrum, Allan variance, autocovariance, a
realisation, a state space. `a + b` is a `Sum`; `from_json` opens an entry of an error-model file.
"""

from __future__ import annotations

import dataclasses
from importlib import import_module
from typing import Any

from imu_lib.errors import InputError

from .autoregressive import Autoregressive
from .base import FREE, NAMED, POSITIVE_KINDS, Parameter, Process, StateSpace
from .deterministic import Constant, Deterministic, Ramp, Sinusoid, Step, WarmUp
from .faults import Disturbance, Dropout, Tilt
from .flicker import FLAT, Flicker
from .gauss_markov import GaussMarkov, GaussMarkov2
from .heavy_tails import HeavyTails
from .low_pass import LowPass
from .on_record import CommonMode, Jitter, TimeGaps
from .rate_error import RateError
from .stage import Stage
from .stages import NoiseLevelChange, Resolution, Saturation, Spikes, Stuck
from .sum import Sum
from .telegraph import Telegraph
from .temperature import Temperature
from .vibration import Vibration
from .walk import RandomWalk
from .wandering_level import WanderingLevel
from .white import Quantization, ReadOutNoise, WhiteNoise

#: Processes of a channel, by the name in the error-model file.
OF_CHANNEL: dict[str, type[Process]] = {
    cls.name: cls
    for cls in (
        Constant,
        WhiteNoise,
        ReadOutNoise,
        Quantization,
        Flicker,
        RandomWalk,
        Ramp,
        GaussMarkov,
        GaussMarkov2,
        Autoregressive,
        Sinusoid,
        WarmUp,
        Temperature,
        Step,
        Telegraph,
        LowPass,
        HeavyTails,
        NoiseLevelChange,
        WanderingLevel,
        Spikes,
        Saturation,
        Resolution,
        Stuck,
    )
}
#: Processes of the whole record, by the name in the error-model file.
OF_RECORD: dict[str, type[Process]] = {
    cls.name: cls
    for cls in (
        CommonMode,
        Vibration,
        TimeGaps,
        Jitter,
        RateError,
        Dropout,
        Disturbance,
        Tilt,
    )
}


def from_json(entry: dict[str, Any], *, on_record: bool = False) -> Process:
    """One entry of an error-model file as a process.

    Raises
    ------
    InputError
        If the name is unknown, a parameter is missing, unknown or out of range.
    """
    known = OF_RECORD if on_record else OF_CHANNEL
    if not isinstance(entry, dict) or "process" not in entry:
        raise InputError(
            "an entry of an error model must be an object with the key 'process', not "
            f"{entry!r:.80}"
        )
    name = entry["process"]
    cls = (known.get(name) or _of_an_effect(name)) if isinstance(name, str) else None
    if cls is None:
        raise InputError(f"unknown process {name!r}; known are {', '.join(known)}")
    values = {cls.keys.get(key, key): v for key, v in entry.items() if key != "process"}
    fields = {field.name for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    extra = sorted(set(values) - fields)
    if extra:
        raise InputError(
            f"process {name}: unknown parameter {extra[0]!r}; it takes {', '.join(sorted(fields))}"
        )
    try:
        process = cls(**values)
    except TypeError as error:
        raise InputError(f"process {name}: {error}") from None
    if not process.complete:
        missing = [
            p.name for p in cls.parameters if getattr(process, p.name) is None and not p.optional
        ]
        raise InputError(
            f"process {name}: parameter {' or '.join(missing) or 'taps, order or smoothing'} is "
            "missing"
        )
    return process


def _of_an_effect(name: str) -> type[Process] | None:
    """A process that an effect of the gap workflow brings with it: looked up when it is asked for,
    by its name, since effects are made of processes.
    """
    if name not in {**OF_CHANNEL, **OF_RECORD}:
        import_module("imu_lib.gap.effects")
        return NAMED.get(name)
    return None


__all__ = [
    "Autoregressive",
    "CommonMode",
    "Constant",
    "Deterministic",
    "Disturbance",
    "Dropout",
    "FLAT",
    "FREE",
    "Flicker",
    "GaussMarkov",
    "GaussMarkov2",
    "HeavyTails",
    "Jitter",
    "LowPass",
    "NoiseLevelChange",
    "OF_CHANNEL",
    "OF_RECORD",
    "POSITIVE_KINDS",
    "Parameter",
    "Process",
    "Quantization",
    "Ramp",
    "RandomWalk",
    "RateError",
    "ReadOutNoise",
    "Resolution",
    "Saturation",
    "Sinusoid",
    "Spikes",
    "Stage",
    "StateSpace",
    "Step",
    "Stuck",
    "Sum",
    "Telegraph",
    "Temperature",
    "Tilt",
    "TimeGaps",
    "Vibration",
    "WanderingLevel",
    "WarmUp",
    "WhiteNoise",
    "from_json",
]
