"""A bias that follows the temperature, perhaps bent, behind a lag or another way down than up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Candidate
from imu_lib.gap.data import SCREEN, Data
from imu_lib.gap.drifts import Scan
from imu_lib.gap.state import State
from imu_lib.processes import Temperature as Process

from .drift import Drift

#: Log odds against a curvature and against a lag; against a play, one in ten of which has its width
#: among those tried in the best third of an octave.
BENT, LOOSE = 6.0, 4.0
#: Shares of the range of the temperature that its play may have.
PLAYS = (0.05, 0.7, 12)
#: The usual reference of datasheets, degC, taken for a bent characteristic that reaches near it.
USUAL, NEAR = 25.0, 10.0


class Temperature(Drift):
    name = "temperature"
    single = True
    cause = (
        "Stress in the package and the temperature coefficients of the electronics move the "
        "bias with the temperature."
    )
    domain = "temperature"
    amplitude = "slope"

    def shapes(self, data: Data) -> list[Any]:
        t = data.grid_temperature
        if t is None or not np.ptp(t) > 0:
            return []
        return [Process(slope=1.0, reference=float(np.mean(t)))]

    def candidates(self, state: State) -> list[Candidate]:
        """As a straight line, and with a curvature, a lag or both; a fitted base may have taken so
        much of it for noise that only the whole shape wins it back.
        """
        if any(c.name == self.name for c in state.items):
            return []
        out, data = super().candidates(state), state.cleaned
        for process in self.shapes(data):
            found = self.bent(process, state.scan, data)
            for best, intervals, odds in [*found, self.hysteresis(process, state.scan, data)]:
                gain = float(state.scan(self, [best])[0][0])
                if gain > SCREEN:
                    column = self.columns([best], data)[:, 0]
                    note = {"intervals": intervals}
                    out.append(
                        Candidate(self, best, column=column, screen=gain, bonus=odds, note=note)
                    )
        return out

    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        parameters, intervals = super().report(state, candidate)
        return parameters, {**intervals, **candidate.note.get("intervals", {})}

    def where(self, state: State, candidate: Candidate) -> str:
        t = state.data.temperature
        assert t is not None, "what follows it is not looked for without it"
        low, high = t.min(), t.max()
        return f"regression on the temperature between {low:.1f} and {high:.1f} degC"

    def bent(
        self, process: Process, scan: Scan, data: Data
    ) -> list[tuple[Process, dict[str, list[float]], float]]:
        """(process, 95 % intervals, log odds against it) with a curvature, with a lag and with
        both, at their best by `scan(effect, processes)`, which fits the amplitude.
        """
        assert data.grid_temperature is not None, "what follows it is not looked for without it"
        middle, sd = process.reference, float(np.std(data.grid_temperature))

        def made(v: tuple[float, float] | Array, curved: bool, lagged: bool) -> Process:
            angle = v[0] if curved else 0.0
            return Process(
                slope=float(np.cos(angle) / sd),
                reference=middle,
                curvature=float(np.sin(angle) / sd**2) if curved else None,
                lag=float(np.exp(v[1])) if lagged else None,
            )

        def gain(v: tuple[float, float] | Array, curved: bool, lagged: bool) -> float:
            return float(scan(self, [made(v, curved, lagged)])[0][0])

        lags = np.log(np.geomspace(0.5 * data.m / data.fs, data.duration / 4, 9))
        out = []
        for curved, lagged in ((True, False), (False, True), (True, True)):
            starts = [
                (a, t)
                for a in (np.linspace(-1.5, 1.5, 9) if curved else (0.0,))
                for t in (lags if lagged else lags[:1])
            ]
            r = minimize(
                lambda v, *kind: -gain(v, *kind),
                max(starts, key=lambda v: gain(v, curved, lagged)),
                args=(curved, lagged),
                method="Nelder-Mead",
                bounds=((-1.57, 1.57), (lags[0], lags[-1])),
                options={"xatol": 1e-3, "fatol": 1e-2, "maxiter": 120},
            )
            found = made(r.x, curved, lagged)
            intervals = self._intervals(r.x, curved, lagged, gain, found)
            found = self._referred(found.with_(slope=1.0), data)
            out.append((found, intervals, -BENT * (curved + lagged)))
        return out

    def hysteresis(
        self, process: Process, scan: Scan, data: Data
    ) -> tuple[Process, dict[str, list[float]], float]:
        """(process, 95 % interval, log odds against it) with the play that gains most."""
        assert data.grid_temperature is not None, "what follows it is not looked for without it"
        span = float(np.ptp(data.grid_temperature))
        plays = span * np.geomspace(*PLAYS)
        gain = scan(self, [process.with_(play=float(p)) for p in plays])[0]
        near = plays[gain > gain.max() - 2.0]
        step = float(plays[1] / plays[0])
        interval = [float(near.min() / step), float(near.max() * step)]
        best = process.with_(play=float(plays[np.argmax(gain)]))
        return best, {"play": interval}, -LOOSE

    @staticmethod
    def _intervals(
        v: Array, curved: bool, lagged: bool, gain: Callable[..., float], found: Process
    ) -> dict[str, list[float]]:
        """95 % intervals of the lag, from the bend of the log-likelihood."""
        if not lagged:
            return {}
        h = 0.05
        up, down = ((v[0], v[1] + s * h) for s in (1, -1))
        curve = 2 * gain(v, curved, lagged) - gain(up, curved, lagged) - gain(down, curved, lagged)
        spread = 1.96 * h / np.sqrt(max(curve, 1e-3))
        return {"lag": [found.lag * np.exp(-spread), found.lag * np.exp(spread)]}

    @staticmethod
    def _referred(process: Process, data: Data) -> Process:
        """The same characteristic with its slope at the usual reference temperature."""
        t = data.grid_temperature
        if process.curvature is None or t is None or not t.min() - NEAR < USUAL < t.max() + NEAR:
            return process
        slope = 1.0 + 2.0 * process.curvature * (USUAL - process.reference)
        if abs(slope) < 1e-6:
            return process
        return Process(
            slope=1.0, reference=USUAL, curvature=process.curvature / slope, lag=process.lag
        )


EFFECTS = (Temperature(),)
