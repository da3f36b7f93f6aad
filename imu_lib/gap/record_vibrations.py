"""The record before its channels: on the levels of its converters, and what shakes it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.effects.base import Finding
from imu_lib.gap.effects.resolution import grid_of, ladder
from imu_lib.gap.effects.vibration import VIBRATION
from imu_lib.gap.steps import Step, step_of
from imu_lib.model import Model
from imu_lib.record import Record

#: Confidence at the most in a vibration of one channel that begins or ends: a faint tone whose
#: amplitude rises looks the same (three of nine such tones 18 dB above the noise).
ALONE = 0.8


@dataclass(frozen=True)
class RecordView:
    """What an effect of the record looks at: the record with its stamps, its channels on the even
    grid (NaN where a sample is missing) at `fs` Hz, the temperature there, the given model.
    """

    record: Record
    raw: dict[str, Array]
    fs: float
    temperature: np.ndarray | None
    model: Model | None


def vibrations(
    record: Record, raw: dict[str, Array], fs: float, temperature: Array | None, model: Model | None
) -> tuple[list[Finding], dict[str, Array]]:
    """What shakes the record: findings, and what they put into the channels (name -> (n,))."""
    view = RecordView(record, raw, fs, temperature, model)
    found = VIBRATION.candidates(view)
    known: dict[str, Array] = {}
    for item in found:
        for name, signal in (item.signal or {}).items():
            known[name] = known.get(name, 0.0) + signal
    return found, known


def parted(found: list[Finding]) -> tuple[list[Finding], dict[str, str]]:
    """Findings that are vibrations, and channel -> sentences about those that are none."""
    nameless: dict[str, list[str]] = {}
    for item in found:
        if item.doubt:
            for name in item.signal or {}:
                nameless.setdefault(name, []).append(item.doubt)
    return [item for item in found if not item.doubt], {
        name: "; ".join(told) for name, told in nameless.items()
    }


def vibration_step(found: Finding) -> Step:
    """A vibration as a step of the record."""
    step, alone = step_of(found), len(found.process.channels) == 1
    if found.evidence:
        step = replace(step, where=f"{found.where}, {found.evidence}")
    return step.capped(ALONE) if alone and found.process.start is not None else step


def on_levels(raw: dict[str, Array]) -> dict[str, Array]:
    """The channels (name -> (n,)) on the levels of their converters, where a calibration has
    blurred these and more digits were printed than there are levels.
    """
    out = {}
    for name, x in raw.items():
        good = x[~np.isnan(x)]
        grid, levels = grid_of(good), ladder(good)
        out[name] = x
        if levels is not None and (grid is None or levels[0] > 1.5 * grid[0]):
            out[name] = np.array(x)
            out[name][~np.isnan(x)] = levels[2]
    return out
