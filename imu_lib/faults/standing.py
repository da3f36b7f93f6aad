"""Output that stands still: one value for longer than the noise and the grid ever make it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from imu_lib import timing
from imu_lib.faults.chance import run_starts
from imu_lib.faults.finding import Finding, named, seconds
from imu_lib.record import Record

#: Runs that chance may make in a record, to be called frozen.
FROZEN = 1e-6
#: Copies in a row from which on an output stands still; a logger that lost samples writes fewer.
STANDS = 200
#: Share of the samples that equal the one before by chance, at the least.
LEAST = 0.01
#: Share of a channel that stands still, from which on too little is left of it.
MOST_STILL = 0.5


def stands(finding: Finding) -> bool:
    """Whether a finding is an output that stands still for long, on one channel or several."""
    copies = finding.kind == "stuck" or bool(finding.parameters.get("held"))
    return copies and finding.evidence.get("longest", 0) >= STANDS


def masked(record: Record) -> tuple[Record, tuple[str, ...]]:
    """The record with NaN where an output stands still for long, and sentences on it; a channel
    that does for most of the record is left out.
    """
    channels, time = dict(record.channels), record.times()
    told: dict[str, list[str]] = {}
    for name, x in record.channels.items():
        rows = _in_long_runs(frozen_rows(repeats(x), LEAST))
        if not len(rows) or np.nanmin(x) == np.nanmax(x):
            continue
        share, first, last = len(rows) / len(x), run_starts(rows)[0], rows[-1]
        if share > MOST_STILL:
            del channels[name]
        else:
            channels[name] = np.where(np.isin(np.arange(len(x)), rows), np.nan, x)
        text = sentence(share, float(time[first]), float(time[last]), name in channels)
        told.setdefault(text, []).append(name)
    notes = noted(told)
    return (replace(record, channels=channels) if notes and channels else record), notes


def sentence(share: float, start: float, stop: float, kept: bool) -> str:
    """What is said of channels that stand still for a `share` of the samples, `start` to `stop` s,
    of which the rest is `kept`.
    """
    left_out = "these samples are" if kept else "the channel is"
    return (
        f"{100 * share:.2g} % of the samples stand still, from {seconds(start)} to {seconds(stop)} "
        f"s (frozen output); {left_out} left out."
    )


def noted(told: dict[str, list[str]]) -> tuple[str, ...]:
    """Sentences by the channels that they are about."""
    return tuple(f"On {named(tuple(on))} {text}" for text, on in told.items())


def least_run(n: int, chance: float) -> float:
    """Equal neighbours in a row beyond which chance makes none in `n` samples, where a share
    `chance` of them is equal.
    """
    return max(8.0, np.log(n / FROZEN) / -np.log(min(chance, 0.995)))


def repeats(x: np.ndarray) -> np.ndarray:
    """Which samples equal the one before, shape (n,), bool."""
    return np.r_[False, x[1:] == x[:-1]]


def frozen_rows(again: np.ndarray, chance: float) -> np.ndarray:
    """Rows of runs of equal neighbours that are longer than the grid makes them anywhere near."""
    n = len(again)
    start, stop = timing.runs(again)
    length = stop - start
    p = min(max(chance, float(again.mean())), 0.995)
    long = np.flatnonzero(length > least_run(n, p))
    total = np.r_[0, np.cumsum(again)]
    rows = []
    for i in long:
        k = int(length[i])
        low, high = max(0, start[i] - 5 * k), min(n, stop[i] + 5 * k)
        near = (total[high] - total[low] - k) / max(1, high - low - k)
        if near < 1 and k > np.log(n / FROZEN) / -np.log(max(near, p)):
            rows.append(np.arange(start[i], stop[i]))
    return np.concatenate(rows) if rows else np.zeros(0, np.int64)


def together(frozen: dict, n: int) -> list[tuple[list[str], np.ndarray]]:
    """Channels that stand still together for long, and the rows: no count of coincidences tells of
    it, since for as long as it lasts each of them repeats all the time.
    """
    groups: list[tuple[list[str], np.ndarray]] = []
    for c, rows in frozen.items():
        mask = np.zeros(n, bool)
        mask[_in_long_runs(rows)] = True
        home = next((g for g in groups if mask.any() and _same(g[1], mask)), None)
        if home is not None:
            home[0].append(c)
            home[1][:] &= mask
        elif mask.any():
            groups.append(([c], mask))
    return [(group, np.flatnonzero(mask)) for group, mask in groups if len(group) > 1]


def long_runs(rows: np.ndarray) -> list[tuple[int, int]]:
    """(first, one behind the last) row of the runs of STANDS or more."""
    parts = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    return [(int(p[0]), int(p[-1]) + 1) for p in parts if len(p) >= STANDS]


def _in_long_runs(rows: np.ndarray) -> np.ndarray:
    """Rows of the runs of STANDS or more."""
    parts = [np.arange(a, b) for a, b in long_runs(rows)]
    return np.concatenate(parts or [np.zeros(0, np.int64)])


def _same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two masks, shape (n,), are nearly the same rows."""
    return bool(np.sum(a & b) > 0.9 * np.sum(a | b))
