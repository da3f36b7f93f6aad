"""What a free base may have swallowed: effects that it imitates, so that nothing of them is
missing.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.effects import COMPETITORS, DRIFTS, SPECTRAL
from imu_lib.gap.state import State

#: An effect is swallowed if the base takes this share of the information on its strength, for this
#: share of its shapes.
SWALLOWED, FAMILY = 0.5, 0.25


class FreeBase:
    """A fitted base, and what it can imitate by a change of its own parameters, to first order in
    an effect's strength.
    """

    def __init__(self, state: State) -> None:
        self.data, self.terms = state.data, state.base
        fit, problem = state.fit, state.problem
        self.low_pass, self.expected = fit.low_pass, fit.expected
        self._weight = np.sqrt(problem.stats.count / 2) / self.expected
        own = sum(len(slot.names) for slot in state.base_slots)
        self._basis, _ = np.linalg.qr((problem.slopes(fit.vector)[1][:own] * self._weight).T)
        self.fast = self.data.layout.spectrum([t for t in fit.terms if t.fast], fit.low_pass)

    def has(self, kind: type) -> bool:
        """Whether it has a process of that kind."""
        return any(type(t) is kind for t in self.terms)

    def imitates(self, processes: Iterable[Any]) -> bool:
        """Whether it has the spectra of so many of these noises."""
        taken = []
        for process in processes:
            v = self.data.layout.shape(process, self.low_pass) * self._weight
            taken.append(np.sum((self._basis.T @ v) ** 2) > SWALLOWED * np.sum(v**2))
        return bool(np.mean(taken) > FAMILY)

    def hides(self, columns: Array) -> bool:
        """Whether so many of these drifts (cosine coefficients, a column each) would show if its
        slow noises were not there.
        """
        if not np.all(self.fast > 0):
            return False
        seen, alone = (
            np.sum(columns**2 / self.data.stats.slow_ordinates(v)[:, None], axis=0)
            for v in (self.expected, self.fast)
        )
        return bool(np.mean(seen < SWALLOWED * alone) > FAMILY)


def absorbed(state: State) -> list[str]:
    """Names of the effects that the free base of `state` has, or may have swallowed."""
    base = FreeBase(state)
    names = [t.name for t in base.terms]
    others = [e for e in COMPETITORS if e not in SPECTRAL and e not in DRIFTS]
    names += [e.name for e in (*SPECTRAL, *DRIFTS, *others) if e.absorbed(base)]
    found = {item.name for item in state.items}
    return [n for n in dict.fromkeys(names) if n not in found]
