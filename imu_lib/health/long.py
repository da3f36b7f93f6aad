"""The health of a record on disk: its parts one after the other, put together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.faults.finding import seconds
from imu_lib.health.record import of_record
from imu_lib.health.result import Channel, Clock, Health, Motion
from imu_lib.health.sentences import sentences
from imu_lib.long_record import LongRecord

#: Samples of a part: twenty minutes at 200 Hz.
PART = 1 << 18


def of_long(record: LongRecord, *, progress=None) -> Health:
    """The health of a record on disk.

    Each part is looked at as a record of its own, so that a fault is told with the part's --start
    and --stop, which show it alone. `progress` is called with the share that is done.
    """
    parts, starts = [], []
    for low in range(record.begin, record.rows, PART):
        high = min(low + PART, record.rows)
        if record.rows - high < PART // 4:  # no crumbs at the end
            high = record.rows
        parts.append(of_record(record.part(low, high)))
        starts.append(record.second(low))
        if progress is not None:
            progress((high - record.begin) / (record.rows - record.begin))
        if high == record.rows:
            break
    clock = _clock(record, parts)
    weight = np.array([p.clock.samples for p in parts], float)
    channels = {c: _channel([p.channels[c] for p in parts], weight) for c in record.channel_names}
    faults = tuple(
        _placed(fault, start, part.clock.duration)
        for part, start in zip(parts, starts, strict=True)
        for fault in part.faults
    )
    motion = _motion(parts, starts)
    return Health(
        record.name,
        record.source,
        clock,
        channels,
        motion,
        None,
        None,
        record.notes,
        tuple(sentences(record, clock, _scattered(channels, parts), motion, None, faults)),
        faults,
    )


def _scattered(channels, parts):
    """The channels with the scatter within a part, in which no drift hides a coarse grid."""
    scatter = {n: [s for p in parts if (s := p.channels[n].sd) > 0] for n in channels}
    return {
        name: replace(c, sd=float(np.median(scatter[name] or [0.0])))
        for name, c in channels.items()
    }


def _clock(record, parts):
    gaps = record.time_gaps()
    jitter = [p.clock.jitter for p in parts if p.clock.jitter is not None]
    return Clock(
        record.rows - record.begin,
        record.rate,
        record.duration,
        any(p.clock.stamped for p in parts),
        max(jitter, default=None),
        any(p.clock.bursts for p in parts),
        0,
        tuple(sorted(gaps, key=lambda g: -g[1])[:10]),
        len(gaps),
        sum(g[2] for g in gaps),
    )


def _channel(parts: list[Channel], weight) -> Channel:
    mean = float(np.average([p.mean for p in parts], weights=weight))
    square = [p.sd**2 + (p.mean - mean) ** 2 for p in parts]
    steps = [p.resolution for p in parts if p.resolution]
    varied = sum(p.high > p.low for p in parts)  # a part on one level tells no step
    return Channel(
        mean,
        float(np.sqrt(np.average(square, weights=weight))),
        min(p.low for p in parts),
        max(p.high for p in parts),
        sum(p.nan for p in parts),
        float(np.median(steps)) if len(steps) > varied / 2 else None,
        sum(p.saturated for p in parts),
        sum(p.frozen for p in parts),
        max(p.longest_run for p in parts),
        float(np.median([p.noise for p in parts])),
    )


def _motion(parts, starts):
    share = np.array([p.clock.duration for p in parts])
    share /= share.sum()
    moving = float(share @ [p.motion.moving_share for p in parts])
    states = {p.motion.state for p in parts}
    state = next((s for s in ("moved", "touched") if s in states), "at rest")
    if moving > 0.01:
        state = "moving" if moving > 0.5 else "partly moving"
    best, current = (0.0, 0.0), None
    for part, start in zip(parts, starts, strict=True):
        low, high = start + part.motion.rest_start, start + part.motion.rest_stop
        whole = part.motion.rest_start <= 0
        current = (current[0], high) if current and whole else (low, high)
        best = max(best, current, key=lambda ends: ends[1] - ends[0])
        if part.motion.rest_stop < part.clock.duration - 1e-9:
            current = None
    gravity = [p.motion.gravity for p in parts]
    known = [g for g in gravity if g is not None]
    return Motion(
        state,
        moving,
        float(share @ [p.motion.shaking_share for p in parts]),
        best[0],
        best[1],
        float(np.median(known)) if len(known) == len(gravity) else None,
    )


def _placed(fault, start, duration):
    """The fault at its place in the whole; its sentence keeps the part's own seconds."""
    said = f"--start {seconds(start)} --stop {seconds(start + duration)}: {fault.sentence}"
    return replace(
        fault,
        start=fault.start + start,
        stop=fault.stop + start,
        sentence=said,
        rows=np.zeros(0, np.int64),
    )
