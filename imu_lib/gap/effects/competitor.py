"""Effects that compete for the model of a channel on one likelihood, and what each answers."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.data import SCREEN
from imu_lib.gap.state import State
from imu_lib.likelihood.evidence import AMPLITUDE_WIDTH, TIME_WIDTH, Maximum
from imu_lib.likelihood.slot import Slot
from imu_lib.processes import Process
from imu_lib.processes.base import SHORT

from .base import Effect

if TYPE_CHECKING:
    from imu_lib.gap.absorbed import FreeBase
    from imu_lib.gap.rounds import Weighed

Z95 = 1.959963984540054
#: Confidence at the most in a noise that is strongest near half the sampling rate, beside a filter:
#: one that is not of the catalogue's kinds leaves a slope there. Where effects were put into
#: recorded signals, none of six such names was of what had been put in (Laplace's rule of
#: succession).
SLOPE_BESIDE_FILTER = (0 + 1) / (6 + 2)
#: The same of a noise that forgets within `SHORT` s: of four beside a Chebyshev filter, which the
#: catalogue does not have, none was there.
QUICK_BESIDE_FILTER = (0 + 1) / (4 + 2)
#: And without one: exponential smoothing, or a filter with something beside it, leaves the same
#: spectrum.
QUICK_ALONE = 0.5


class Competitor(Effect):
    """An effect that enters the model of a channel: by default as a further noise."""

    level = "noise"
    #: At most one in a channel.
    single: ClassVar[bool] = False
    #: Whether a red spectrum may come of it, as of two levels.
    red: ClassVar[bool] = False
    #: Whether it happens once, at a time of its own, where a slow noise is always there.
    event: ClassVar[bool] = False
    #: Whether it stands for little else: others are tried only where they promise more than what is
    #: simple.
    simple: ClassVar[bool] = True
    #: Whether it fills one place of the spectrum, where a tone that wanders would be on average.
    local: ClassVar[bool] = False

    # -- candidates ------------------------------------------------------------------------------
    def candidates(self, state: State) -> list[Candidate]:
        """Where the effect may be in what `state` leaves."""
        return []

    def candidates_beside(self, state: State, weighed: list[Weighed]) -> list[Candidate]:
        """Where it may be in place of other candidates, which have been weighed."""
        return []

    def candidates_in_place(self, state: State, term: Any, without: State) -> list[Candidate]:
        """Where it may be in place of a `term` of a fitted base; `without` is the base that has all
        others.
        """
        return []

    def path(self, state: State, term: Any) -> np.ndarray | None:
        """What the samples show that a `term` of the given model does in them, shape (n,); None
        where they know no more of it than its spectrum.
        """
        return None

    def levels(self, state: State, candidate: Candidate) -> list[tuple[float, float]] | None:
        """(distance, flips per second) of two levels that would look like the fitted candidate;
        None where it does not say how often they flip.
        """
        return None

    def worth_fitting(self, candidate: Candidate, state: State, best: float, simple: float) -> bool:
        """Whether it is fitted, where the best candidate promises `best` and the best simple one
        `simple`.
        """
        return candidate.screen >= 0.35 * best - 15

    # -- in a model ------------------------------------------------------------------------------
    def enter(self, assembly: Assembly, candidate: Candidate) -> None:
        """Make the candidate part of a model."""
        assembly.add_noise(candidate)

    def settled(self, state: State, candidate: Candidate) -> Candidate:
        """The candidate at its fitted values, so that a further fit starts there."""
        return replace(candidate, process=state.fit.terms[state.assembly.place(candidate)])

    def log_prior(self, state: State, candidate: Candidate) -> float:
        """Log evidence of the fitted candidate beyond the likelihood and the widths of its slot."""
        return 0.0

    def against(self, rival: Weighed) -> float:
        """Log evidence that is held against a weighed `rival` in its place."""
        return 0.0

    def absorbed(self, base: FreeBase) -> bool:
        """Whether a free base (`absorbed.FreeBase`) may have swallowed it."""
        return False

    def grow(
        self,
        state: State,
        candidate: Candidate,
        fit: Maximum,
        terms: list[Any],
        stages: dict[str, Any],
    ) -> None:
        """Add to the terms and stages of the grown model what `fit.terms` does not hold."""

    # -- in the report ---------------------------------------------------------------------------
    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        """Parameters and 95 % intervals of the fitted candidate."""
        fit, place = state.fit, state.assembly.place(candidate)
        process = fit.terms[place]
        slot, at = state.free(place)
        intervals = {}
        for name in slot.names:
            if hasattr(process, name):
                g = slot.relative(process, name)
                sd = np.sqrt(max(g @ fit.cov[np.ix_(at, at)] @ g, 0.0))
                intervals[name] = factor(getattr(process, name), sd)
        return process_parameters(process), intervals

    def alike(self, state: State, candidate: Candidate) -> dict[str, float]:
        """Effects that would look the same, and their share of the confidence."""
        return {}

    def where(self, state: State, candidate: Candidate) -> str:
        """Where the model without the candidate and the record disagree, in physical words."""
        without = state.without(candidate)
        a, b = state.fit.expected, without.fit.expected
        decibel = 10 * np.log10(np.maximum(a, 1e-300) / np.maximum(b, 1e-300))
        weight = np.abs(decibel)
        f = state.data.layout.frequency[weight > 0.5 * weight.max()]
        peak = decibel[int(np.argmax(weight))]
        side = "above" if peak > 0 else "below"
        text = (
            f"power spectral density between {f.min():.3g} and {f.max():.3g} Hz, "
            f"up to {abs(peak):.2g} dB {side} the simulated level"
        )
        if f.max() < 0.5:
            text += f" (Allan deviation from {0.4 / f.max():.3g} s on)"
        return text


def process_parameters(process: Process) -> dict[str, Any]:
    """Its entry in the model file without the name."""
    return {key: v for key, v in process.to_json().items() if key != "process"}


def factor(value: float, sd: float) -> list[float]:
    """95 % interval of a parameter whose logarithm has the standard deviation `sd`; of one that has
    vanished, and of which the record says nothing, all sizes.
    """
    reach = np.exp(min(Z95 * sd, 60.0))
    return [value / reach, value * reach]


def most_beside_filter(parameters: dict[str, Any], beside: list[Effect]) -> float:
    """Confidence at the most in a noise with a correlation time beside the effects of its channel:
    a quick one stands for a filter, or fills what is left where that has another shape than the
    catalogue's.
    """
    if parameters["correlation_time"] >= SHORT:
        return 1.0
    return QUICK_BESIDE_FILTER if any(e.rolls_off for e in beside) else QUICK_ALONE


def near_record(state: State, candidate: Candidate) -> float:
    """Log prior of a correlation time that nears the record's length: it is not seen, and the same
    noise has a name with one parameter less.
    """
    time = state.fit.terms[state.assembly.place(candidate)].correlation_time
    share = np.log(time / state.data.duration * 12) / np.log(4.0)
    return float(-4.0 * np.clip(share, 0.0, 1.0))


class Spectral(Competitor):
    """A noise that is known by its spectrum: a process added to the sum, its parameters free."""

    process: ClassVar[type[Any]]
    amplitude: ClassVar[str] = "sigma"
    #: Log odds against the effect before the record is seen.
    rarity: ClassVar[float] = 0.0

    def grid(self, fs: float, duration: float) -> list[Any]:
        """Processes of unit strength from whose shapes the best start is chosen, each with its
        amplitude's name.
        """
        raise NotImplementedError

    def slot(self, index: int, fs: float, duration: float) -> Slot:
        """The free parameters of the process at `index`."""
        free = [p for p in self.process.parameters if not p.optional]
        names = tuple(p.name for p in free)
        low = tuple(np.log(1.5 / fs) if p.kind == "time" else -60.0 for p in free)
        high = tuple(np.log(duration / 3) if p.kind == "time" else 30.0 for p in free)
        widths = tuple(TIME_WIDTH if p.kind == "time" else AMPLITUDE_WIDTH for p in free)
        return Slot(index, names, low, high, widths)

    def absorbed(self, base: FreeBase) -> bool:
        return self.beside(base.low_pass, base.data.fs) and base.imitates(
            self.grid(base.data.fs, base.data.duration)
        )

    def candidates(self, state: State) -> list[Candidate]:
        fit, data = state.fit, state.cleaned
        if self.single and any(t.name == self.name for t in fit.terms):
            return []
        if not self.beside(fit.low_pass, data.fs):
            return []
        rows = []
        for process in self.grid(data.fs, data.duration):
            gain, strength = state.screening.gain(process)
            amplitude = getattr(process, self.amplitude) * np.sqrt(strength)
            rows.append((gain, process.with_(**{self.amplitude: amplitude})))
        gain, process = max(rows, key=lambda row: row[0])
        if gain < SCREEN:
            return []
        slot = self.slot(0, data.fs, data.duration)
        return [Candidate(self, process, slot, screen=gain, bonus=-self.rarity)]
