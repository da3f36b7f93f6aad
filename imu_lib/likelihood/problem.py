"""A model some of whose parameters are free, as a function of a vector of logarithms.

The expected density is linear in the squared amplitudes, one spectral shape per process, so the
derivative by an amplitude is the shape itself; times and frequencies are differentiated
numerically. Amplitudes may sink to a floor that no statistic notices: that is zero, and its
logarithm stays finite.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.processes import LowPass, Process, Stage, Sum
from imu_lib.processes.base import POSITIVE_KINDS

from .evaluate import LEAST_LEFT, gaussian, with_extra
from .layout import of_strength_one
from .regressors import Regressors
from .slot import FILTER, Slot
from .statistics import Statistics

#: Share of the density below which a process is zero.
ZERO = 1e-9
#: Half the step of the numerical derivatives.
STEP = 1e-3


@dataclass(frozen=True)
class Free:
    """One unknown: its label, its slot's index, its name, whether it scales its process, log
    bounds.
    """

    label: str
    index: int
    name: str
    amplitude: bool
    low: float
    high: float


class Problem:
    """The likelihood of a model as a function of its free parameters.

    Parameters
    ----------
    stats : Statistics
    terms : sequence of Process
        The noises; those of a slot at the values to start from (or None where `start` is not
        asked for).
    slots : sequence of Slot
        The free parameters.
    low_pass : LowPass, optional
        The filter behind the terms.
    rest : float
        One-sided density of white noise that is no process (rounding, spikes).
    extra : ndarray, shape (b,), optional
        Density that the electronics add in the bands; it may be negative.
    regressors : Regressors, optional
        Mean shapes whose amplitudes are solved for.
    """

    def __init__(
        self,
        stats: Statistics,
        terms: Any,
        slots: Any = (),
        *,
        low_pass: LowPass | None = None,
        rest: float = 0.0,
        extra: Array | None = None,
        regressors: Regressors | None = None,
    ):
        self.stats, self.layout = stats, stats.layout
        self.terms, self.slots = tuple(terms), tuple(slots)
        self.low_pass, self.rest, self.extra = low_pass, rest, extra
        self.stages: tuple[Stage, ...] = ()
        self.regressors = regressors
        self.scale = float(np.sum(stats.power) / np.sum(stats.count))
        self.free: tuple[Free, ...] = ()
        self._at: dict[int, tuple[Slot, slice, int | None]] = {}
        self._held: tuple[Any, Array] | None = None
        self._units: dict[Any, tuple[float, Array]] = {}  # what `_row` scales, by shape
        for slot in self.slots:
            process = self.process(slot.index)
            strength, first = slot.strength(process), len(self.free)
            self._at[slot.index] = slot, slice(first, first + len(slot.names)), strength
            self.free += tuple(
                Free(label, slot.index, name, k == strength, low, high)
                for k, (label, name, low, high) in enumerate(
                    zip(slot.labels or slot.names, slot.names, slot.low, slot.high)
                )
            )
        self.low = np.array([u.low for u in self.free])
        self.high = np.array([u.high for u in self.free])

    @classmethod
    def of(cls, stats: Statistics, template: Sum, regressors: Regressors | None = None) -> Problem:
        """Of a sum whose unknown parameters are None."""
        stages = tuple(s for s in template.stages if not isinstance(s, LowPass))
        problem = cls(
            stats,
            template.terms,
            slots_of(template, stats.rate, stats.duration),
            low_pass=template.low_pass,
            rest=2 * sum(s.added_variance(stats.rate) for s in stages) / stats.rate,
            regressors=regressors,
        )
        problem.stages = stages
        return problem

    # -- the model at a vector -------------------------------------------------------------------
    def start(self) -> Array:
        """The vector of the terms as they came."""
        parts = [s.read(self.process(s.index)) for s in self.slots]
        return np.concatenate(parts) if parts else np.zeros(0)

    def unpack(self, theta: Array) -> tuple[tuple[Process, ...], LowPass | None]:
        """Terms and filter at a vector."""
        terms = list(self.terms)
        for index, (slot, at, _) in self._at.items():
            if index != FILTER:
                terms[index] = slot.write(terms[index], theta[at])
        return tuple(terms), self._filter(theta)

    def model(self, theta: Array) -> Sum:
        """The model at a vector as a sum."""
        terms, low_pass = self.unpack(theta)
        return Sum(terms, self.stages + (() if low_pass is None else (low_pass,)))

    def process(self, index: int) -> Any:
        """The process of a slot as it came."""
        return self.low_pass if index == FILTER else self.terms[index]

    # -- its spectrum ----------------------------------------------------------------------------
    def _filter(self, theta: Array) -> LowPass | None:
        if FILTER not in self._at or self.low_pass is None:
            return self.low_pass
        slot, at, _ = self._at[FILTER]
        return slot.write(self.low_pass, theta[at])

    def _row(self, index: int, vector: Array, low_pass: LowPass | None) -> Array:
        """One free term: its amplitude scales a shape that is remembered."""
        slot, _, strength = self._at[index]
        vector, square = np.array(vector, float), 1.0
        if strength is not None:
            square, vector[strength] = float(np.exp(2 * vector[strength])), 0.0
        key = index, vector.tobytes(), low_pass
        if key not in self._units:
            unit, own = of_strength_one(slot.write(self.terms[index], vector))
            self._units[key] = own, self.layout.shape(unit, low_pass)
        own, shape = self._units[key]
        return square * own * shape

    def _of_held(self, low_pass: LowPass | None) -> Array:
        """Density of the terms that are held."""
        if self._held is None or self._held[0] != low_pass:
            held = [t for i, t in enumerate(self.terms) if i not in self._at]
            self._held = low_pass, self.layout.spectrum(held, low_pass)
        return self._held[1]

    def _rows(self, theta: Array, low_pass: LowPass | None) -> tuple[dict[int, Array], Array]:
        """Density of each free term behind the filter by its index, and of the rest."""
        rows = {
            i: self._row(i, theta[at], low_pass)
            for i, (_, at, _) in self._at.items()
            if i != FILTER
        }
        return rows, self._of_held(low_pass) + self.rest

    def parts(self, theta: Array) -> tuple[dict[int, Array], Array]:
        """Expected density of each free term by its index, (b,), and of the rest."""
        rows, rest = self._rows(theta, self._filter(theta))
        return rows, rest if self.extra is None else rest + self.extra

    def _whole(self, rows: dict[int, Array], rest: Array) -> Array:
        bare = sum(rows.values(), rest)
        return bare if self.extra is None else with_extra(bare, self.extra)

    def density(self, theta: Array) -> Array:
        """Expected mean ordinate of each band, (b,)."""
        return self._whole(*self._rows(theta, self._filter(theta)))

    def slopes(self, theta: Array) -> tuple[Array, Array]:
        """Density (b,) and its derivatives by theta, (k, b)."""
        theta = np.asarray(theta, float)
        low_pass = self._filter(theta)
        rows, rest = self._rows(theta, low_pass)
        out = np.empty((len(self.free), len(rest)))
        for k, unknown in enumerate(self.free):
            if unknown.amplitude:
                out[k] = 2 * rows[unknown.index]
                continue
            ends = []
            for sign in (1, -1):
                moved = theta.copy()
                moved[k] += sign * STEP
                if unknown.index == FILTER:
                    other, held = self._rows(moved, self._filter(moved))
                    ends.append(sum(other.values(), held))
                else:
                    at = self._at[unknown.index][1]
                    ends.append(self._row(unknown.index, moved[at], low_pass))
            out[k] = (ends[0] - ends[1]) / (2 * STEP)
        expected = self._whole(rows, rest)
        if self.extra is not None:  # where rounding leaves its least share, that share moves
            bare = sum(rows.values(), rest)
            out[:, bare + self.extra < LEAST_LEFT * bare] *= LEAST_LEFT
        return expected, out

    # -- its likelihood --------------------------------------------------------------------------
    def remaining(self, expected: Array) -> Array:
        """Ordinate sums without the mean shapes, (b,), under an expected density."""
        power = self.stats.power
        if self.regressors is not None:
            power = self.regressors.remaining(power, self.regressors.solve(expected)[0])
        return power

    def of_density(self, expected: Array) -> float:
        """Log-likelihood of an expected density, mean shapes solved for."""
        return float(gaussian(self.stats, expected, self.remaining(expected)))

    def loglike(self, theta: Array) -> float:
        """Log-likelihood at theta."""
        return self.of_density(self.density(theta))

    def score(self, theta: Array) -> tuple[float, Array, Array]:
        """Log-likelihood, its gradient (k,) and the Fisher information (k, k)."""
        expected, slopes = self.slopes(theta)
        power, count = self.remaining(expected), self.stats.count
        g = slopes / expected
        return (
            float(gaussian(self.stats, expected, power)),
            0.5 * g @ (power / expected - count),
            0.5 * (g * count) @ g.T,
        )

    def floors(self, theta: Array) -> Array:
        """Log-amplitude of each unknown below which its process is zero, (k,); bounds for the
        others.
        """
        theta = np.asarray(theta, float)
        low_pass = self._filter(theta)
        rows, rest = self._rows(theta, low_pass)
        total = np.maximum(self._whole(rows, rest), 1e-300)
        low = self.low.copy()
        for k, u in enumerate(self.free):
            if u.amplitude:
                one = theta[self._at[u.index][1]].copy()
                one[self._at[u.index][2]] = 0.0
                row = self._row(u.index, one, low_pass)
                low[k] = max(low[k], 0.5 * np.log(ZERO / np.max(row / total)))
        return low


def slots_of(template: Sum, fs: float, duration: float) -> list[Slot]:
    """The unknown parameters of a template, process by process."""
    unknown: dict[int, list[tuple[str, str, float, float]]] = {}
    for label, index, name in template.labels():
        process = list(template)[index]
        kind = next(p for p in process.parameters if p.name == name)
        if getattr(process, name) is not None:
            continue
        if isinstance(process, LowPass):
            if name == "cutoff" and process.tunable:
                top = 0.49 * (process.rate or fs)
                unknown.setdefault(FILTER, []).append((label, name, np.log(fs / 500), np.log(top)))
            continue
        if kind.optional:
            continue
        if kind.kind not in POSITIVE_KINDS:
            raise ValueError(
                f"`model`: the parameter `{name}` of {process.name} can't be fitted by the "
                "likelihood: give it a value"
            )
        bounds = {
            "amplitude": (-80.0, 80.0),
            "time": (np.log(2 / fs), np.log(duration)),
        }.get(kind.kind, (np.log(0.5 / duration), np.log(fs / 2)))
        unknown.setdefault(index, []).append((label, name, *bounds))
    out = []
    for index, rows in unknown.items():
        labels, names, low, high = zip(*rows)
        out.append(Slot(index, names, low, high, labels=labels))
    return out
