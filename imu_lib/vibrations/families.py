"""Lines that have one cause: whole multiples of one frequency, or many lines that the same channels
feel at the same time.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from imu_lib.vibrations.multiples import (
    Family,
    is_line,
    multiple,
    off_by,
    order_of,
    together,
    with_folds,
)
from imu_lib.vibrations.sources import Source
from imu_lib.vibrations.transforms import Transforms

#: Multiples that are looked for, and how many lines of a comb have to be there.
MULTIPLES, SHARE = 40, 0.5
#: Lines of the same channels from which on they are one finding, multiples or not.
FAMILY_LINES = 4
#: Gain from which on a multiple counts that did not stand out by itself.
WEAK = 6.0
#: Power over its surroundings of a multiple that fills so many ordinates, and gain of a line that
#: wanders from which on its multiples are looked for.
LEAST, MANY, WANDERS = 1.35, 20, 100.0


def grouped(found: list[Source], transforms: Transforms) -> list[Family]:
    """Sources by cause: (fundamental in Hz or 0 where the lines are no multiples, sources)."""
    left, out = sorted(found, key=lambda s: -s.gain), []
    while True:
        comb = _comb(left, transforms)
        if comb is None:
            break
        out.append(comb)
        left = [s for s in left if s not in comb[1]]
    for family, gone in _wandering(left, transforms):
        out.append(family)
        left = [s for s in left if s not in gone]
    for first in left:
        if any(first in family for _, family in out):
            continue
        alike = [
            s
            for s in left
            if is_line(s)
            and is_line(first)
            and s.whole
            and first.whole
            and len(set(s.channels) & set(first.channels)) >= 2
            and not any(s in family for _, family in out)
        ]
        out.append((0.0, alike if len(alike) >= FAMILY_LINES else [first]))
    return _one_cause(with_folds(out, transforms))


def _one_cause(families: list[Family]) -> list[Family]:
    """Families on the same channels, all the time, as one where there are so many lines that each
    of its own would be no cause: the products of two clocks.
    """
    loud = [f for f in families if all(s.whole and s.bandwidth < 0.3 * s.frequency for s in f[1])]
    out = list(families)
    for first in loud:
        same = [f for f in loud if f in out and _alike(f, first)]
        if first in out and len(same) > 2 and sum(len(f[1]) for f in same) > FAMILY_LINES:
            out = [f for f in out if f not in same]
            out.append((0.0, [s for f in same for s in f[1]]))
    return out


def _alike(a: Family, b: Family) -> bool:
    """Whether the strongest lines of two families are felt by much the same channels."""
    x, y = (set(max(f[1], key=lambda s: s.gain).channels) for f in (a, b))
    return len(x & y) >= 2 and len(x & y) > 0.5 * len(x | y)


def _comb(left: list[Source], transforms: Transforms) -> Family | None:
    """The best family of multiples, or None: (fundamental, sources)."""
    lines = [s for s in left if is_line(s)]
    starts = [(s.frequency / k, off_by(s, transforms) / k) for s in lines for k in (1, 2, 3)]
    starts += [
        (abs(a.frequency - b.frequency), off_by(a, transforms) + off_by(b, transforms))
        for a, b in combinations(lines[:12], 2)
    ]
    best: tuple[tuple[int, int], Family] | None = None
    for f0, slack in starts:
        if f0 < 8 * slack or f0 < 8 / transforms.duration:
            continue
        members, orders = _matching(f0, slack, lines, transforms)
        if len(members) < 2 or not all(together(members[0], m) for m in members[1:]):
            continue
        fill, chance = len(members) / max(orders), _chance(members, orders, f0, transforms)
        if fill < SHARE or chance > 1e-2:
            continue
        key = (len(members), -max(orders))
        if best is None or key > best[0]:
            best = (key, (_fitted(members, orders, transforms), members))
    return None if best is None else best[1]


def _matching(
    f0: float, slack: float, lines: list[Source], transforms: Transforms
) -> tuple[list[Source], list[int]]:
    members: list[Source] = []
    orders: list[int] = []
    for s in lines:
        order = int(round(s.frequency / f0))
        if not 1 <= order <= MULTIPLES:
            continue
        near = min(order * slack, 0.1 * f0) + off_by(s, transforms)
        if abs(s.frequency - order * f0) < near and order not in orders:
            members.append(s)
            orders.append(order)
    return members, orders


def _chance(members: list[Source], orders: list[int], f0: float, transforms: Transforms) -> float:
    """How often as many lines elsewhere would lie so close to multiples."""
    out = 1.0
    for s in members[1:]:
        out *= min(1.0, 2 * off_by(s, transforms) / f0 * 4)
    return out * len(members)


def _fitted(members: list[Source], orders: list[int], transforms: Transforms) -> float:
    """The fundamental by least squares."""
    weight = [1.0 / off_by(s, transforms) ** 2 for s in members]
    f = [s.frequency for s in members]
    top = sum(w * k * x for w, k, x in zip(weight, orders, f))
    return float(top / sum(w * k * k for w, k in zip(weight, orders)))


def folds(s: Source, families: list[Family], transforms: Transforms) -> bool:
    """Whether a line is a multiple, between half the sampling rate and all of it, of a family that
    its channels have, as the sampling folds it.
    """
    for f0, family in families:
        if f0 == 0.0 or s in family or not is_line(s) or not together(s, family[0]):
            continue
        order = round((transforms.fs - s.frequency) / f0)
        known = max(round(m.frequency / f0) for m in family)
        slack = off_by(s, transforms) * (1 + order / known)
        if abs(transforms.fs - order * f0 - s.frequency) < min(slack, 0.1 * f0):
            return True
    return False


def _wandering(left: list[Source], transforms: Transforms) -> list[tuple[Family, list[Source]]]:
    """Lines that wander with multiples that do, and the sources in the bands of these: where a
    multiple passes by it seems to come and go.
    """
    out: list[tuple[Family, list[Source]]] = []
    for s in sorted(left, key=lambda s: s.frequency):
        taken = [t for _, gone in out for t in gone]
        if s in taken or not (is_line(s) and s.bandwidth > 0 and s.gain > WANDERS):
            continue
        orders = weak_lines(s.frequency, [s], transforms)
        gone = [s]
        for order in orders:
            low, high = multiple(order, s.frequency, [s], transforms)
            gone += [
                t
                for t in left
                if t not in (*gone, *taken)
                and low - t.bandwidth <= t.frequency <= high + t.bandwidth
                and set(t.channels) & set(s.channels)
            ]
        if len(gone) > 1:
            out.append(((s.frequency, [s]), gone))
    return out


def weak_lines(
    f0: float, family: list[Source], transforms: Transforms
) -> dict[int, dict[str, float]]:
    """Multiples of `f0` that do not stand out by themselves but are there: order -> {channel:
    amplitude}.
    """
    strongest = max(family, key=lambda s: s.gain)
    have = {order_of(s, f0, transforms) for s in family}
    taken = [(s.place.low, s.place.high) for s in family]
    out: dict[int, dict[str, float]] = {}
    missed = 0
    for order in range(1, MULTIPLES + 1):
        f = order * f0
        if f > 0.98 * transforms.fs or missed > 2:
            break
        if 0.49 < f / transforms.fs < 0.51:
            continue
        if order in have:
            missed = 0
            continue
        low, high = multiple(order, f0, family, transforms)
        if any(low <= stop and start <= high for start, stop in taken):
            continue  # a multiple below half the rate is there
        taken.append((low, high))
        a, b = transforms.ordinates(low, high)
        amplitude: dict[str, float] = {}
        gain = 0.0
        for name in strongest.channels:
            z = transforms.z[name][a:b]
            density = transforms.density(name, a, b)
            r = float(np.mean(np.abs(z) ** 2)) * 2 / (transforms.n * transforms.fs) / density
            least = LEAST if b - a > MANY else 1.0  # a slope over many ordinates is no line
            own = (b - a) * (r - 1 - np.log(max(r, 1e-9))) if r > least else 0.0
            gain += own
            excess = max(r - 1, 0.0) * density * (b - a) / transforms.duration
            amplitude[name] = float(np.sqrt(2 * excess))
        missed = 0 if gain > WEAK * np.sqrt(len(amplitude)) else missed + 1
        if not missed:
            out[order] = amplitude
    return out
