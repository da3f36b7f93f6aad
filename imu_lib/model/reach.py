"""What a record of some length and rate cannot show of a model, or shows as something else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from imu_lib import units
from imu_lib.processes import Process, Sinusoid, Vibration
from imu_lib.timing import folded

if TYPE_CHECKING:
    from imu_lib.model import Model

#: Attributes that say when something begins, s from the first sample.
BEGINS = ("time", "start")


def out_of_reach(model: Model, rate: float, duration: float) -> list[str]:
    """Sentences on lines above half the sampling rate, which are folded below it, and on what
    begins after the end of a record of `duration` s at `rate` Hz.
    """
    out = []
    for name, entry in model.channels.items():
        for process in (*entry.terms, *entry.stages):
            out += [f"{name}: {s}" for s in _of(process, rate, duration)]
    for process in model.record:
        out += _of(process, rate, duration)
    return out


def _of(process: Process, rate: float, duration: float) -> list[str]:
    out = []
    if isinstance(process, (Sinusoid, Vibration)):
        lines = process.harmonics if isinstance(process, Vibration) else 1
        above = [f for k in range(lines) if (f := (k + 1) * process.frequency) > rate / 2]
        if above:
            at = folded(above[0], rate)
            more = ", with its lines above it," if len(above) > 1 else ""
            out.append(
                f"the {process.name} of {above[0]:.6g} Hz{more} lies above half the sampling rate "
                f"and is seen folded, at {at:.6g} Hz."
            )
    for key in BEGINS:
        begins = getattr(process, key, None)
        if isinstance(begins, (int, float)) and begins >= duration:
            what = process.name.replace("_", " ")
            out.append(
                f"the {what} at {begins:.6g} s lies beyond the end of the record "
                f"({units.duration(duration)}) and is not in it."
            )
    return out
