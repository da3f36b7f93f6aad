"""Rows that are no samples of the sensor: copies, a logger's events, rows of something else."""

from __future__ import annotations

import numpy as np

from imu_lib.readers import looks
from imu_lib.readers.raw import Raw
from imu_lib.readers.streams import PAIR, channels_of, empty, held, stamps_of, without

LEAST_OTHERS = 0.02  # share of rows between the others that may be of something else
COPIES = 0.02  # share of the rows that may be copies without a word


def drop_copies(raw: Raw) -> None:
    """Leave out rows that repeat stamp and values of the row before, where such copies are no
    accident: a row logged twice, or a copy that a driver puts in the place of a lost sample.
    """
    _drop_blanks(raw)
    stamps = stamps_of(raw)
    if raw.rows() < 3:
        return
    if not stamps:
        _say_copies(raw)
        return
    _drop_events(raw, stamps)
    stamps = stamps_of(raw)
    same = np.logical_and.reduce([x[1:] == x[:-1] for x in stamps])
    if not same.any():
        return
    twice = _repeated(raw)
    by_chance = float(twice[~same].mean()) if (~same).any() else 0.0
    if twice[same].mean() < 0.98 or by_chance > 0.3:
        return
    _leave_out(raw, same & twice)


def once(raw: Raw, stamp: np.ndarray) -> np.ndarray:
    """Leave out rows that repeat stamp and values of the row before; the rows that are kept."""
    return _leave_out(raw, (np.diff(stamp) == 0) & _repeated(raw))


def _repeated(raw: Raw) -> np.ndarray:
    """Whether each row but the first has the readings of the row before."""
    twice = np.ones(raw.rows() - 1, dtype=bool)
    for kind in PAIR:
        for x in channels_of(raw, kind):
            equal = x[1:] == x[:-1]
            if x.dtype.kind == "f":
                equal |= np.isnan(x[1:]) & np.isnan(x[:-1])
            twice &= equal
    return twice


def _leave_out(raw: Raw, copies: np.ndarray) -> np.ndarray:
    """Leave out copies of the row before, with a word; the rows that are kept."""
    kept = np.flatnonzero(np.r_[True, ~copies])
    if copies.any():
        raw.notes += (
            f"{int(copies.sum()):,} rows are copies of the row before (same time, same values) and "
            "were left out.",
        )
        without(raw, kept)
    return kept


def _drop_blanks(raw: Raw) -> None:
    """Leave out rows that have neither a stamp nor a reading: another topic's, or the end of a
    table whose other columns are longer.
    """
    time = raw.columns.get("time", np.zeros(0))
    if time.dtype.kind not in "fiu" or not time.size:
        return
    blank = empty(raw, PAIR)
    unstamped = np.isnan(time) if time.dtype.kind == "f" else np.zeros(len(time), dtype=bool)
    if blank.all() or not blank.any():
        return
    said = "neither a stamp of the sensor nor a reading"
    if not (blank & unstamped).any():
        # stamps that are even without these rows and uneven with them: not of the sensor
        spread = looks.unevenness(time), looks.unevenness(time[~blank])
        if blank.mean() < LEAST_OTHERS or spread[0] < 0.3 or spread[1] > 0.3 * spread[0]:
            return
        said, unstamped = "no reading, and stamps between those of the readings", blank
    others = blank & unstamped
    raw.notes += (
        f"{int(others.sum()):,} rows have {said}: they are of something else in the table, and "
        "were left out.",
    )
    without(raw, np.flatnonzero(~others))


def _drop_events(raw: Raw, stamps: list[np.ndarray]) -> None:
    """Leave out rows without a reading that share their stamp with a row beside them: a
    logger's events.
    """
    without_reading = empty(raw, PAIR)
    if not without_reading.any():
        return
    same = np.logical_and.reduce([x[1:] == x[:-1] for x in stamps])
    shared = without_reading & (np.r_[same, False] | np.r_[False, same])
    if shared.any():
        raw.notes += (
            f"{int(shared.sum()):,} rows hold no reading and the stamp of a row beside them: they "
            "were left out.",
        )
        without(raw, np.flatnonzero(~shared))


def _say_copies(raw: Raw) -> None:
    """A word on rows without stamps that repeat the row before in every channel, where that is no
    chance and no held reading.
    """
    channels = [x for k in PAIR for x in channels_of(raw, k)]
    if len(channels) < 2 or held(channels):
        return
    alike = [x[1:] == x[:-1] for x in channels]
    copies = float(np.logical_and.reduce(alike).mean())
    others = ~alike[-1]
    by_chance = float(alike[0][others].mean()) if others.any() else 1.0
    if copies > COPIES and by_chance < 0.2 * copies:
        rows = round(copies * (raw.rows() - 1))
        raw.notes += (
            f"{rows:,} of {raw.rows():,} rows repeat the row before in every channel: rows logged "
            "twice, or copies for lost samples; without stamps each counts as a sample.",
        )
