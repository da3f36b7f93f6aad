"""How much a further noise would gain, without a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.arrays import Array

if TYPE_CHECKING:
    from imu_lib.gap.state import State

#: Strengths that are tried, in units of what the record could just show.
STRENGTHS = np.geomspace(0.5, 3e5, 34)


class Screening:
    """The spectrum of a fitted state against the record's, and what its free parameters may
    move.
    """

    def __init__(self, state: State) -> None:
        fit, problem = state.fit, state.problem
        self.layout, self.low_pass, self.count = problem.layout, fit.low_pass, problem.stats.count
        self.power, self.expected = fit.remaining, fit.expected
        self._weight = np.sqrt(self.count / 2)
        self.free = None
        if len(fit.vector):  # what they move, orthonormal under the weights of the bands
            moved = problem.slopes(fit.vector)[1] / self.expected
            self.free = np.linalg.qr((moved * self._weight).T)[0]

    def gain(self, process: Any) -> tuple[float, float]:
        """Best gain over the strength of a noise of that shape: (gain, squared strength)."""
        shape = self.layout.shape(process, self.low_pass)
        gain, strength = self._ladder(shape)
        if self.free is None:
            return gain, strength
        # what is there already may stand in for what is missing
        return max((gain, strength), self._score(shape))

    def _ladder(self, shape: Array) -> tuple[float, float]:
        s0, count, power = self.expected, self.count, self.power
        u = STRENGTHS / np.sqrt(0.5 * np.sum(count * (shape / s0) ** 2))
        s1 = s0[None, :] + u[:, None] * shape[None, :]
        # the ends of a noise of long memory take power off: not more than there is
        s1 = np.where(np.all(s1 > 0, axis=1, keepdims=True), s1, s0)
        gain = -0.5 * np.sum(count * np.log(s1 / s0) + power / s1 - power / s0, axis=1)
        j = int(np.argmax(gain))
        return float(gain[j]), float(u[j])

    def _score(self, shape: Array) -> tuple[float, float]:
        """Gain of a little of an added shape with the free parameters found anew beside it, to
        second order.
        """
        weight, s0 = self._weight, self.expected
        h = weight * shape / s0
        if self.free is not None:
            h = h - self.free @ (self.free.T @ h)
        excess = np.divide(
            self.power / s0 - self.count, 2 * weight, out=np.zeros_like(s0), where=weight > 0
        )
        g, information = h @ excess, max(h @ h, 1e-300)
        return (float(0.5 * g * g / information), float(g / information)) if g > 0 else (0.0, 0.0)
