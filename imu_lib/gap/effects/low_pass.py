"""A low-pass filter in the sensor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.candidate import Assembly, Candidate
from imu_lib.gap.data import SCREEN, Data
from imu_lib.gap.state import State
from imu_lib.likelihood.evidence import AMPLITUDE_WIDTH, Maximum
from imu_lib.likelihood.layout import Images, Layout
from imu_lib.likelihood.slot import FILTER, Slot
from imu_lib.processes import Autoregressive, Process, ReadOutNoise, WhiteNoise
from imu_lib.processes import LowPass as Stage

from .competitor import Competitor, factor, process_parameters
from .parameter_change import elsewhere

if TYPE_CHECKING:
    from imu_lib.gap.rounds import Weighed

#: Gain in log-likelihood from which on a filter is tried with a floor in its stop band, bands that
#: tell of one, and how far below the strongest ones it has to be.
FLOORED, WIDTH, DOWN = 10.0, 9, 10.0
#: Filters of different kinds that are fitted at the most.
MOST_KINDS = 5
#: Share of the spectrum at its weakest below which a free white noise has vanished, and the log
#: evidence that this is held against: a sampled Gauss-Markov process has the spectrum of white
#: noise behind exponential smoothing to the last digit, and no sensor is without white noise.
VANISHED, BARE = 0.02, 3.0


class LowPass(Competitor):
    name = "low_pass"
    of_design = "cutoff"
    cause = (
        "The sensor filters its output, with a moving average or an analogue or digital "
        "filter of some order."
    )
    domain = "psd"
    simple = False
    rolls_off = True

    def filters(self, fs: float) -> list[Stage]:
        """Filters from whose shapes the best start is chosen."""
        moving = [Stage(taps=k, rate=fs) for k in (*range(2, 13), 15, 16, 20, 24, 32, 48, 64)]
        # white noise averaged over ten times as many taps at ten times the rate is the same behind
        # the sampling, and over less than a sampling interval it stays white
        inner = [
            Stage(taps=k, rate=10 * fs) for k in (*range(11, 64), *range(64, 120, 4)) if k % 10
        ]
        decimators = [
            Stage(taps=k, order=p, rate=rate)
            for p in (2, 3)
            for rate, widths in ((fs, range(2, 9)), (10 * fs, range(6, 48)))
            for k in widths
        ]
        cutoffs = np.geomspace(0.01, 0.47, 22) * fs
        kinds = ({"smoothing": 1}, *({"order": k} for k in (1, 2, 3, 4, 6, 8)))
        return (
            moving
            + inner
            + decimators
            + [
                Stage(**kind, cutoff=float(c), rate=rate)
                for rate in (fs, 10 * fs)
                for kind in kinds
                for c in cutoffs
            ]
        )

    def slot(self, fs: float) -> Slot:
        """The cutoff of a filter of given order."""
        return Slot(
            FILTER, ("cutoff",), (np.log(0.003 * fs),), (np.log(0.495 * fs),), (np.log(100.0),)
        )

    def candidates(self, state: State) -> list[Candidate]:
        if state.fit.low_pass is not None:
            return []
        data, s0 = state.cleaned, state.fit.expected
        power, count = state.fit.remaining, state.problem.stats.count
        stages, gains = _gains(self, data.layout, data.fs)

        def gained(floor: float) -> Array:
            s = np.maximum((s0 - data.extra) * gains + data.extra + floor, 1e-9 * s0)
            return np.asarray(0.5 * np.sum(count * np.log(s0 / s) + power / s0 - power / s, axis=1))

        gain, floor = gained(0.0), _floor(power, count, data)
        raised = np.zeros(len(gain), bool)
        if floor > 0.0:
            above = gained(floor)
            raised = above > gain + FLOORED
            gain = np.where(raised, above, gain)
        out: list[Candidate] = []
        kinds = set()
        for i in np.argsort(-gain, kind="stable"):
            stage = stages[i]
            kind = (stage.order, stage.smoothing, stage.rate, bool(stage.taps))
            if gain[i] < SCREEN or len(out) == MOST_KINDS:
                break
            if kind in kinds or not all(_behind(t, stage, data.fs) for t in state.fit.terms):
                continue
            kinds.add(kind)
            slot = self.slot(data.fs) if stage.tunable else None
            # a moving average is one of some eighty, several in a row are of a hundred, a filter is
            # one of seven kinds at one of two rates
            rarity = np.log(100.0 if stage.order else 80.0) if stage.taps else np.log(14.0)
            note = {"N": float(np.sqrt(floor / 2.0))} if raised[i] else {}
            out.append(
                Candidate(self, stage, slot, screen=float(gain[i]), bonus=-rarity, note=note)
            )
        return out

    def enter(self, assembly: Assembly, candidate: Candidate) -> None:
        if candidate.note:
            place = len(assembly.terms)
            assembly.slots[place] = Slot(place, ("N",), (-60.0,), (30.0,), (AMPLITUDE_WIDTH,))
            assembly.terms.append(ReadOutNoise(**candidate.note))
        assembly.set_filter(candidate)

    def settled(self, state: State, candidate: Candidate) -> Candidate:
        note = {"N": _behind_it(state.fit.terms).N} if candidate.note else {}
        return replace(candidate, process=state.fit.low_pass, note=note)

    def where(self, state: State, candidate: Candidate) -> str:
        text = super().where(state, candidate)
        if candidate.note:
            text += f"; behind it a floor of white noise, N {_behind_it(state.fit.terms).N:.2g}"
        return text

    def against(self, rival: Weighed) -> float:
        """A rival that needs the white noise to vanish."""
        state = rival.state
        weakest = np.min(state.fit.expected)
        free = [state.fit.terms[slot.index] for slot in state.base_slots]
        vanished = any(
            isinstance(t, WhiteNoise) and 2.0 * t.N**2 < VANISHED * weakest for t in free
        )
        return BARE if vanished else 0.0

    def grow(
        self,
        state: State,
        candidate: Candidate,
        fit: Maximum,
        terms: list[Any],
        stages: dict[str, Any],
    ) -> None:
        stages[self.name] = fit.low_pass

    def report(self, state: State, candidate: Candidate) -> tuple[dict[str, Any], dict[str, Any]]:
        process, intervals = state.fit.low_pass, {}
        if candidate.slot is not None:
            _, at = state.free(FILTER)
            sd = np.sqrt(max(state.fit.cov[at[0], at[0]], 0.0))
            intervals["cutoff"] = factor(process.cutoff, sd)
        return process_parameters(process), intervals


def _floor(power: Array, count: Array, data: Data) -> float:
    """Density of a floor that the fast bands, of the sums `power` of `count` ordinates, leave room
    for beyond what the electronics add; 0 where none stands out.
    """
    k, kernel = data.layout.slow, np.ones(WIDTH)
    ordinates = np.convolve(count[k:], kernel, "valid")
    if not np.any(ordinates > 0):
        return 0.0
    level = np.convolve(power[k:], kernel, "valid") / np.maximum(ordinates, 1e-300)
    level = np.where(ordinates > 0, level, np.inf)
    at = int(np.argmin(level))
    floor = float(level[at] - np.convolve(data.extra[k:], kernel, "valid")[at] / WIDTH)
    return floor if 0.0 < DOWN * floor < np.max(level[np.isfinite(level)]) else 0.0


def _behind_it(terms: Iterable[Process]) -> ReadOutNoise:
    """The floor behind the filter."""
    return next(t for t in terms if isinstance(t, ReadOutNoise))


def _behind(term: Process, stage: Stage, fs: float) -> bool:
    """Whether the filter can stand behind a noise: one of samples has no spectrum at its rate."""
    return elsewhere(term) or not isinstance(term, Autoregressive) or stage.rate == fs


@lru_cache(maxsize=4)
def _gains(effect: LowPass, layout: Layout, fs: float) -> tuple[list[Stage], Array]:
    """The filters of the catalogue and their power gains in the bands, shape (filters, b)."""
    stages = effect.filters(fs)
    white = WhiteNoise(N=1.0)  # of the one-sided density 2 before the filter
    return stages, np.array(
        [0.5 * layout.collapse(Images(s, layout.grid, fs).psd(white)) for s in stages]
    )


EFFECTS = (LowPass(),)
