"""The longest sound stretch of a record, and the record with what was found masked or cut."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from imu_lib.faults import clock
from imu_lib.faults.finding import BREAKS, Finding, seconds
from imu_lib.faults.search import find
from imu_lib.faults.standing import STANDS, stands
from imu_lib.record import Record

#: s left out on each side of a tilt or a restart.
ASIDE = 1.0


def breaks(findings) -> list[tuple[float, float]]:
    """Spans (s) in which no sound stretch may lie."""
    out = []
    for f in findings:
        anew = f.parameters.get("begun_anew", False)
        if f.kind == "gap" and not (
            anew or clock.long_hole(f.stop - f.start, f.parameters["missing"])
        ):
            continue
        # the ends of a turn are known to some tenths of a second
        margin = ASIDE if f.kind == "restart" or f.kind == "tilt" and len(f.rows) else 0.0
        if f.kind in BREAKS:
            out.append((max(0.0, f.start - margin), f.stop + margin))
    return sorted(out)


def stretches(
    record: Record, findings, between: tuple[float, float] | None = None
) -> list[tuple[float, float]]:
    """Start and stop (s) of the parts without a disturbance, tilt, restart or long hole, the
    longest first.

    Drop-outs and short gaps may lie in them. `between` (s): where something is measured at all.
    """
    at, end = between or (0.0, record.duration)
    out = []
    for low, high in [*breaks(findings), (end, end)]:
        if min(low, end) > at:
            out.append((at, min(low, end)))
        at = max(at, high)
    return sorted(out, key=lambda part: part[0] - part[1]) or [between or (0.0, record.duration)]


def longest_stretch(
    record: Record, findings, between: tuple[float, float] | None = None
) -> tuple[float, float]:
    """The longest of the `stretches`."""
    return stretches(record, findings, between)[0]


@dataclass(frozen=True, eq=False)
class Sound:
    """A record made ready by `sound`.

    record : Record, NaN where a sample is no measurement. start, stop : the stretch of the record
    given that it is, s. cut : whether it is a part. others : the sound stretches (start, stop)
    beside it, s, the longest first. masked : samples that were made NaN, of all
    channels. left_out : channels without a measurement. notes : sentences on what was done.
    """

    record: Record
    findings: tuple[Finding, ...]
    start: float
    stop: float
    cut: bool
    masked: int
    left_out: tuple[str, ...]
    notes: tuple[str, ...]
    others: tuple[tuple[float, float], ...] = ()


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
        elif (f.kind in ("dropout", "held", "disturbance") or stands(f)) and len(f.rows):
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
    first, last = _measured(out)
    if first > 0 or last < record.duration:
        notes.append(
            f"Something is measured from {seconds(first)} to {seconds(last)} s; the rest is cut "
            "off."
        )
        start, stop = first, last
        out = out.slice(start, stop)
    others: list[tuple[float, float]] = []
    if cut:
        (start, stop), *others = stretches(record, ending, (start, stop))
        out = replace(record, channels=channels).slice(start, stop)
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
    told = tuple(notes), tuple(others)
    return Sound(out, tuple(findings), start, stop, cut, masked, dead, *told)


def _measured(record: Record) -> tuple[float, float]:
    """From when to when (s) anything is measured; the ends of the record where less than STANDS
    samples are lost there.
    """
    lost = np.logical_and.reduce([np.isnan(x) for x in record.channels.values()])
    rows, time = np.flatnonzero(~lost), record.times()
    first = float(time[rows[0]]) if rows[0] >= STANDS else 0.0
    lost_at_end = record.n - 1 - rows[-1] >= STANDS
    last = float(time[rows[-1] + 1]) if lost_at_end else record.duration
    return first, last


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
