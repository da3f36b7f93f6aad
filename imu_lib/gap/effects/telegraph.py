"""Burst noise: a bias that jumps between two levels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib import words
from imu_lib.arrays import Array
from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.state import MIN_EVIDENCE, MIN_LIKELIHOOD, TEMPER, State
from imu_lib.gap.two_levels import TwoLevels, decoded
from imu_lib.likelihood.evaluate import with_extra
from imu_lib.likelihood.evidence import Maximum, amplitude_occam
from imu_lib.likelihood.slot import FILTER
from imu_lib.processes import GaussMarkov2
from imu_lib.processes import Telegraph as Process

from .competitor import Competitor, factor, process_parameters
from .gauss_markov import GaussMarkov
from .step import Step as Jump

if TYPE_CHECKING:
    from imu_lib.gap.absorbed import FreeBase
    from imu_lib.gap.rounds import Weighed

#: Samples that a level has to last on average to be told from noise.
MIN_DWELL_SAMPLES = 50
#: Gain of the noises in whose place two levels are tried, starts that are tried, and flips from
#: which on there are two levels.
MIN_GAIN, MAX_STARTS, MIN_FLIPS = 8.0, 6, 2.5
#: Rounds in which the drift beside levels that are given is found.
HELD = 4
#: Times that levels in the place of a noise of a free base are decoded again, beside what the other
#: noises are without them.
AGAIN = 2
#: Share of the levels' variance that the noise leaves unknown, up to which the samples show them.
MOST_UNKNOWN = 0.1
#: Flips up to which a path may as well be so many steps, and flips whose times are told.
FEW, TOLD = 12, 6
#: The noise of their spectrum.
TWIN = GaussMarkov()


class Telegraph(Competitor):
    name = "telegraph"
    cause = (
        "A single trap or contact switches between two states at random (burst or popcorn noise)."
    )
    domain = "distribution"
    process = Process

    def candidates_beside(self, state: State, weighed: list[Weighed]) -> list[Candidate]:
        """Two levels instead of the noises that would otherwise explain a red spectrum, and beside
        a noise that has taken them for its own: one whose parameters an item has set free.
        """
        free = set(state.assembly.slots) - {s.index for s in state.base_slots} - {FILTER}
        noises = [state.fit.terms[place] for place in free]
        beside = [c for term in noises for c in self.candidates_in_place(state, term, state)]
        return self._decoded(state, self._starts(state, weighed)) + beside

    def candidates_in_place(self, state: State, term: Any, without: State) -> list[Candidate]:
        if not isinstance(term, (TWIN.process, GaussMarkov2)):
            return []
        start = Process(amplitude=2 * term.sigma, rate=0.5 / term.correlation_time)
        held = self._held(without)
        item = self._item(without, decoded(*self._seen(state, start, term)), held)
        for _ in range(AGAIN):
            if item is None:
                return []
            fit = without.plus(item).fit
            again = decoded(*self._seen(without, item.process, fit=fit))
            item = self._item(without, again, held)
        return [] if item is None else [item]

    def path(self, state: State, term: Any) -> Array | None:
        """The levels of a telegraph that is given, where the samples show them, and show no other
        distance or rate: of few flips the spectrum is that of a Gauss-Markov process in name only,
        and each of them would be a step.
        """
        if not isinstance(term, Process):
            return None
        seen = self._seen(state, term, term)
        found = decoded(*seen, rounds=HELD, fixed=True)
        if found is None or found.beyond < MIN_EVIDENCE or found.unknown > MOST_UNKNOWN:
            return None
        free = decoded(*seen)
        like = free is not None and free.differs(term, state.data.duration) < MIN_LIKELIHOOD
        return found.signal if like else None

    def _decoded(self, state: State, starts: list[tuple[float, float]]) -> list[Candidate]:
        if not starts:
            return []
        held, out = self._held(state), []
        for amplitude, rate in starts[:MAX_STARTS]:
            start = Process(
                amplitude=float(amplitude), rate=float(max(rate, 2 / state.data.duration))
            )
            out.append(self._item(state, decoded(*self._seen(state, start)), held))
        return [item for item in out if item is not None]

    def _item(self, state: State, found: TwoLevels | None, held: float = 0.0) -> Candidate | None:
        """The candidate, where there are flips enough and few enough to be two levels."""
        if found is None or found.flips < MIN_FLIPS:
            return None
        if found.process.rate > state.data.fs / MIN_DWELL_SAMPLES:
            return None
        if found.flips < FEW and found.own_levels() > MIN_EVIDENCE:
            return None  # it does not come back to where it was
        return self._candidate(state, found, held)

    def alike(self, state: State, candidate: Candidate) -> dict[str, float]:
        """So many steps, where there are few flips: what has come back to its levels k times does
        so again with a probability of (k + 1) / (k + 2) (Laplace's rule of succession), and few
        dwells show no distribution of their lengths.
        """
        found = candidate.note["found"]
        if found.flips >= FEW:
            return {}
        back = max(round(found.flips) - 1, 0)
        odds = 1.0 / (1.0 + np.exp(-found.own_levels() / TEMPER))
        return {Jump.name: float(max(1.0 / (back + 2), odds))}

    @staticmethod
    def _seen(
        state: State, start: Process, but: Any = None, fit: Maximum | None = None
    ) -> tuple[Array, float, Process, float, Callable[[int, float], Array] | None]:
        """What two levels are decoded from: the record, what to start from, the white noise, and
        the gain of the other noises of the `fit` - the state's own where none is given - without
        `but` one of them.
        """
        data, fit = state.cleaned, fit or state.fit
        # before a filter, which takes nothing from a dwell
        s = with_extra(data.layout.spectrum(fit.terms), data.extra)
        s = s[data.layout.slow :]
        density = min(float(np.median(s[:40])), float(np.median(s))) / 2
        drift = [t for t in fit.terms if t.memory > 0 and t is not but]

        def gain(size: int, rate: float) -> Array:
            f = np.maximum(np.arange(size // 2 + 1), 0.5) * rate / size
            d = sum(t.psd(f) for t in drift)
            return d / (d + 2 * density)

        x = data.x - state.drift if len(fit.beta) else data.x
        return x, data.fs, start, density, gain if drift else None

    def _held(self, state: State) -> float:
        """Log-likelihood by which the given model with two levels of its own is better than
        `state`: with them as with those that are found, it is beyond that of their spectrum.
        """
        bare, out = state.with_items(()), -np.inf
        for term in bare.base:
            if isinstance(term, Process):
                found = decoded(*self._seen(bare, term, term), rounds=HELD, fixed=True)
                out = max(out, -np.inf if found is None else bare.ll + found.beyond)
        return max(out - state.ll, 0.0)

    @staticmethod
    def _starts(state: State, weighed: list[Weighed]) -> list[tuple[float, float]]:
        """(amplitude, rate) to start from, after the red noises that promise most."""
        starts, data = [], state.cleaned
        for w in weighed:
            if w.gain < MIN_GAIN or not w.item.effect.red:
                continue
            levels = w.item.effect.levels(w.state, w.item)
            if levels is not None:
                if max(rate for _, rate in levels) <= data.fs / MIN_DWELL_SAMPLES:
                    starts += levels
            elif len(starts) < 4:
                sd = data.slow_sd
                starts += [(2 * sd, 10 / data.duration), (2 * sd, 60 / data.duration)]
        return starts

    def _candidate(self, state: State, found: TwoLevels, held: float) -> Candidate:
        """What the two levels gain beyond the Gauss-Markov noise of their spectrum is no affair of
        the likelihood of the record without them; those of the given model gain `held`.
        """
        process = found.process
        occam = amplitude_occam(process.amplitude / found.sd)
        occam += np.log(np.sqrt(2 * np.pi / max(found.flips, 1)) / np.log(1e4))
        bare = Candidate(self, process, signal=found.signal, note={"found": found})
        trial, alike = state.plus(bare), state.holding(process.twin)
        return replace(
            bare,
            bonus=float(alike.evidence - trial.evidence + found.beyond + occam - held),
            gain=float(alike.ll - trial.ll + found.beyond - held),
        )

    def absorbed(self, base: FreeBase) -> bool:
        # two levels whose dwells are lost in the noise have the spectrum of a Gauss-Markov process
        return base.has(TWIN.process) or TWIN.absorbed(base)

    def enter(self, assembly: Assembly, candidate: Candidate) -> None:
        """It is taken out of the record instead."""

    def settled(self, state: State, candidate: Candidate) -> Candidate:
        return candidate

    def grow(
        self,
        state: State,
        candidate: Candidate,
        fit: Maximum,
        terms: list[Any],
        stages: dict[str, Any],
    ) -> None:
        terms.append(candidate.process)

    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        p, found = candidate.process, candidate.note["found"]
        amplitude, rate = found.spread()
        return process_parameters(p), {
            "amplitude": factor(p.amplitude, amplitude),
            "rate": factor(p.rate, rate),
        }

    def where(self, state: State, candidate: Candidate) -> str:
        found = candidate.note["found"]
        text = (
            f"distribution of the bias: two levels, about {found.flips:.0f} flips in "
            f"{state.data.duration:.0f} s"
        )
        at = [f"{first * found.step:.0f}" for first, _ in found.dwells()[1:]]
        return f"{text}, at {words.listed(at)} s" if 0 < len(at) <= TOLD else text


EFFECTS = (Telegraph(),)
