"""Which effects the innovations ask for: the best subset of the linear ones, by penalised
likelihood.

Every subset of effects is a small system of equations (`regression`): all subsets of up to three
effects are tried, then one is added or exchanged at a time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array

from . import columns, regression

if TYPE_CHECKING:
    from .regression import Regression

PER_PARAMETER = 1.5  # nats; chance alone gains 0.5 each
PER_EFFECT = 5.0  # nats: about eighteen effects are tried at once


def ridges(reg: Regression, kept: Sequence[str]) -> dict[tuple[str, str], str]:
    """{(effect, rival): axis}: of those held, what a bias and a scale factor of one axis would
    make up for in each other if they were free.
    """
    out: dict[tuple[str, str], str] = {}
    for bias, scale in regression.PAIRS:
        names = columns.ALL[bias].effect, columns.ALL[scale].effect
        if not set(names) & set(kept):
            continue
        free = [i for e in dict.fromkeys((*kept, *names)) for i in columns.GROUPS[e]]
        index = np.array([i for i in free if reg.information[i, i] > 0.0])
        x, cov, _ = reg.solved(index)
        if scale in index[regression.cancelling(index, x, cov)]:
            axis = columns.ALL[bias].component[-1]
            out |= {pair: axis for pair in (names, names[::-1]) if pair[0] in kept}
    return out


#: Effects that are one ridge on many drives: what is said of one is said with the other free.
RIDGES = {"lever_arm": ("gnss_time_offset",), "gnss_time_offset": ("lever_arm",)}


def seen(reg: Regression, kept: Sequence[str], effect: str) -> tuple[Array, Array, Array]:
    """(values, standard deviations by the likelihood, and those of an interval) of an effect's
    columns beside what is held, and beside what may be taken for it.
    """
    free = dict.fromkeys((*kept, effect, *RIDGES.get(effect, ())))
    index = [i for e in free for i in columns.GROUPS[e]]
    x, cov, _ = reg.solve(index)
    part = [index.index(i) for i in columns.GROUPS[effect]]
    return x[part], np.sqrt(np.diag(cov))[part], reg.sd(index)[part]


def score_of(reg: Regression, effects: Sequence[str]) -> float:
    """Penalised gain of a set of effects, nats."""
    return float(scores_of(reg, [effects])[0])


def scores_of(reg: Regression, sets: Sequence[Sequence[str]]) -> Array:
    """Penalised gains of sets of effects, nats."""
    seen = [[i for i in _columns(effects) if reg.seen[i]] for effects in sets]
    return reg.gains(seen) - [price(reg, effects) for effects in sets]


def price(reg: Regression, effects: Sequence[str]) -> float:
    """What a set of effects has to gain, nats: parameters that the drive does not show cost
    nothing.
    """
    counted = np.count_nonzero(reg.counted[_columns(effects)])
    return PER_PARAMETER * counted + PER_EFFECT * len(effects)


def _columns(effects: Sequence[str]) -> list[int]:
    """Column numbers of a set of effects."""
    return [i for effect in effects for i in columns.GROUPS[effect]]


def best(
    reg: Regression, candidates: Sequence[str], most: int = 8
) -> tuple[tuple[str, ...], float]:
    """The best set of effects and its penalised gain."""
    kept: tuple[str, ...] = ()
    top = 0.0
    first = scores_of(reg, [(e,) for e in candidates])
    promising = [e for e, value in zip(candidates, first) if value > -PER_EFFECT - 20.0]
    for size in range(1, min(most, 3) + 1):
        kept, top = _better(reg, list(combinations(promising, size)), kept, top)
    while len(kept) < most:
        moves = [kept + (e,) for e in promising if e not in kept]
        moves += [tuple(k for k in kept if k != out) for out in kept]
        moves += [
            tuple(k for k in kept if k != out) + (e,)
            for out in kept
            for e in promising
            if e not in kept
        ]
        before = top
        kept, top = _better(reg, moves, kept, top + 1e-6)
        if top <= before + 1e-6:
            return kept, before
    return kept, top


def _better(
    reg: Regression, sets: Sequence[tuple[str, ...]], kept: tuple[str, ...], top: float
) -> tuple[tuple[str, ...], float]:
    """The best of some sets of effects and its penalised gain, or what is held with `top` nats."""
    values = scores_of(reg, sets)
    if not len(values) or values.max() <= top:
        return kept, top
    return sets[int(np.argmax(values))], float(values.max())


def confidence(
    reg: Regression,
    kept: Sequence[str],
    candidates: Sequence[str],
    apart: Mapping[tuple[str, str], float],
) -> dict[str, tuple[float, str, float, dict[str, float]]]:
    """For each kept effect: how sure its name is, and what comes second ("nothing" included).

    apart : {(effect, rival): nats} that rivals lack on paths of their own, where that was tried
    """
    top = score_of(reg, kept)
    out = {}
    for effect in kept:
        others = tuple(k for k in kept if k != effect)
        rivals = {"nothing": score_of(reg, others)}
        rivals |= {e: score_of(reg, (*others, e)) for e in candidates if e not in kept}
        rivals |= {e: top - lacks for (of, e), lacks in apart.items() if of == effect}
        second = max(rivals, key=rivals.__getitem__)
        weights = {e: float(np.exp(np.clip(v - top, -700, 50))) for e, v in rivals.items()}
        total = 1.0 + sum(weights.values())
        out[effect] = (1.0 / total, second, weights[second] / total, rivals)
    return out
