"""A channel made ready for the competition: its electronics undone, without the drifts that the
model has, the changes of its noise level and its lines.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from imu_lib.gap import effects, electronics, held_out, noise_level
from imu_lib.gap.data import Data
from imu_lib.gap.effects.base import ChannelView, Finding
from imu_lib.gap.line_phases import in_phase
from imu_lib.gap.state import State
from imu_lib.processes import CommonMode, Constant, NoiseLevelChange, Process, Sum
from imu_lib.samples.innovations import Smooth, trend, whitened

#: Step of a grid in standard deviations of the fast noise from which on rounded samples are not
#: normal.
COARSE_STEPS = 1.2


@dataclass(frozen=True)
class OfRecord:
    """What is in a channel and accounted for on the record.

    Attributes
    ----------
    shared : float
        Density N of noise that it shares with others.
    filtered : bool
        Whether that enters before the channel's low-pass filter.
    known : ndarray, shape (n,), or None
        What else the record puts into it (vibration).
    left : str
        What of that has no name, in a sentence.
    band : bool
        Whether it shakes the channel over a band.
    """

    shared: float = 0.0
    filtered: bool = False
    known: np.ndarray | None = None
    left: str = ""
    band: bool = False


@dataclass(frozen=True)
class Channel:
    """One channel as it came.

    Attributes
    ----------
    name : str
    raw : ndarray, shape (n,)
        NaN where a sample is missing.
    fs : float, Hz
    temperature : ndarray, shape (n,), or None
    of_record : OfRecord
    """

    name: str
    raw: np.ndarray
    fs: float
    temperature: np.ndarray | None
    of_record: OfRecord


@dataclass
class Preprocessed:
    """What is left of a channel for the noises and drifts to compete for.

    `terms` are the noises of the given model and, `held_terms` of them, what stands for more than
    the model says; `quiet` (n,) the innovations without lines, `of_noise` what was found of their
    level, `doubts` about it, `paths` the terms of the given model whose paths were seen and taken
    out: `given` is without them; `seen` the data with them.
    """

    channel: Channel
    given: Sum | None
    terms: list[Any]
    held_terms: int
    clean: electronics.Clean
    view: ChannelView
    data: Data
    quiet: np.ndarray
    findings: list[Finding]
    of_noise: list[Finding] = field(default_factory=list)
    doubts: list[str | None] = field(default_factory=list)
    paths: tuple[Process, ...] = ()
    seen: Data | None = None

    def with_paths(self, model: Sum) -> Sum:
        """A model with the terms whose paths were taken out."""
        return Sum((*model.terms, *self.paths), model.stages) if self.paths else model

    def as_noise(self, state: State) -> State:
        """A state with the paths that were taken out as noise of their spectrum."""
        if self.seen is None:
            return state
        return State(
            self.seen,
            (*state.base, *self.paths),
            state.items,
            low_pass=state.base_low_pass,
            base_slots=state.base_slots,
        )

    @property
    def coarse_steps(self) -> bool:
        """Whether the output is rounded so coarsely, or so unevenly, that it is no longer
        normal.
        """
        step, variance = self.clean.step, self.clean.smooth.conditional_variance
        coarse = step is not None and step > COARSE_STEPS * np.sqrt(variance)
        told = any(f.variance is not None for f in self.of_noise)  # of its tails by its levels
        return bool(coarse or told or self.clean.uneven)

    def bared(self, state: State) -> tuple[np.ndarray, np.ndarray, Smooth]:
        """What a state leaves of the samples, its innovations, and the spectrum that whitens it."""
        rest = self.data.x - state.deterministic
        smooth = Smooth(rest, self.channel.fs).above(self.clean.rounding)
        return rest, whitened(rest, smooth) / self.clean.swing, smooth


def preprocessed(
    channel: Channel, given: Sum | None, rng: np.random.Generator, *, integral: bool
) -> Preprocessed:
    """The channel without its electronics, the changes of its noise level and its lines."""
    given = in_phase(given, channel.raw, channel.fs)
    clean = electronics.undo(
        channel.raw, channel.fs, given, rng, integral=integral, known=channel.of_record.known
    )
    terms = _noises(channel, given, clean)
    held_terms = len(terms) - (0 if given is None else len(given.noise.terms))
    view, of_noise, doubts = noise_level.settled(_view(channel, given, clean, terms))
    # what brings the noise to one level does so with the rounding, which had one
    stages = () if given is None else given.stages
    held = [s.factor(len(view.x), channel.fs) for s in stages if isinstance(s, NoiseLevelChange)]
    scales = [*held, *(f.scale for f in of_noise if f.scale is not None)]
    less = float(np.mean(np.prod(scales, axis=0) ** -2.0)) if scales else 1.0
    data = Data(
        view.x + clean.coarse,
        channel.fs,
        white=less * clean.white,
        temperature=channel.temperature,
        extra=None if clean.extra is None else less * clean.extra,
        blind=clean.blind,
        missing=np.isnan(channel.raw),
    )
    lines = []
    for effect in effects.SIGNALS:
        found, data = held_out.steady(*effect.find(data), data)
        lines += [item for item, _ in found if not effect.foreseen(item, given, data)]
    quiet = whitened(data.x - clean.coarse, view.smooth) / clean.swing if lines else view.y
    findings = [*clean.findings, *of_noise, *lines]
    left = Preprocessed(
        channel,
        given,
        terms,
        held_terms,
        clean,
        view,
        data,
        quiet,
        findings,
        of_noise,
        doubts,
    )
    return left if given is None else _without_paths(left, given)


def _without_paths(left: Preprocessed, given: Sum) -> Preprocessed:
    """Without what terms of the given model are seen to do in the samples."""
    for term in given.terms:
        state = State(left.data, left.terms, low_pass=given.low_pass)
        paths = (e.path(state, term) for e in effects.COMPETITORS)
        path = next((p for p in paths if p is not None), None)
        if path is not None:
            given = Sum(tuple(t for t in given.terms if t is not term), given.stages)
            left = replace(
                left,
                data=left.data.minus(path),
                given=given,
                terms=[t for t in left.terms if t is not term],
                paths=(*left.paths, term),
                seen=left.seen or left.data,
            )
    return left


def _noises(channel: Channel, given: Sum | None, clean: electronics.Clean) -> list[Any]:
    """The noises that the competition starts from."""
    terms = [] if given is None else [t for t in given.terms if not t.deterministic]
    common = channel.of_record
    if common.shared > 0:
        filtered = 1 if common.filtered else None
        terms.append(CommonMode(N=common.shared, channels=(channel.name,), filtered=filtered))
    if clean.of_integral is not None and (given is None or given.rounding is None):
        terms.append(clean.of_integral)
    return terms


def _view(
    channel: Channel, given: Sum | None, clean: electronics.Clean, terms: list[Any]
) -> ChannelView:
    """What the effects on the noise of the channel see."""
    fs, low_pass = channel.fs, None if given is None else given.low_pass
    smooth = clean.smooth.above(clean.rounding)
    x, y = clean.x - _drift(channel, given), whitened(clean.x - clean.coarse, smooth)
    level = 1.0 if given is None else noise_level.model_level(clean, terms, low_pass, fs)
    known = 0.0 if channel.of_record.known is None else channel.of_record.known
    untouched = np.abs(channel.raw - clean.x - known) < 1e-3 * (clean.step or np.inf)
    # jumps and lines that stand out keep their size whatever the noise does
    view = ChannelView(
        x - clean.coarse,
        y / clean.swing,
        np.where(untouched, channel.raw, np.nan),
        clean.coarse + known + trend(clean.x - clean.coarse, clean.smooth.m),
        fs,
        smooth,
        given,
        level,
        channel.temperature,
    )
    stages = () if given is None else given.stages
    held = next((s for s in stages if isinstance(s, NoiseLevelChange)), None)
    return view if held is None else noise_level.scaled(view, held.factor(len(x), fs))


def _drift(channel: Channel, given: Sum | None) -> np.ndarray:
    """The drifts of the given model, but for its mean and lines of unknown phase."""
    drifts: tuple[Any, ...] = () if given is None else given.drifts.terms
    moving = Sum(tuple(t for t in drifts if not isinstance(t, Constant) and t.known))
    return moving.mean(np.arange(len(channel.raw)) / channel.fs, channel.temperature)
