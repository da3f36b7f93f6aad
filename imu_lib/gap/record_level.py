"""What acts on the whole record, as steps: missing samples, jitter of the time stamps, noise that
channels share.
"""

from __future__ import annotations

from typing import Any

from imu_lib.gap import reliability
from imu_lib.gap.effects.common_mode import CommonMode
from imu_lib.gap.effects.competitor import process_parameters
from imu_lib.gap.effects.jitter import Jitter, is_even
from imu_lib.gap.effects.time_gaps import TimeGaps
from imu_lib.gap.steps import Step, step_of
from imu_lib.model import Model
from imu_lib.processes import CommonMode as Shared
from imu_lib.record import Record


def timing(record: Record, model: Model | None) -> tuple[list[Step], str | None]:
    """Missing samples and jitter, and a sentence where the time stamps do something else."""
    held = {p.name for p in model.record} if model is not None else set()
    steps = []
    for effect in (TimeGaps(), Jitter()):
        found = None if effect.name in held else effect.detect(record)
        if found is not None:
            if not is_even(found, record.rate):
                steps.append(step_of(found))
            if found.doubt:
                return steps, found.doubt
    return steps, None


def common_step(process: Shared, note: dict[str, Any]) -> Step:
    """Noise in common as a step of the record."""
    names = ", ".join(process.channels)
    parameters = {**process_parameters(process), "share": note["share"]}
    return Step(
        "common_mode",
        parameters,
        {"N": note["interval"]},
        f"coherence between {names}: {note['coherence']:.2g} where independent channels have none, "
        f"{100 * note['share']:.2g} % of their noise power",
        reliability.odds(note["gain"], note["sets"]),
        {"effect": "none", "confidence": 0.0},
        [],
        gain=note["gain"],
        gap_before=note["z_before"],
        gap_after=note["z_after"],
        cause=CommonMode.cause,
    )
