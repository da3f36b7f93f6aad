"""Gyro and accelerometer as two streams: in rows of their own, at rates of their own, or one of
them repeated until its next reading. Each is read with its own stamps, then they are laid side by
side.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from imu_lib.readers.meaning import WORD
from imu_lib.readers.raw import Raw
from imu_lib.readers.side_by_side import merge, slow_kind

__all__ = ["held", "kind_of", "merge", "part", "separate", "slow_kind", "without"]

PAIR = {"gyro": ("gyro", "dtheta"), "accel": ("accel", "dv")}
_STAMPS = ("time", "date", "clock", "counter", "time_accel")
MOST_RUNS = 0.95  # share of the runs of one value that must have the usual length


@dataclass(frozen=True)
class Held:
    """rows: those in which a reading is new. length: rows for each reading, on average."""

    rows: np.ndarray
    length: float


def kind_of(canonical: str) -> str | None:
    family = canonical.rpartition("_")[0]
    return next((k for k, families in PAIR.items() if family in families), None)


def channels_of(raw: Raw, kind: str) -> list[np.ndarray]:
    return [x for c, x in raw.columns.items() if kind_of(c) == kind and x.dtype.kind in "fiu"]


def _kinds(raw: Raw) -> list[str]:
    return [k for k in PAIR if channels_of(raw, k)]


def stamps_of(raw: Raw) -> list[np.ndarray]:
    """What tells when a row was taken."""
    parts = [] if raw.subseconds is None else [raw.subseconds]
    return [raw.columns[c] for c in _STAMPS if c in raw.columns] + parts


def empty(raw: Raw, kinds: Iterable[str]) -> np.ndarray:
    """Rows in which no reading of these kinds stands."""
    out = np.ones(raw.rows(), dtype=bool)
    for kind in kinds:
        for x in channels_of(raw, kind):
            out &= np.isnan(x) if x.dtype.kind == "f" else False
    return out


def held(channels: list[np.ndarray]) -> Held | None:
    """Whether readings of several channels (n,) each stand for several rows; None where they do
    not, or where equal neighbours may be chance.
    """
    n = len(channels[0])
    if n < 40:
        return None
    new = np.zeros(n, dtype=bool)
    new[0] = True
    for x in channels:
        step = x[1:] != x[:-1]
        new[1:] |= step & ~(np.isnan(x[1:]) & np.isnan(x[:-1])) if x.dtype.kind == "f" else step
    rows = np.flatnonzero(new)
    if len(rows) > 0.7 * n or len(rows) < 20:
        return None
    run = np.diff(rows)
    usual = int(np.median(run))
    # by chance runs of one row are the most frequent; a reading that is held has runs of one
    # length, or of two neighbouring ones where the rates are no multiples of each other
    if usual < 2 or (run == 1).mean() > 0.03:
        return None
    alike = np.isin(run, (usual - 1, usual, usual + 1)) | (run % usual == 0)
    if alike.mean() < MOST_RUNS:
        return None
    exact = (run % usual == 0).mean() > MOST_RUNS
    if exact:
        # readings that happen to equal the one before are readings all the same
        more = np.flatnonzero((run > usual) & (run % usual == 0) & (run < 4 * usual))
        extra = [np.arange(rows[i] + usual, rows[i + 1], usual) for i in more]
        rows = np.sort(np.concatenate([rows, *extra])) if extra else rows
        return Held(rows, float(usual))
    return Held(rows, float(np.mean(run)))


def part(raw: Raw, kind: str, rows: np.ndarray, time: str = "time") -> Raw:
    """One kind of a raw file in some of its rows."""
    out = Raw(
        raw.source,
        rate=None if len(rows) < raw.rows() else raw.rate,
        contract=raw.contract,
        simulated=raw.simulated,
    )
    out.received = raw.received
    out.line = lambda row: raw.line(int(rows[min(row, len(rows) - 1)]))
    for c, x in raw.columns.items():
        if kind_of(c) in (None, kind) and not c.startswith("time_") and c != "time" or c == time:
            name = "time" if c == time else c
            out.columns[name] = x[rows]
            out.units[name] = raw.units[c]
            out.headings[name] = raw.headings[c]
    if raw.subseconds is not None:
        out.subseconds = raw.subseconds[rows]
    out.described = raw.described  # one table, whichever stream tells more of it
    return out


def without(raw: Raw, rows: np.ndarray) -> None:
    """Keep only some rows of a raw file."""
    line = raw.line
    raw.line = lambda row: line(int(rows[min(row, len(rows) - 1)]))
    for c in list(raw.columns):
        raw.columns[c] = raw.columns[c][rows]
    if raw.subseconds is not None:
        raw.subseconds = raw.subseconds[rows]


def separate(raw: Raw) -> dict[str, Raw] | None:
    """The streams of a file as files of their own, None where it is one stream. Readings that all
    channels hold for several rows are taken once each.
    """
    kinds = _kinds(raw)
    n = raw.rows()
    if raw.simulated or n < 4:
        return None
    if len(kinds) == 2 and "time_accel" in raw.columns:
        every = np.arange(n)
        return {"gyro": part(raw, "gyro", every), "accel": part(raw, "accel", every, "time_accel")}
    if len(kinds) == 2:
        there = {kind: np.flatnonzero(~empty(raw, [kind])) for kind in kinds}
        if (
            any(len(rows) < 0.7 * n for rows in there.values())
            and all(len(r) > 20 for r in there.values())
            and _scattered(there, n)
        ):
            both = np.intersect1d(there["gyro"], there["accel"]).size
            raw.notes += (
                "Gyro and accelerometer stand in rows of their own; they are paired by their "
                "stamps."
                if both < 0.1 * n
                else f"Gyro and accelerometer come at rates of their own ({len(there['gyro']):,} "
                f"and {len(there['accel']):,} readings in {n:,} rows).",
            )
            return {k: part(raw, k, rows) for k, rows in there.items()}
    found = {k: held(channels_of(raw, k)) for k in kinds}
    if all(found.values()) and kinds:
        lengths = [h.length for h in found.values()]
        if max(lengths) / min(lengths) < 1.02:
            together = held([x for k in kinds for x in channels_of(raw, k)])
            if together:
                raw.notes += (
                    f"Each reading stands for {together.length:.4g} rows in all channels: the "
                    "sensor's rate is that much lower than the file's; "
                    "each reading was taken once.",
                )
                if raw.rate:
                    raw.rate /= together.length
                raw.held_rows = together.length
                without(raw, together.rows)
            return None
    if len(kinds) == 2 and any(found.values()):
        every = np.arange(n)
        out = {}
        for kind in kinds:
            if found[kind]:
                raw.notes += (
                    f"The {WORD[kind]} is held: each of its "
                    f"readings stands for {found[kind].length:.4g} rows; "
                    "each was taken once.",
                )
            out[kind] = part(raw, kind, found[kind].rows if found[kind] else every)
            out[kind].held_rows = found[kind].length if found[kind] else 1.0
        return out
    return None


def _scattered(there, n) -> bool:
    """Whether a kind is empty here and there all along, not only in one part of the file."""
    for rows in there.values():
        if len(rows) < 0.7 * n:
            return bool(np.median(np.diff(rows)) < 0.05 * n and (np.diff(rows) > 1).mean() > 0.2)
    return False
