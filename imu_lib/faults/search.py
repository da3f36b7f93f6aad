"""Find everything that is wrong with a record."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib.faults import (
    clock,
    copied,
    dead_zone,
    disturbance,
    dropout,
    held,
    hole,
    motion,
    passing,
    restart,
    rhythm,
    tilt,
    walking,
    warm_up,
)
from imu_lib.faults.chance import Levels
from imu_lib.faults.finding import Finding
from imu_lib.faults.levels import bridged, prepared, windows
from imu_lib.record import Record

#: Samples that a stretch must have to be looked at for disturbances.
LEAST = 100
#: s about a tilt within which a disturbance may be its pulse, and share of stretches of a record
#: that are no louder than what is no shake.
NEAR, USUAL = 1.5, 0.95
#: Share of the rows on several channels that one kind of drop-out may take and still be masked.
MOST_MASKED = 0.6


def find(record: Record) -> tuple[Finding, ...]:
    """All faults and disturbances of a record: first of the data, then of the clock, then what
    happened to the sensor; linear in the number of samples.

    On a sensor that travels (a drive) only the data and the clock are looked at.

    Parameters
    ----------
    record : Record
    """
    channels = {c: np.asarray(x) for c, x in record.channels.items()}
    time = record.times()
    levels = {c: Levels.of(x) for c, x in channels.items()}
    data = dropout.find(channels, time, levels)
    blind = np.zeros(record.n, bool)
    for item in data:
        if len(item.channels) > 1:
            blind[item.rows] = True
    dead = dead_zone.find({c: np.where(blind, np.nan, x) for c, x in channels.items()}, time)
    data += held.constant(channels, time)
    data += held.find(channels, time, record.rate, levels, blind)
    # what stands at the value of a dead zone is neither lost nor frozen
    zero = {c: item.parameters["value"] for item in dead for c in item.channels}
    data = [d for d in data if not _swallowed(d, channels, zero)] + dead
    data += dropout.missing(channels, time)
    data += copied.find(channels, time)
    found = data + clock.find(record) + warm_up.find(record)
    if not travels(channels, record.rate, data):
        found += _happened(record, channels, time, levels, data)
    return tuple(sorted(found, key=lambda f: (_rank(f), f.start)))


def _swallowed(item: Finding, channels, zero: dict[str, float]) -> bool:
    """Whether what was found is visits to the dead zones of its channels, at the values `zero`."""
    return all(
        c in zero and (not len(item.rows) or np.mean(channels[c][item.rows] == zero[c]) > 0.5)
        for c in item.channels
    )


def travels(channels, rate: float, data) -> bool:
    """Whether the sensor moves for so long that it is not at rest with disturbances."""
    x = {c: bridged(v, _bad(c, v, data)) for c, v in channels.items()}
    return motion.windows(x, rate, {}).travels


def _bad(channel: str, x: np.ndarray, data) -> np.ndarray:
    """Samples that are no measurements; copies of a slow stream are its level and stay."""
    bad = np.isnan(x)
    for item in data:
        if item.kind in ("dropout", "stuck") and channel in item.channels:
            bad[item.rows] = True
    return bad


def _rank(finding: Finding) -> int:
    order = (
        "constant",
        "copied",
        "dead_zone",
        "dropout",
        "stuck",
        "held",
        "burst",
        "gap",
        "time_grid",
        "jitter",
        "rate",
    )
    return order.index(finding.kind) if finding.kind in order else len(order)


def _happened(record, channels, time, levels, data) -> list[Finding]:
    """Disturbances, tilts and restarts, one stretch between long holes after the other."""
    bad = {c: _bad(c, x, data) for c, x in channels.items()}
    dead = {item.channels[0] for item in data if item.kind == "constant"}
    live = [c for c in channels if c not in dead and len(levels[c].values) > 2]
    breaks = _hole_rows(record)
    edges = [0, *(b + 1 for b in breaks), record.n]
    found: list[Finding] = []
    for low, high in zip(edges[:-1], edges[1:]):
        if high - low < LEAST or not live:
            continue
        rate = _row_rate(time[low:high], record.rate)
        found += _within(live, channels, bad, levels, slice(low, high), time, rate)
    masked = {c: np.where(bad[c], np.nan, channels[c]) for c in live} if breaks else {}
    for at in breaks:
        item = hole.turned({c: x for c, x in masked.items()}, time, at)
        if item is not None:
            found.append(item)
    return found


def _within(live, channels, bad, levels, part, time, rate) -> list[Finding]:
    good = [c for c in live if bad[c][part].mean() < MOST_MASKED]
    if not good:
        return []
    ready = {c: prepared(channels[c][part], bad[c][part], rate, _grid(levels[c])) for c in good}
    t = time[part]
    touched = disturbance.find(ready, t, rate)
    touched += walking.find(ready, touched, t, rate)
    touched = rhythm.gathered([*touched, *passing.find(ready, touched, t, rate)], ready, rate)
    spans = [(d.start, d.stop) for d in touched]
    tilts = tilt.find({c: ready[c].x for c in good}, t, rate, spans)
    touched = [d for d in touched if not _is_turn(d, tilts, ready, t)]
    calm = {c: _calm(ready[c].x, touched) for c in good}
    handled, turned = ([(k.start, k.stop) for k in some] for some in (long_ones(touched), tilts))
    again = restart.find(calm, t, rate, turned, handled)
    return [
        replace(item, rows=item.rows + part.start) if len(item.rows) else item
        for item in (*touched, *tilts, *again)
    ]


def _is_turn(item: Finding, tilts: list[Finding], ready, time: np.ndarray) -> bool:
    """Whether what stands out is the gyros' pulse of a tilt: within it, and no sample is further
    from the one before than elsewhere.
    """
    inside = any(t.start - NEAR <= item.start and item.stop <= t.stop + NEAR for t in tilts)
    if not inside or len(item.rows) < LEAST:
        return False
    for c in item.channels:
        quick = np.diff(ready[c].x) / ready[c].sigma[1:]
        part = quick[item.rows[:-1]]
        usual = np.quantile(_mean_squares(quick, len(part)), USUAL)
        if np.mean(part**2) > usual:
            return False
    return True


def _mean_squares(x: np.ndarray, size: int) -> np.ndarray:
    return np.asarray((windows(x, size, 0) ** 2).mean(axis=1))


def long_ones(touched: list[Finding]) -> list[Finding]:
    """Handling, not knocks."""
    return [d for d in touched if d.stop - d.start >= disturbance.KNOCK]


def _calm(x: np.ndarray, touched: list[Finding]) -> np.ndarray:
    """The channel without what it showed while it was touched, so that levels are seen."""
    bad = np.zeros(len(x), bool)
    for item in touched:
        bad[item.rows] = True
    return bridged(x, bad)


def _grid(levels: Levels) -> float:
    if not levels.coarse or len(levels.values) < 2:
        return 0.0
    return float(np.median(np.diff(levels.values)))


def _row_rate(time: np.ndarray, rate: float) -> float:
    """Rows per second where samples are missing all over (bursts), else the rate."""
    span = float(time[-1] - time[0])
    rows = (len(time) - 1) / span if span > 0 else rate
    return rows if rows < 0.8 * rate else rate


def _hole_rows(record: Record) -> list[int]:
    """Last rows before the holes that end a stretch."""
    if record.time is None:
        return []
    starts = [low for low, _ in clock.holes(record)]
    return np.searchsorted(record.times(), starts).tolist()
