"""What an outage comparison found: errors of each model over the windows, what its filter says of
itself, and which model is ahead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.arrays import Array

from . import measurement
from .filter import Solution
from .free import GROUPS
from .innovations import LOST
from .statistics import improvement, paired


@dataclass(frozen=True)
class ModelOutages:
    """One model over all windows.

    states : number of filter states; time (w,) of (k,) s since the window's start; error :
    {"full_gnss": (w,) of (k,), "reference": ...}, m;
    sigma : (w,) of (k,), m, the filter's own horizontal standard deviation (root of the sum of the
    two variances); path (w,) of (k, 3), positions; solution : the full-GNSS run
    """

    states: int
    time: tuple
    error: dict
    sigma: tuple
    path: tuple
    solution: Solution
    added: tuple = ()

    def max(self, against="full_gnss"):
        """Maximum horizontal error of each window, (w,), m; NaN where the reference is not fit."""
        return np.array([e.max() for e in self.error[against]])

    @property
    def nis(self):
        """Mean normalised innovation squared of the fixes used, per degree of freedom: 1 where the
        filter is honest.
        """
        i = self.solution.innovations
        return float(i.nis.sum() / max(i.freedom.sum(), 1))

    @property
    def rejected(self):
        """Share of the positions and of the velocities that failed the innovation test."""
        i, out = self.solution.innovations, {}
        for k, part in enumerate(("position", "velocity")):
            offered = np.isfinite(i.value[:, 3 * k]).sum()
            failed = (i.bits & (measurement.REJECTED_POSITION << k)) > 0
            out[part] = float(failed.sum() / offered) if offered else 0.0
        return out

    @property
    def lost(self):
        """Whether it rejects so many fixes that its errors say nothing of its error model."""
        return max(self.rejected.values()) > LOST

    def over_predicted(self, against="full_gnss"):
        """Root mean square of the errors at the windows' ends over the predicted sigma: 1 where the
        filter is honest.
        """
        ratio = np.array([e[-1] / s[-1] for e, s in zip(self.error[against], self.sigma)])
        ratio = ratio[np.isfinite(ratio)]
        return float(np.sqrt(np.mean(ratio**2))) if ratio.size else float("nan")

    def mean(self, against="full_gnss"):
        """Mean horizontal error of each window, (w,), m."""
        return np.array([e.mean() for e in self.error[against]])


@dataclass(frozen=True)
class OutageStudy:
    """The comparison: windows, models by name (ModelOutages), notes."""

    windows: tuple
    models: dict
    notes: tuple = ()

    @property
    def against(self):
        """What errors are taken against: "full_gnss", and "reference" where the drive has one."""
        return tuple(next(iter(self.models.values())).error)

    def errors(self, name: str, *, what: str = "max", against: str = "full_gnss") -> Array:
        """Maximum or mean error of a model in each window, (w,), m."""
        return getattr(self.models[name], what)(against)

    def improvement(self, better, worse, *, how, what="max", against="full_gnss"):
        """See `statistics.improvement`, per cent."""
        return improvement(
            self.errors(better, what=what, against=against),
            self.errors(worse, what=what, against=against),
            how=how,
        )

    @property
    def ranked(self):
        """Names of the models that follow the fixes."""
        return tuple(n for n, m in self.models.items() if not m.lost)

    def paired(self, *, what="max", against="full_gnss"):
        """All pairs of models that follow the fixes, the best (smallest mean log error) first, on
        the windows that can be scored.
        """
        errors = {n: self.errors(n, what=what, against=against) for n in self.ranked}
        good = np.isfinite(list(errors.values())).all(axis=0) if errors else np.zeros(0, bool)
        if good.sum() < 2:
            return ()
        errors = {n: e[good] for n, e in errors.items()}
        order = sorted(errors, key=lambda n: np.log(np.maximum(errors[n], 1e-3)).mean())
        return tuple(
            paired(errors[a], errors[b], (a, b))
            for i, a in enumerate(order)
            for b in order[i + 1 :]
        )

    @property
    def scored_against(self):
        """ "reference" where at least half of the windows can be scored against it, else
        "full_gnss".
        """
        if "reference" not in self.against:
            return "full_gnss"
        errors = self.errors(next(iter(self.models)), against="reference")
        return "reference" if np.isfinite(errors).mean() >= 0.5 else "full_gnss"

    def to_json(self):
        """The content of `imu-lib outages --json`: errors horizontal, m."""
        against = self.scored_against
        return {
            "windows": [
                {"start": w.start, "duration": w.duration, "mean_speed": w.mean_speed}
                for w in self.windows
            ],
            "models": {name: self._of(name, against) for name in self.models},
            "paired": [p.to_json() for p in self.paired(against=against)],
            "paired_against": against,
            "notes": list(self.notes),
        }

    def estimates(self, name):
        """What a model estimated of the drive: name of the state -> value and sd at the end."""
        return {
            state: {"value": value, "sd": sd}
            for state, (value, sd) in self.models[name].solution.estimates().items()
            if state.split(" ")[0] in GROUPS
        }

    def _of(self, name, against):
        model = self.models[name]
        return {
            "states": model.states,
            "states_added": list(model.added),
            "against": {
                a: {"max": model.max(a).tolist(), "mean": model.mean(a).tolist()}
                for a in model.error
            },
            "predicted_sigma": [float(s[-1]) for s in model.sigma],
            "error_over_predicted": model.over_predicted(against),
            "nis": model.nis,
            "rejected": model.rejected,
            "ranked": not model.lost,
            "estimates": self.estimates(name),
        }
