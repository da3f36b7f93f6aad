"""How much a further noise would gain, without a fit."""

from __future__ import annotations

import numpy as np

from imu_lib.gap import fast
from imu_lib.gap.engine import Data, measured

#: Strengths that are tried, in units of what the record could just show.
STRENGTHS = np.geomspace(0.5, 3e5, 34)


def power_without_drifts(state) -> np.ndarray:
    """The binned periodogram, slow bins included, without what the fit knows of drifts."""
    if not len(state.fit.beta):
        return state.cleaned.power
    return Data(state.cleaned.x - state.drift, state.cleaned.fs).power


class Screening:
    """The spectrum of a fitted state against the record's, and what its free parameters may move."""

    def __init__(self, state):
        data, fit = state.cleaned, state.fit
        self.layout, self.fs, self.low_pass = data.layout, data.fs, fit.low_pass
        self.power = power_without_drifts(state)
        self.s0 = measured(fast.spectrum(fit.terms, fit.low_pass, self.layout, self.fs), data.extra)
        self.free = self._directions(state) if len(fit.vector) else None

    def gain(self, process) -> tuple[float, float]:
        """Best gain over the strength of a noise of that shape: (gain, squared strength)."""
        shape = fast.spectrum([process], self.low_pass, self.layout, self.fs)
        gain, strength = self._ladder(shape)
        if self.free is None:
            return gain, strength
        # what is there already may stand in for what is missing
        return max((gain, strength), self._score(shape))

    def _directions(self, state) -> np.ndarray:
        """Relative change of the spectrum in all bins by each free parameter of the state,
        orthonormal under the bins' weights.
        """
        like, x, h, rows = state.likelihood, state.fit.vector, 2e-3, []
        for i in range(len(x)):
            step = h * (np.arange(len(x)) == i)
            up, down = (
                fast.spectrum(*like.unpack(x + sign * step), self.layout, self.fs)
                for sign in (1, -1)
            )
            rows.append((up - down) / (2 * h) / self.s0)
        return np.linalg.qr((np.array(rows) * np.sqrt(self.layout.nu / 2)).T)[0]

    def _ladder(self, shape):
        s0, nu, power = self.s0, self.layout.nu, self.power
        u = STRENGTHS / np.sqrt(0.5 * np.sum(nu * (shape / s0) ** 2))
        s1 = s0[None, :] + u[:, None] * shape[None, :]
        gain = -0.5 * np.sum(nu * (np.log(s1 / s0) + power / s1 - power / s0), axis=1)
        j = int(np.argmax(gain))
        return float(gain[j]), float(u[j])

    def _score(self, shape):
        """Gain of a little of an added shape with the free parameters found anew beside it, to
        second order.
        """
        weight = np.sqrt(self.layout.nu / 2)
        h = weight * shape / self.s0
        h = h - self.free @ (self.free.T @ h)
        g, information = h @ (weight * (self.power / self.s0 - 1.0)), max(h @ h, 1e-300)
        return (float(0.5 * g * g / information), float(g / information)) if g > 0 else (0.0, 0.0)
