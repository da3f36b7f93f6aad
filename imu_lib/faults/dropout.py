"""Rows that are no measurement: a constant (0, the end of the range, a code) in place of the
reading, on all channels or some, periodic or not; and NaN.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import poisson

from imu_lib import timing
from imu_lib.faults.chance import (
    IMPROBABLE,
    MANIFOLD,
    Levels,
    coincidences,
    period_of,
    run_starts,
)
from imu_lib.faults.finding import Finding, named, seconds

#: Robust standard deviations from the usual values beyond which a value cannot be the sensor's.
FOREIGN = 8.0
#: log p below which a value that cannot be the sensor's comes again by no chance.
IMPROBABLE_FOREIGN = -12.0
#: Levels within the scatter around one that is too common, at the least.
FINE_GRID = 8
#: Steps of a coarse grid within which a level has its neighbours: printed digits round them apart.
NEXT = 1.25
#: Runs that a value must come in, where it is not 0.
LEAST_RUNS = 3
MEANS = (
    "These rows are no measurements: left in, they look like clipping, spikes and, where they are "
    "periodic, a comb of lines. They are taken as missing."
)


def find(channels: dict, time: np.ndarray, levels: dict[str, Levels]) -> list[Finding]:
    """Drop-outs to a constant.

    Parameters
    ----------
    channels : dict of ndarray, shape (n,)
    time : ndarray, shape (n,), s
    levels : dict of Levels
    """
    names = [c for c in channels if len(levels[c].values) > 1]
    if not names:
        return []
    atoms = [_atoms(channels[c], levels[c]) for c in names]
    found, done = [], np.zeros((len(names), len(time)), bool)
    for which in ("standing", "zero"):
        events = np.stack([np.isin(levels[c].index, a[which]) for c, a in zip(names, atoms)])
        events &= ~done
        chance = np.array([a[f"{which}_chance"] for a in atoms])
        for members, rows, expected in coincidences(events, chance):
            if len(members) == 1:
                row = members[0]
                rows = rows[np.isin(levels[names[row]].index[rows], atoms[row]["alone"])]
                if not len(rows):
                    continue
            if which == "zero" and len(members) > 1:
                members = _with_others(members, rows, [channels[c] == 0 for c in names])
            done[np.ix_(members, rows)] = True
            found.append(_finding([names[m] for m in members], rows, expected, channels, time))
    return found


def _with_others(members, rows, same) -> list[int]:
    """The channels, and those that show the same in nearly all of the rows and seldom elsewhere."""
    more = [
        c
        for c, e in enumerate(same)
        if c not in members and e[rows].mean() > max(0.95, 1.5 * e.mean())
    ]
    return sorted([*members, *more])


def _atoms(x: np.ndarray, levels: Levels) -> dict:
    """Levels at which a channel stands suspiciously often (`standing`), and 0 where it is not one
    of them (`zero`); their probabilities by chance; those suspicious on this channel `alone`.
    """
    values, runs = levels.values, levels.runs
    total = runs.sum()
    middle = np.median(x[~np.isnan(x)][:: max(1, len(x) // 50_000)])
    step = _coarse_step(levels)
    spread = max(_spread(x), step)
    around = max(spread, NEXT * step)
    foreign = np.abs(values - middle) > FOREIGN * spread
    usual = np.flatnonzero(~foreign)
    often = np.flatnonzero(runs >= LEAST_RUNS)
    if len(often) > 200:  # a grid: only what stands out of its neighbours at all
        mass = np.sort(runs)
        usual_mass = mass[np.searchsorted(np.cumsum(mass), 0.5 * total)]
        common = often[(runs[often] > usual_mass) & ~foreign[often]]
        common = common[np.argsort(-runs[common], kind="stable")[:200]]
        strange_ones = often[foreign[often]]
        most = np.argsort(-runs[strange_ones], kind="stable")[:200]
        often = np.r_[common, strange_ones[most]]
    atoms, alone, chance, others_chance = [], [], 0.0, 0.0
    plain: list[int] = []
    away = np.abs(values - middle)
    count = np.bincount(levels.index[levels.index >= 0], minlength=len(values))
    for at in often[count[often] < 0.5 * count.sum()]:  # what most samples have is the reading
        p = levels.value_chance(int(at), around)
        improbable = IMPROBABLE
        if foreign[at]:
            # knocks and heavy tails, too, make strange values; those nearer to the usual ones more
            # often, and seldom the same one again and again
            nearer = runs[(away >= 0.5 * away[at]) & (away < away[at])]
            others = float(nearer.mean()) if len(nearer) else 0.0
            p, improbable = max(others, 0.02) / total, IMPROBABLE_FOREIGN
        standing = runs[at] > MANIFOLD * p * total and (
            poisson.logsf(runs[at] - 1, p * total) < improbable
        )
        # a clipped signal piles up at the end of what it usually does
        clipped = len(usual) > 0 and at in (usual[0], usual[-1])
        if not foreign[at] and values[at] != 0:  # only a fine grid tells that a level is too common
            near = np.searchsorted(values, (values[at] - spread, values[at] + spread))
            standing = standing and near[1] - near[0] >= FINE_GRID
        if standing and foreign[at] and not _leaps(x, levels.index == at, FOREIGN / 2 * spread):
            continue
        if standing and not (clipped and values[at] != 0):
            if values[at] != 0:
                atoms.append(int(at))
                chance += p
            if foreign[at] or not clipped and not _dead_zone(levels, int(at), spread):
                alone.append(int(at))
    own = [i for i in dict.fromkeys([*atoms, *alone]) if not foreign[i]]
    if _coarser(values[own]):  # a part of the record has a coarser grid
        atoms, alone = ([i for i in some if foreign[i]] for some in (atoms, alone))
    zero = np.flatnonzero(values == 0)
    if len(zero) and count[zero[0]] < 0.5 * count.sum():
        p = levels.value_chance(int(zero[0]), around)
        # a common value of the sensor itself is no sign of anything
        if p < 0.2:
            plain.append(int(zero[0]))
            others_chance = p
    return {
        "standing": atoms,
        "standing_chance": chance,
        "zero": plain,
        "zero_chance": others_chance,
        "alone": alone,
    }


def _coarser(values: np.ndarray) -> bool:
    """Whether values that are too common are the levels of a grid."""
    if len(values) < 3:
        return False
    gap = np.diff(np.sort(values))
    steps = gap / gap.min()
    return bool(np.all(np.abs(steps - np.rint(steps)) < 0.02) and np.rint(steps).max() < 3)


def _leaps(x: np.ndarray, mask: np.ndarray, least: float) -> bool:
    """Whether the value is left and reached by leaps: where a sensor is turned, its neighbours are
    near it.
    """
    start, stop = timing.runs(mask)
    value = x[start[0]]
    near = np.r_[x[start[start > 0] - 1], x[stop[stop < len(x)]]]
    near = near[~np.isnan(near)]
    return len(near) == 0 or float(np.mean(np.abs(near - value) > least)) > 0.7


def _spread(x: np.ndarray) -> float:
    """Robust scatter about the local level, never below the grid's own."""
    good = x[~np.isnan(x)]
    good = good[: len(good) - len(good) % 2]
    some = good[:: max(1, len(good) // 100_000)]
    wide = 1.4826 * float(np.median(np.abs(some - np.median(some))))
    return wide if wide > 0 else float(np.std(some)) or 1.0


def _coarse_step(levels: Levels) -> float:
    """The least distance of the commonest levels: below it the grid hides any scatter."""
    common = np.sort(levels.values[np.argsort(-levels.runs, kind="stable")[:5]])
    return float(np.diff(common).min()) if levels.coarse and len(common) > 1 else 0.0


def _dead_zone(levels: Levels, at: int, spread: float) -> bool:
    """Whether values close to a level are missing for it: the sensor rounds them to it."""
    v, value = levels.values, levels.values[at]
    runs = levels.runs
    inner = (np.abs(v - value) < 0.25 * spread) & (v != value)
    outer = (np.abs(v - value) >= 0.25 * spread) & (np.abs(v - value) < 0.75 * spread)
    return bool(runs[inner].sum() < 0.25 * runs[outer].sum())


def _finding(names, rows, expected, channels, time) -> Finding:
    n = len(time)
    starts = run_starts(rows)
    period = period_of(starts)
    values = [_common(channels[c][rows]) for c in names]
    value = values[0] if len(set(values)) == 1 else values
    fraction = len(rows) / n
    said = "0" if value == 0 else "one value" if isinstance(value, list) else f"{value:.6g}"
    place = (
        f"at {seconds(time[rows[0]])} s"
        if len(starts) == 1
        else f"from {seconds(time[rows[0]])} to {seconds(time[rows[-1]])} s"
    )
    how = f", one in {period}" if period else ""
    count = f"{len(rows):,} row{'s' if len(rows) > 1 else ''}"
    return Finding(
        "dropout",
        tuple(names),
        float(time[rows[0]]),
        float(time[min(rows[-1] + 1, n - 1)]),
        {"fraction": fraction, "value": value, "period": period, "channels": list(names)},
        {"rows": len(rows), "runs": len(starts), "expected_by_chance": expected},
        f"{count} ({100 * fraction:.2g} %{how}) stand{'s' * (len(rows) == 1)} at {said} on "
        f"{named(tuple(names))}, {place}: drop-outs of the transport or the driver.",
        MEANS,
        rows,
    )


def _common(x: np.ndarray) -> float:
    values, count = np.unique(x, return_counts=True)
    return float(values[np.argmax(count)])


def missing(channels: dict, time: np.ndarray) -> list[Finding]:
    """Values that are NaN, channels with the same rows together."""
    lost = {c: np.isnan(x) for c, x in channels.items()}
    groups: list[tuple[list[str], np.ndarray]] = []
    for name, mask in lost.items():
        if not mask.any():
            continue
        home = next((g for g in groups if np.array_equal(g[1], mask)), None)
        if home is None:
            groups.append(([name], mask))
        else:
            home[0].append(name)
    found = []
    for names, mask in groups:
        rows = np.flatnonzero(mask)
        starts = run_starts(rows)
        period = period_of(starts)
        fraction = len(rows) / len(time)
        how = f", one in {period}" if period else ""
        found.append(
            Finding(
                "dropout",
                tuple(names),
                float(time[rows[0]]),
                float(time[min(rows[-1] + 1, len(time) - 1)]),
                {"fraction": fraction, "value": None, "period": period, "channels": names},
                {"rows": len(rows), "runs": len(starts), "expected_by_chance": 0.0},
                f"{len(rows):,} value{'s are' if len(rows) > 1 else ' is'} missing (NaN) on "
                f"{named(tuple(names))}, {100 * fraction:.2g} %{how}, the first at "
                f"{seconds(time[rows[0]])} s.",
                "They are taken as missing.",
                rows,
            )
        )
    return found
