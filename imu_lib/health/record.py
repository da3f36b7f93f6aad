"""The health of a record."""

from __future__ import annotations

import numpy as np

from imu_lib import faults, timing
from imu_lib.faults import clock as stamps
from imu_lib.faults import motion as windows
from imu_lib.health.channels import of_channel
from imu_lib.health.result import Channel, Clock, Health, Motion
from imu_lib.health.sentences import sentences
from imu_lib.readers import plausibility
from imu_lib.record import Record


def of_record(record: Record, *, repeats: int = 0) -> Health:
    """The health of a record; `repeats` is how many time stamps repeated the one before when it
    was read.
    """
    found = faults.find(record)
    clock = _clock(record, repeats)
    channels = {c: of_channel(c, x, record.rate, found) for c, x in record.channels.items()}
    motion = _motion(record, channels, found)
    temperature = _temperature(record)
    return Health(
        record.name,
        record.source,
        clock,
        channels,
        motion,
        temperature,
        None,
        record.notes,
        tuple(sentences(record, clock, channels, motion, temperature, found)),
        found,
    )


def _clock(record: Record, repeats: int) -> Clock:
    gaps = record.gaps()
    return Clock(
        record.n,
        record.rate,
        record.duration,
        record.time is not None,
        stamps.jitter_of(record),
        record.time is not None and timing.in_bursts(record.time),
        repeats,
        tuple(tuple(g) for g in sorted(gaps, key=lambda g: -g.duration)[:10]),
        len(gaps),
        sum(g.missing for g in gaps),
    )


def _motion(record: Record, channels: dict[str, Channel], found) -> Motion:
    clean = {c: np.array(x) for c, x in record.channels.items()}
    for f in found:
        for c in f.channels:
            if f.kind in ("dropout", "stuck", "disturbance") and c in clean:
                clean[c][f.rows] = np.nan
    grid = {c: x.resolution or 0.0 for c, x in channels.items()}
    full = {c: _carried(x) for c, x in clean.items()}
    seen = windows.windows(full, record.rate, grid)
    share = seen.moving_share
    kinds = {f.kind for f in found}
    if seen.travels and seen.restless_share > 0.5:
        state, share = "moving", seen.restless_share
    elif share > 0.01:
        state = "partly moving"
    elif "tilt" in kinds:
        state = "moved"
    else:
        state = "touched" if "disturbance" in kinds else "at rest"
    start, stop = faults.longest_stretch(record, found)
    if state in ("moving", "partly moving"):
        low, high = timing.longest_run(~seen.moving & seen.known, np.array([], dtype=int))
        time = record.times()
        at = (int(low * seen.size), min(int(high * seen.size), record.n - 1))
        start, stop = max(start, float(time[at[0]])), min(stop, float(time[at[1]]))
        stop = max(stop, start)
    accel = record["accel"] if all(f"accel_{a}" in record for a in "xyz") else None
    gravity = None if accel is None else plausibility.gravity(accel)
    return Motion(state, share, seen.shaking_share, start, stop, gravity)


def _carried(x: np.ndarray) -> np.ndarray:
    """Missing samples replaced by the last one that is there."""
    bad = np.isnan(x)
    if not bad.any():
        return x
    last = np.maximum.accumulate(np.where(bad, 0, np.arange(len(x))))
    return x[last]


def _temperature(record: Record) -> dict | None:
    t = record.temperature
    if t is None or np.isnan(t).all():
        return None
    return {
        "low": float(np.nanmin(t)),
        "high": float(np.nanmax(t)),
        "first": float(t[0]),
        "last": float(t[-1]),
    }
