"""A model at the rate of a record that another clock has sampled."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from imu_lib.model import Model
from imu_lib.processes import Autoregressive, LowPass, Sum

#: Share by which two clocks of one nominal rate may differ.
MOST = 0.05


def at_rate(model: Model | None, fs: float) -> Model | None:
    """The model with what steps at the rate of the samples (filters, autoregressive noises)
    stepping at `fs` Hz, where that is the same rate by another clock.

    The stamps of two logs of one sensor never tell quite the same rate: 99.97 Hz on one day, 100.02
    on another.
    """
    if model is None:
        return None
    channels = {}
    for name in model.channel_names:
        own = model[name]
        terms = tuple(_clocked(p, fs) for p in own.terms)
        channels[name] = Sum(terms, tuple(_clocked(p, fs) for p in own.stages))
    return replace(model, channels=channels)


def _clocked(process: Any, fs: float) -> Any:
    if not isinstance(process, (Autoregressive, LowPass)) or not process.rate:
        return process
    steps = max(round(process.rate / fs), 1)
    off = abs(process.rate / (steps * fs) - 1.0)
    if not 1e-9 < off < MOST:
        return process
    if isinstance(process, LowPass) and process.taps is not None:
        return process.with_(rate=steps * fs, cutoff=None)
    return process.with_(rate=steps * fs)
