"""What the noise model of a record does not have, in a time that its owner will wait.

A short record goes through the gap workflow as it is. A long one is looked at twice: its first
minutes at the full rate show the electronics, lines and quick noises; the whole of it, as means of
blocks, shows what drifts and jumps. `imu-lib gap` looks at all of it at the full rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib import gap, units
from imu_lib.gap.found import Report
from imu_lib.record import Record

#: Samples that are looked at as they are, at the full rate of a longer record, and of block means.
LONGEST, PART, MEANS = 90_000, 45_000, 20_000
#: What the means may name: the rest is noise, which the part at the full rate has seen.
DRIFTS = ("step", "ramp", "warm_up", "temperature", "slow_sinusoid", "telegraph")


@dataclass(frozen=True)
class Missing:
    """What was found.

    looks : (what was looked at, its report); note : a sentence where that was not the whole record
    at the full rate
    """

    looks: tuple[tuple[str, Report], ...]
    note: str = ""


def missing(record: Record, sound=None, *, seed: int = 1) -> Missing:
    """Look for effects that a model fitted to `record` does not have.

    Times in what is told count from the first sample of the record. The workflow masks by itself
    what is no measurement; `sound`, what `faults.sound` gave, is the same for the means of a long
    record.
    """
    if record.n <= LONGEST:
        return Missing((("the record", gap.close(record, seed=seed, simulations=0)),))
    whole, begins = (record, 0.0) if sound is None else (sound.record, sound.start)
    minutes = PART / record.rate / 60.0
    first = gap.close(record.slice(0.0, 60.0 * minutes), seed=seed, simulations=0)
    block = -(-whole.n // MEANS)
    means = gap.close(averaged(whole.uniform(), block), seed=seed, simulations=0)
    note = (
        f"Effects were looked for in the first {minutes:.3g} min at the full rate, and over all "
        f"{units.duration(record.duration)} in means of {block} samples, which show drifts and "
        "jumps alone; `imu-lib gap` looks at all of it."
    )
    if begins > 0.0:
        note += f" Times in the means count from {begins:.6g} s on."
    return Missing(
        (
            (f"the first {minutes:.3g} min", first),
            (f"the whole record, as means of {block} samples", of_drifts(means)),
        ),
        note,
    )


def averaged(record: Record, block: int) -> Record:
    """Means of `block` samples; what is left at the end is dropped."""
    n = record.n // block * block

    def means(x):
        if x is None:
            return None
        parts = x[:n].reshape(-1, block)
        known = np.isfinite(parts).sum(axis=1)  # a block without any sample is missing itself
        return np.where(known, np.nansum(parts, axis=1) / np.maximum(known, 1), np.nan)

    return Record(
        {c: means(record[c]) for c in record.channel_names},
        record.rate / block,
        temperature=means(record.temperature),
        name=record.name,
    )


def of_drifts(report: Report) -> Report:
    """The report without what means of blocks may not name."""
    channels = {
        name: replace(
            c, result=replace(c.result, steps=[s for s in c.result.steps if s.effect in DRIFTS])
        )
        for name, c in report.channels.items()
    }
    return replace(report, channels=channels, record_steps=[], record_unexplained=None)
