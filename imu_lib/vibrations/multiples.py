"""Multiples of a frequency as samples show them: below half the rate where they are, beyond it
where the sampling folds them to.
"""

from __future__ import annotations

from imu_lib.timing import folded
from imu_lib.vibrations import mains
from imu_lib.vibrations.sources import Source
from imu_lib.vibrations.transforms import Transforms

#: (fundamental in Hz or 0, its sources).
Family = tuple[float, list[Source]]
#: Width over frequency up to which a source is a line.
NARROW = 0.04
#: Multiples of the mains that are looked for where the sampling folds them to, and probability of
#: as many lines there by chance.
FOLDED, BY_CHANCE = 20, 1e-2


def off_by(s: Source, transforms: Transforms) -> float:
    """How far off the frequency of a source may be, Hz."""
    return max(3 * s.frequency_sd, 0.5 * s.bandwidth, 1.5 / transforms.duration)


def is_line(s: Source) -> bool:
    return s.bandwidth <= NARROW * s.frequency


def together(a: Source, b: Source) -> bool:
    """Whether two sources share a channel and the time."""
    if not set(a.channels) & set(b.channels):
        return False
    if a.whole or b.whole:
        return a.whole and b.whole
    (start, stop), (first, last) = ((s.spans[0][0], s.spans[-1][1]) for s in (a, b))
    shared = min(stop, last) - max(start, first)
    return shared > 0.6 * max(stop - start, last - first)


def order_of(s: Source, f0: float, transforms: Transforms) -> int:
    """Which multiple of `f0` Hz a source is, as the sampling shows it."""
    plain = max(int(round(s.frequency / f0)), 1)
    if abs(s.frequency - plain * f0) < 0.1 * f0:
        return plain
    order = _folded_order(s, f0, off_by(s, transforms), transforms)
    return plain if order is None else order[0]


def _folded_order(
    s: Source, f0: float, slack: float, transforms: Transforms
) -> tuple[int, float] | None:
    """The multiple of `f0` Hz, known to `slack` Hz, that the sampling folds to a source, and the
    probability that one of those looked for lies as near by chance; None where none does.
    """
    fs, chance, found = transforms.fs, 0.0, None
    for order in range(2, FOLDED + 1):
        if order * f0 < 0.5 * fs:
            continue
        near = off_by(s, transforms) + order * slack
        chance += 2 * near / (0.5 * fs)
        if found is None and abs(folded(order * f0, fs) - s.frequency) < near:
            found = order
    return None if found is None else (found, min(chance, 1.0))


def multiple(
    order: int, f0: float, family: list[Source], transforms: Transforms
) -> tuple[float, float]:
    """Band in Hz of a multiple of `f0` Hz, as the sampling shows it: what wanders by so many Hz
    does so by a multiple of that there.
    """
    best = max(family, key=lambda s: s.gain)
    own = order_of(best, f0, transforms)
    if best.bandwidth > 0 and len(family) == 1:
        low, high = order * best.place.low / own, order * best.place.high / own
    else:
        half = max(2.0 / transforms.duration, max(s.bandwidth for s in family))
        low, high = order * f0 - half, order * f0 + half
    ends = sorted(folded(f, transforms.fs) for f in (low, high))
    return ends[0], ends[1]


def with_folds(families: list[Family], transforms: Transforms) -> list[Family]:
    """The families, that of the mains with its multiples beyond half the sampling rate."""
    out = list(families)
    for f0, family in families:
        first = family[0]
        if (f0, family) not in out or not (is_line(first) and first.whole):
            continue
        if len(family) == 1:
            start = mains.unfolded(first.frequency, transforms.fs)
            slack = off_by(first, transforms)
        else:
            start = f0 if f0 and mains.of_mains(f0, len(family)) else None
            slack = 0.0
        if start is None:
            continue
        if len(family) > 1:
            slack = min(off_by(s, transforms) / order_of(s, f0, transforms) for s in family)
        more: list[tuple[list[Source], float]] = []
        chance = 1.0
        for _, single in out:
            (s, *rest) = single
            if rest or single is family or not is_line(s) or not together(first, s):
                continue
            found = _folded_order(s, start, slack, transforms)
            if found is not None:
                more.append(([s], found[1]))
                chance *= found[1]
        if more and chance < BY_CHANCE:
            gone = [family, *(single for single, _ in more)]
            out = [f for f in out if f[1] not in gone]
            out.append((start, [s for some in gone for s in some]))
    return out
