"""Samples that are there more than once: a slow stream held in a fast one, copies in place of lost
samples, a frozen output.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation

from imu_lib.faults.chance import Levels, coincidences, period_of, run_starts
from imu_lib.faults.finding import Finding, named, seconds
from imu_lib.faults.standing import STANDS, frozen_rows, repeats, together

#: Share of repeats from which on a stream may be held all through.
SHARE = 0.3
#: Part of the way from independent to alike at which two channels are held together.
LIFT = 0.3
#: Scatter of the number of copies over their mean up to which they are a slower rate; copies that
#: come at random scatter by more.
REGULAR = 0.42
#: Share of the copies that the longest run holds, from which on channels stand still together.
MOST = 0.5


def find(
    channels: dict, time: np.ndarray, rate: float, levels: dict[str, Levels], blind: np.ndarray
) -> list[Finding]:
    """Held streams, then copies. `blind` (n,) marks rows already known not to be measurements."""
    names = [c for c in channels if len(levels[c].values) > 2]
    if not names:
        return []
    # behind a drop-out nothing can be a copy of it
    out = blind | np.r_[False, blind[:-1]]
    again = {c: repeats(channels[c]) & ~out & ~_at_an_end(levels[c]) for c in names}
    chance = {c: levels[c].repeat_chance() for c in names}
    found, done = [], set()
    for group in _streams(again, chance):
        group += _third_axes(group, again)
        rows = np.logical_and.reduce([again[c] for c in group])
        rare = float(np.prod([chance[c] for c in group])) < 0.02
        item = _held(group, rows, time, rate, whole=len(group) == len(channels), rare=rare)
        if item is not None:
            found.append(item)
            done |= set(group)
    rest = [c for c in names if c not in done]
    frozen = {c: frozen_rows(again[c], chance[c]) for c in rest}
    for group, rows in together(frozen, len(time)):
        expected = float(np.prod([chance[c] for c in group]) * len(rows))
        found.append(_copies(group, rows, expected, time))
        for c in group:
            again[c][rows] = False
            frozen[c] = np.setdiff1d(frozen[c], rows, assume_unique=True)
    for c in rest:
        rows = frozen[c]
        if len(rows) and not _others_too(rows, [again[o] for o in rest if o != c]):
            found.append(_copies([c], rows, float(chance[c] * len(rows)), time))
            again[c][rows] = False
    if rest:
        events = np.stack([again[c] for c in rest])
        p = np.array([chance[c] for c in rest])
        for members, rows, expected in coincidences(events, p):
            item = _copies([rest[m] for m in members], rows, expected, time)
            if item is not None:
                found.append(item)
    return found


def _at_an_end(levels: Levels) -> np.ndarray:
    """Samples at the largest or smallest value: where a signal is clipped, neighbours agree."""
    last = len(levels.values) - 1
    if last < 20:  # on so few levels the ends are common
        return np.zeros(len(levels.index), bool)
    out = np.zeros(len(levels.index), bool)
    for end in (0, last):
        if levels.runs[end] > 3:  # once or twice is noise
            out |= levels.index == end
    return out


def _others_too(rows: np.ndarray, others: list[np.ndarray]) -> bool:
    """Whether another channel repeats in nearly all of the rows: then they are lost, not frozen."""
    return any(o[rows].mean() > 0.9 for o in others)


def _streams(again: dict, chance: dict) -> list[list[str]]:
    """Channels that repeat far beyond chance, those that do so in the same rows together."""
    groups: list[list[str]] = []
    for name in sorted(again, key=lambda c: chance[c]):
        mask = again[name]
        share = mask.mean()
        if share < SHARE or share - chance[name] < 0.5 * share:
            continue
        # all that the one holds the other holds, and what it repeats besides is chance
        home = next((g for g in groups if _alike(again[g[0]], mask)), None)
        groups.append([name]) if home is None else home.append(name)
    return groups


def _third_axes(group: list[str], again: dict) -> list[str]:
    """Axes of a sensor of which two are held, that change only where those do: on a coarse grid a
    reading often equals the one before.
    """
    rows = np.logical_and.reduce([again[c] for c in group])
    kinds = [c[0] for c in group]
    return [
        c
        for c in again
        if c not in group
        and kinds.count(c[0]) == 2
        and again[c][rows].mean() > 0.98
        and (~again[c]).sum() >= 20
    ]


def _alike(rows: np.ndarray, mask: np.ndarray) -> bool:
    """Whether two channels, each repeating by chance now and then, are held together: as many times
    a reading, and one repeats where the other does, far more than if they had nothing in common.
    """
    usual = [float(np.median(np.diff(np.flatnonzero(~m)))) for m in (rows, mask)]
    share = mask.mean()
    together = mask[rows].mean() > share + LIFT * (1 - share)
    return bool(together and abs(usual[0] - usual[1]) < 0.25 * max(usual))


def _held(group, rows, time, rate, *, whole: bool, rare: bool) -> Finding | None:
    starts = np.flatnonzero(~rows)
    length = np.diff(starts)
    if len(length) < 8:
        return None
    # readings that agree by chance make a run twice as long: the usual run tells
    usual = float(np.median(length))
    plain = length if rare or usual < 2 else length[length < 1.6 * usual]
    mean = float(plain.mean())
    if mean < 1.4 or float(plain.std()) > REGULAR * mean or len(plain) < 0.6 * len(length):
        return None
    own = rate / mean
    return Finding(
        "held",
        tuple(group),
        float(time[0]),
        float(time[-1]),
        {"held": True, "length": mean, "rate": own, "channels": list(group)},
        {"repeats": int(rows.sum()), "share": float(rows.mean()), "spread": float(plain.std())},
        f"Each reading of {named(tuple(group))} stands {mean:.3g} times: the sensor gives "
        f"{own:.4g} Hz, the file {rate:.4g} Hz.",
        "Copies are no measurements: noise densities would come out too high by the square root of "
        "their number. "
        + (
            "The rows are thinned to the sensor's own rate."
            if whole
            else "Only the first of each reading is used, at its own rate."
        ),
        np.flatnonzero(rows),
    )


def _copies(names, rows, expected, time) -> Finding | None:
    """Rows that repeat the one before: on several channels a lost sample, on one a frozen
    output.
    """
    n = len(time)
    starts = run_starts(rows)
    longest = int(np.diff(np.r_[np.flatnonzero(np.r_[True, np.diff(rows) > 1]), len(rows)]).max())
    period = period_of(starts)
    fraction = len(rows) / n
    many = len(names) > 1
    where = f"from {seconds(time[rows[0]])} to {seconds(time[rows[-1]])} s"
    how = f", one in {period}" if period else ""
    still = longest >= max(STANDS, MOST * len(rows))
    if many:
        kind = "dropout"
        parameters = {
            "fraction": fraction,
            "held": True,
            "period": period,
            "channels": list(names),
        }
        sentence = (
            f"{len(rows):,} rows ({100 * fraction:.2g} %{how}) repeat the one before on "
            f"{named(tuple(names))}, {where}"
            + (
                f", up to {longest + 1:,} in a row: frozen output."
                if still
                else ": copies in place of samples that were lost."
            )
        )
    else:
        kind = "stuck"
        length = len(rows) / max(1, len(starts))
        parameters = {"fraction": fraction, "length": int(round(length))}
        sentence = (
            f"{names[0]} repeats its value in {len(rows):,} samples ({100 * fraction:.2g} %), "
            f"{where}, up to {longest + 1:,} in a row: frozen output."
        )
    return Finding(
        kind,
        tuple(names),
        float(time[rows[0]]),
        float(time[min(rows[-1] + 1, n - 1)]),
        parameters,
        {
            "rows": len(rows),
            "runs": len(starts),
            "expected_by_chance": expected,
            "longest": longest,
        },
        sentence,
        "Copies are no measurements; they are taken as missing.",
        rows,
    )


def constant(channels: dict, time: np.ndarray) -> list[Finding]:
    """Channels that never change."""
    found = []
    for name, x in channels.items():
        good = x[~np.isnan(x)]
        if len(good) and np.all(good == good[0]):
            found.append(
                Finding(
                    "constant",
                    (name,),
                    float(time[0]),
                    float(time[-1]),
                    {"value": float(good[0])},
                    {"rows": len(x)},
                    f"{name} never changes ({good[0] + 0.0:.6g} in SI units): it is not connected, "
                    "or nothing was written to it.",
                    "The channel says nothing and is left out.",
                )
            )
    return found


def widened(mask: np.ndarray, by: int) -> np.ndarray:
    """A mask with `by` neighbours on each side."""
    return binary_dilation(mask, iterations=by) if by > 0 and mask.any() else mask
