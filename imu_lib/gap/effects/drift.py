"""Deterministic drifts: columns of a regression on the slow cosine coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.data import SCREEN, Data
from imu_lib.gap.drifts import Scan
from imu_lib.gap.state import State
from imu_lib.likelihood.evidence import Maximum

from .competitor import Z95, Competitor, process_parameters

if TYPE_CHECKING:
    from imu_lib.gap.absorbed import FreeBase


class Drift(Competitor):
    """A shape whose amplitude is a regression coefficient, perhaps with one shape parameter.

    `sharp` drifts reach into the fast end of the spectrum: where the samples show the edge, the
    record is cleaned of it before it is looked at again.
    """

    domain = "mean"
    amplitude: ClassVar[str] = "amplitude"
    shape: ClassVar[str | None] = None
    sharp: ClassVar[bool] = False
    #: Whether it takes a straight line's part until its shape is its own.
    transient: ClassVar[bool] = False
    #: Fall of the log-likelihood at the ends of the interval of the shape parameter.
    fall: ClassVar[float] = 0.5 * Z95**2

    # -- the shapes ------------------------------------------------------------------------------
    def shapes(self, data: Data) -> list[Any]:
        """Processes of amplitude 1 over the range of the shape parameter; empty where the record
        cannot hold the effect.
        """
        raise NotImplementedError

    def columns(self, processes: Sequence[Any], data: Data) -> np.ndarray:
        """Their cosine coefficients, shape (orders, len(processes))."""
        t, temperature = data.grid_time, data.grid_temperature
        return data.columns(np.column_stack([p.mean(t, temperature) for p in processes]))

    def trials(self, data: Data) -> tuple[list[Any], Array]:
        """The shapes and their columns: one set for all states of a record."""

        def made() -> tuple[list[Any], Array]:
            shapes = self.shapes(data)
            return shapes, self.columns(shapes, data) if shapes else np.zeros((data.orders, 0))

        return data.once(self, made)

    def penalty(self, data: Data, snr: float) -> float:
        """Log of posterior over prior width of the shape parameter at a signal-to-noise ratio."""
        return 0.0

    def bounds(self, data: Data) -> tuple[float, float]:
        """Range of the logarithm of the shape parameter."""
        return 0.0, 0.0

    def around(self, process: Any, data: Data, reach: float, points: int) -> list[Any]:
        """Drifts with shapes up to `reach` grid steps either side of that of `process`."""
        assert self.shape is not None, "what has no shape has none around it"
        low, high = self.bounds(data)
        values = np.exp(
            np.clip(
                np.log(getattr(process, self.shape))
                + np.linspace(-reach, reach, points) * (high - low) / 13,
                low,
                high,
            )
        )
        return [process.with_(**{self.shape: float(v)}) for v in np.unique(values)]

    def upright(self, process: Any) -> Any:
        """The drift whose amplitude is negative as one whose amplitude is positive, where there is
        one.
        """
        return process

    def sharpened(self, process: Any, amplitude: float, state: State) -> tuple[Any, dict[str, Any]]:
        """The process where the samples show it best, and what is noted of that."""
        return process, {}

    # -- the competition -------------------------------------------------------------------------
    def least(self, state: State) -> float:
        """Gain from which on a candidate is fitted."""
        return SCREEN

    def worth_fitting(self, candidate: Candidate, state: State, best: float, simple: float) -> bool:
        return candidate.screen < SCREEN or super().worth_fitting(candidate, state, best, simple)

    def candidates(self, state: State) -> list[Candidate]:
        if self.single and any(c.name == self.name for c in state.items):
            return []
        best = self.best(state, state.scan)
        return [] if best is None else [best]

    def best(self, state: State, scan: Scan) -> Candidate | None:
        """The likeliest shape beside the other columns, by the scan of `drifts.scanner`."""
        data = state.cleaned
        trials, columns = self.trials(data)
        if not trials:
            return None
        gain, _, _ = scan(self, trials, columns)
        j = int(np.argmax(gain))
        if gain[j] < self.least(state):
            return None
        process, note = trials[j], self.noted(gain)
        if self.shape is not None:
            for reach in (1.0, 0.12, 0.015):
                near = self.around(process, data, reach, 25)
                gains, amplitude, _ = scan(self, near)
                i = int(np.argmax(gains))
                process = near[i] if amplitude[i] >= 0 else self.upright(near[i])
            process, seen = self.sharpened(process, float(amplitude[i]), state)
            note |= seen
        column = self.columns([process], data)[:, 0]
        return Candidate(self, process, column=column, screen=float(gain[j]), note=note)

    def noted(self, gain: Array) -> dict[str, Any]:
        """What is noted of the gains of all shapes."""
        return {}

    def profiled(self, candidate: Candidate, scan: Scan, data: Data) -> Candidate:
        """The candidate with the range of its shape parameter noted."""
        assert self.shape is not None, "what has no shape has no range of it"
        trial = self.around(candidate.process, data, 6.0, 241)
        gain, _, _ = scan(self, trial)
        values = np.array([getattr(p, self.shape) for p in trial])
        near = values[gain > gain.max() - self.fall]
        note = {**candidate.note, "profile": [float(near.min()), float(near.max())]}
        return replace(candidate, note=note)

    # -- in a model and in the report ------------------------------------------------------------
    def absorbed(self, base: FreeBase) -> bool:
        if self.sharp:
            return False
        shapes, columns = self.trials(base.data)
        return bool(shapes) and base.hides(columns)

    def enter(self, assembly: Assembly, candidate: Candidate) -> None:
        assembly.add_column(candidate)

    def settled(self, state: State, candidate: Candidate) -> Candidate:
        return candidate

    def log_prior(self, state: State, candidate: Candidate) -> float:
        b, sd = state.amplitude(candidate)
        return self.penalty(state.data, abs(b) / sd)

    def grow(
        self,
        state: State,
        candidate: Candidate,
        fit: Maximum,
        terms: list[Any],
        stages: dict[str, Any],
    ) -> None:
        b = fit.beta[state.assembly.place(candidate)]
        terms.append(candidate.process.with_(**{self.amplitude: float(b)}))

    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        b, sd = state.amplitude(candidate)
        process = candidate.process.with_(**{self.amplitude: b})
        intervals = {self.amplitude: [b - Z95 * sd, b + Z95 * sd]}
        if self.shape is not None and "profile" in candidate.note:
            intervals[self.shape] = candidate.note["profile"]
        return process_parameters(process), intervals
