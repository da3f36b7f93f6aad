"""Lines of a given model in the phase that they have in the record at hand: a phase is of the day
on which it was fitted, amplitude and frequency are the sensor's or its surroundings'.
"""

from __future__ import annotations

from imu_lib.arrays import Array
from imu_lib.ensembles.ensemble import filled
from imu_lib.gap.data import Data
from imu_lib.gap.effects.sinusoid import FIRST
from imu_lib.gap.effects.sinusoid import Sinusoid as Effect
from imu_lib.processes import Sinusoid, Sum

#: Share of a line's amplitude below which the record does not have it.
THERE = 0.5


def in_phase(given: Sum | None, raw: Array, fs: float) -> Sum | None:
    """The given model of a channel, its lines as `raw` has them (NaN where a sample is missing);
    slow waves, and lines that are not there, as they came.
    """
    if given is None:
        return None
    least = 0.5 * FIRST * fs / len(raw)
    lines = [t for t in given.terms if isinstance(t, Sinusoid) and t.frequency > least]
    lines = [line for line in lines if line.phase is not None]
    if not lines:
        return given
    x = filled(raw)
    data, changed = Data(x - x.mean(), fs), {}
    for line in lines:
        own, _ = Effect().refine(data, line.frequency)
        if own.amplitude > THERE * line.amplitude:
            changed[id(line)] = line.with_(frequency=own.frequency, phase=own.phase)
    return Sum(tuple(changed.get(id(t), t) for t in given.terms), given.stages)
