"""Where the samples of a long record lie on the even grid: gaps in its stamps, missing numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.errors import InputError


@dataclass(frozen=True)
class Grid:
    """rate, Hz; runs (k, 3): rows start, stop and the first one's slot; gaps: samples missing in
    each gap of the stamps; missing: rows without a number in some channel; flat: places, in the
    list of columns, of those that never change; steps (g, 2): row after each gap of the stamps and
    samples missing before it.
    """

    rate: float
    runs: np.ndarray
    gaps: tuple
    missing: int
    flat: tuple
    steps: np.ndarray


def lay(source, columns, rows, stamps, rate):
    """The grid of a file's rows, or None where the stamps are not those of an even clock with gaps.

    Parameters
    ----------
    columns : list of Column
    rows : int
    stamps : (str or None, float)
        Column of the time and seconds per unit.
    rate : float
        As the head tells it, Hz.
    """
    steps = np.zeros((0, 2), np.int64)
    if stamps[0] is not None:
        found = _steps(source, stamps, rows, rate)
        if found is None:
            return None
        rate, steps = found
    bad, flat = _missing(source, columns, rows)
    found = runs(rows, steps, bad)
    if not len(found):
        return None
    return Grid(rate, found, tuple(steps[:, 1].tolist()), int(bad.size), flat, steps)


def runs(rows, steps, bad):
    """Runs (k, 3) of rows without a missing sample: start, stop, slot of the first.

    Parameters
    ----------
    rows : int
    steps : ndarray of int, shape (g, 2)
        Row after each gap, and samples missing before it.
    bad : ndarray of int
        Rows without a number.
    """
    cuts = np.unique(np.concatenate([[0], steps[:, 0], bad, bad + 1]))
    cuts = cuts[cuts < rows]
    stops = np.append(cuts[1:], rows)
    lost = np.concatenate([[0], np.cumsum(steps[:, 1])])
    slots = cuts + lost[np.searchsorted(steps[:, 0], cuts, side="right")]
    good = ~np.isin(cuts, bad)
    return np.column_stack([cuts, stops, slots])[good]


def _steps(source, stamps, rows, rate):
    """(rate, (k, 2) of row and samples missing before it) from stamps that lie on an even grid."""
    name, unit = stamps
    first = last = None
    wide = []
    at = 0
    for t in source.pieces(name, 0, rows):
        if t.dtype.kind == "f" and not np.isfinite(t).all():
            return None
        if first is None:
            first = t[0]
        t = (t - first).astype(float) * unit
        step = np.diff(t, prepend=t[0] - 1 / rate if last is None else last)
        if not (step > 0).all():
            return None
        for i in np.flatnonzero(step * rate > 1.5):
            wide.append((at + int(i), float(step[i])))
        at, last = at + t.size, float(t[-1])
    if len(wide) > 100_000:
        return None
    for _ in range(4):
        lost = [round(step * rate) - 1 for _, step in wide]
        rate = (rows - 1 + sum(lost)) / last
    nearest = round(rate)
    near = abs(rate - nearest) * last < max(1e-3 * rate, 0.5)
    if nearest and near and abs(rate / nearest - 1) < 1e-4:
        rate = float(nearest)
    steps = np.array([(row, m) for (row, _), m in zip(wide, lost, strict=True)], np.int64)
    steps = steps.reshape(-1, 2)
    at = 0
    for t in source.pieces(name, 0, rows):  # to a hundredth of a sample, as for short records
        k = np.arange(at, at + t.size)
        inside = np.searchsorted(steps[:, 0], k, side="right")
        slot = k + np.concatenate([[0], np.cumsum(steps[:, 1])])[inside]
        off = (t - first).astype(float) * unit * rate - slot
        if np.abs(off - np.median(off)).max() > 1e-2 or abs(np.median(off)) > 0.4:
            return None
        at += t.size
    return rate, steps


def _missing(source, columns, rows):
    """Rows without a number in some channel, and places of the columns that never change."""
    bad, flat = [], []
    for place, column in enumerate(columns):
        at, low, high = 0, np.inf, -np.inf
        for x in source.pieces(column.name, 0, rows):
            if x.dtype.kind == "f" and not np.isfinite(x.sum()):
                infinite = np.flatnonzero(np.isinf(x))
                if infinite.size:
                    raise InputError(
                        f"{source.path}, `{column.name}`, row {at + int(infinite[0]) + 1}: the "
                        "value is infinite; leave the field empty (NaN) where a sample is missing."
                    )
                gone = np.flatnonzero(np.isnan(x))
                bad.append(at + gone)
                x, size = x[~np.isnan(x)], x.size
            else:
                size = x.size
            if x.size:
                low, high = min(low, x.min()), max(high, x.max())
            at += size
        if not high > low:
            flat.append(place)
    return (np.unique(np.concatenate(bad)) if bad else np.zeros(0, np.int64)), tuple(flat)
