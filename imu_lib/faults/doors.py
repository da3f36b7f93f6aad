"""The doors of the room: find everything; give the longest sound stretch; give a record in which
what was found is masked or cut.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.faults import clock, disturbance, dropout, held, motion, restart, tilt, warm_up
from imu_lib.faults.chance import Levels
from imu_lib.faults.finding import BREAKS, Finding, seconds
from imu_lib.faults.levels import bridged, prepared
from imu_lib.record import Record

#: Samples that a stretch must have to be looked at for disturbances.
LEAST = 100
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
    data += held.constant(channels, time)
    data += held.find(channels, time, record.rate, levels, blind)
    data += dropout.missing(channels, time)
    found = data + clock.find(record) + warm_up.find(record)
    if not travels(channels, record.rate, data):
        found += _happened(record, channels, time, levels, data)
    return tuple(sorted(found, key=lambda f: (_rank(f), f.start)))


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
    order = ("constant", "dropout", "stuck", "held", "burst", "gap", "time_grid", "jitter", "rate")
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
        item = tilt.in_hole({c: x for c, x in masked.items()}, time, at)
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
    spans = [(d.start, d.stop) for d in touched]
    x = {c: _clear(ready[c].x, touched, c) for c in good}
    tilts = tilt.find(x, t, rate, spans)
    again = restart.find(x, t, rate, spans + [(k.start, k.stop) for k in tilts])
    return [
        replace(item, rows=item.rows + part.start) if len(item.rows) else item
        for item in (*touched, *tilts, *again)
    ]


def _clear(x: np.ndarray, touched, channel: str) -> np.ndarray:
    """The channel without what a short knock rang, so that its level is seen on both sides.

    Gyros keep what they show during handling: it is the turn.
    """
    if channel.startswith("gyro") or not touched:
        return x
    bad = np.zeros(len(x), bool)
    for item in touched:
        if item.stop - item.start < disturbance.KNOCK:
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


def breaks(findings) -> list[tuple[float, float]]:
    """Spans (s) in which no sound stretch may lie."""
    out = []
    for f in findings:
        if f.kind == "gap" and not clock.long_hole(f.stop - f.start, f.parameters["missing"]):
            continue
        if f.kind in BREAKS:
            out.append((f.start, f.stop))
    return sorted(out)


def longest_stretch(record: Record, findings) -> tuple[float, float]:
    """Start and stop (s) of the longest part without a disturbance, tilt, restart or long hole.

    Drop-outs and short gaps may lie in it.
    """
    end = record.duration
    best, at = (0.0, end), 0.0
    spans = breaks(findings)
    if not spans:
        return best
    length = -1.0
    for low, high in [*spans, (end, end)]:
        if low - at > length:
            best, length = (at, low), low - at
        at = max(at, high)
    return best


@dataclass(frozen=True, eq=False)
class Sound:
    """A record made ready by `sound`.

    record : Record, NaN where a sample is no measurement. start, stop : the stretch of the record
    given that it is, s. cut : whether it is a part. masked : samples that were made NaN, of all channels. left_out : channels
    without a measurement. notes : sentences on what was done.
    """

    record: Record
    findings: tuple[Finding, ...]
    start: float
    stop: float
    cut: bool
    masked: int
    left_out: tuple[str, ...]
    notes: tuple[str, ...]


def sound(
    record: Record, findings: tuple[Finding, ...] | None = None, *, holes: bool = True
) -> Sound:
    """The record with drop-outs, copies and disturbances masked (NaN), a held record thinned to
    the sensor's rate, cut at tilts, restarts and long holes to the longest stretch.

    Parameters
    ----------
    record : Record
    findings : tuple of Finding, optional
        Of `find`; looked for where not given.
    holes : bool
        Whether a long hole ends a stretch, also where nothing is known to have turned in it.

    Raises
    ------
    ValueError
        If no channel is left.
    """
    findings = find(record) if findings is None else findings
    notes: list[str] = []
    dead = tuple(f.channels[0] for f in findings if f.kind == "constant")
    channels = {c: np.array(x) for c, x in record.channels.items() if c not in dead}
    if not channels:
        raise ValueError("`record` holds no channel that ever changes")
    before = sum(int(np.isnan(x).sum()) for x in channels.values())
    thinned: Finding | None = None
    for f in findings:
        if f.kind == "held" and set(f.channels) >= set(channels):
            thinned = f
        elif f.kind in ("dropout", "held", "disturbance") and len(f.rows):
            # what touched some channels visibly touched all
            for c in channels if f.kind == "disturbance" else f.channels:
                if c in channels:
                    channels[c][f.rows] = np.nan
    # a whole channel is never masked away
    lost = [c for c in channels if np.isnan(channels[c]).all()]
    for c in lost:
        channels[c] = np.array(record.channels[c])
    masked = sum(int(np.isnan(x).sum()) for x in channels.values()) - before
    if masked:
        notes.append(f"{masked:,} values that are no measurements are taken as missing.")
    out = replace(record, channels=channels)
    kinds = ("tilt", "restart", "gap") if holes else ("tilt", "restart")
    ending = [f for f in findings if f.kind in kinds]
    start, stop = 0.0, record.duration
    cut = bool(breaks(ending))
    if cut:
        start, stop = longest_stretch(record, ending)
        out = out.slice(start, stop)
        notes.append(
            f"The longest stretch without a tilt, a restart or a long hole is taken: "
            f"{seconds(start)} to {seconds(stop)} s."
        )
    if thinned is not None:
        out = _thinned(out, thinned)
        notes.append(f"The rows are thinned to the sensor's {out.rate:.4g} Hz.")
    burst = next((f for f in findings if f.kind == "burst"), None)
    if burst is not None:
        out = _burst_means(out, burst)
        notes.append(
            f"Each burst is taken as its mean, at {out.rate:.4g} Hz. Between bursts nothing was "
            "measured, so white noise comes out at "
            f"{np.sqrt(1 / burst.evidence['share_recorded']):.3g} times the sensor's N."
        )
    return Sound(out, tuple(findings), start, stop, cut, masked, dead, tuple(notes))


def _burst_means(record: Record, f: Finding) -> Record:
    """The mean of each burst, with the mean of its stamps."""
    time = record.times()
    start = np.flatnonzero(np.r_[True, np.diff(time) > 2.0 / f.parameters["rate"]])
    size = np.diff(np.r_[start, record.n])

    def mean(x):
        return np.add.reduceat(x, start) / size

    return replace(
        record,
        channels={c: mean(x) for c, x in record.channels.items()},
        rate=1.0 / f.parameters["period"],
        time=mean(time) - mean(time)[0],
        temperature=None if record.temperature is None else mean(record.temperature),
    )


def _thinned(record: Record, f: Finding) -> Record:
    """The first of each reading, at the rate of the readings."""
    x = next(iter(record.channels.values()))
    same = np.ones(record.n - 1, bool)
    for x in record.channels.values():
        same &= (x[1:] == x[:-1]) | (np.isnan(x[1:]) & np.isnan(x[:-1]))
    length = f.parameters["length"]
    first = np.flatnonzero(np.r_[True, ~same])
    # readings that agree by chance stand for several
    run = np.diff(np.r_[first, record.n])
    more = np.maximum(np.rint(run / length).astype(int), 1)
    rows = np.concatenate(
        [s + np.rint(np.arange(m) * r / m).astype(int) for s, m, r in zip(first, more, run)]
    )
    return replace(record.take(rows), rate=f.parameters["rate"], time=None)
