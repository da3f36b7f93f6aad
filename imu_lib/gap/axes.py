"""Three axes of one sensor have one design: what it is on one of them speaks for the others."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, logit

from imu_lib.gap import effects, reliability
from imu_lib.gap.steps import Step

if TYPE_CHECKING:
    from imu_lib.gap.channel import ChannelResult

#: Relative difference up to which two axes have the same value.
ALIKE = 0.05
#: Axes that have to agree.
LEAST = 2


def agreed(results: dict[str, ChannelResult]) -> dict[str, ChannelResult]:
    """Results by channel in which the names of what is of the sensor's design (its grid, its
    filter) are as sure as all axes that agree on it make them; what was weighed among rivals only
    where nothing is left unexplained.

    An axis tells two names apart by its own noise; that the axes have one converter and one filter
    adds up what each of them says. Names that were counted are as sure as the surest.
    """
    out = dict(results)
    for kind in ("gyro", "accel"):
        own = [c for c in results if c.startswith(kind)]
        named = [
            (c, s)
            for c in own
            for s in results[c].steps
            if _of_design(s) and (s.detected or results[c].unexplained is None)
        ]
        for group in _groups(named):
            for c, s in group:
                one = replace(s, confidence=_sure([o for _, o in group], s))
                if one.confidence >= reliability.PLAIN:
                    one = replace(one, indistinguishable=[])
                out[c] = replace(out[c], steps=[one if o is s else o for o in out[c].steps])
    return out


def _of_design(step: Step) -> bool:
    return bool(effects.CATALOGUE[step.effect].of_design)


def _groups(named: list[tuple[str, Step]]) -> list[list[tuple[str, Step]]]:
    """Steps of one effect whose values agree, two or more together."""
    out: list[list[tuple[str, Step]]] = []
    for c, s in named:
        near = next((g for g in out if _alike(g[0][1], s) and c not in {o for o, _ in g}), None)
        if near is None:
            out.append([(c, s)])
        else:
            near.append((c, s))
    return [g for g in out if len(g) >= LEAST]


def _alike(a: Step, b: Step) -> bool:
    key = effects.CATALOGUE[a.effect].of_design
    if a.effect != b.effect:
        return False
    own, other = a.parameters.get(key), b.parameters.get(key)
    return bool(own and other and abs(own / other - 1.0) < ALIKE)


def _sure(group: list[Step], step: Step) -> float:
    """Confidence of one of the steps of a group."""
    if step.detected:
        return max(s.confidence for s in group)
    weights = [reliability.weight(s.confidence) for s in group if not s.detected]
    together = float(expit(np.sum(logit(np.clip(weights, 1e-9, 1.0 - 1e-9)))))
    return max(step.confidence, reliability.calibrated(together))
