"""The workflow on one channel: electronics, noise level, lines, then the competition, then whether
anything is left.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from imu_lib.arrays import Array, ArrayLike
from imu_lib.gap import (
    effects,
    electronics,
    held_out,
    left_beside,
    noise_level,
    normality,
    residual_tests,
    rounds,
    stationarity,
)
from imu_lib.gap.absorbed import absorbed
from imu_lib.gap.base_fit import against_bases, alternatives, free_base
from imu_lib.gap.check import Check
from imu_lib.gap.drifts import profiled
from imu_lib.gap.effects.quantization import Quantization
from imu_lib.gap.effects.resolution import Resolution, grid_of
from imu_lib.gap.effects.sinusoid import Sinusoid
from imu_lib.gap.grown import between, grown, likely, refits
from imu_lib.gap.preprocess import Channel, OfRecord, Preprocessed, preprocessed
from imu_lib.gap.state import MIN_EVIDENCE, State
from imu_lib.gap.steps import Step, step_of, steps_of_items
from imu_lib.gap.tailed_part import of_white_noise
from imu_lib.processes import ReadOutNoise, Sum
from imu_lib.samples.uneven import uneven

#: Confidence in one of two readings of a grid that the record does not tell apart, and in a
#: resonance of a channel that is shaken over a band, whose multiples and skirts look the same.
DOUBTED = 0.5
#: Confidence at the most where three noises or more had to be added.
MOST_AMONG_MANY = 0.8
#: log10 p of the stationarity tests below which only one round is run for the noises.
VETO = -9.0
#: Domains of which the doubts about a finding say more than the test does.
SAID_BETTER = ("stationarity", "distribution", normality.SKEW)
NO_DRIFT = tuple(e.name for e in effects.COMPETITORS if e not in effects.DRIFTS)


@dataclass(frozen=True)
class ChannelResult:
    """What was found in a channel.

    `base` is the model it started from (fitted where none was given), `model` the grown one,
    `evidence` its log evidence for the cleaned record, `steps` the effects in the order found,
    `absorbed` what a free base may have swallowed, `unexplained` None or a sentence, `small`
    departures beyond chance that are too small to matter, `refit` models fitted to the first part
    of the record, one a simulation, empty where that part does not show every effect, `filled` the
    number of samples that were filled in, `likely` grown models that stand for what the fit leaves
    uncertain.
    """

    name: str
    base: Sum
    model: Sum
    steps: list[Step]
    absorbed: list[str]
    unexplained: str | None
    checks: list[Check] = field(default_factory=list)
    mean: float = 0.0
    between: list[Sum] = field(default_factory=list)
    refit: list[Sum] = field(default_factory=list)
    evidence: float = 0.0
    filled: int = 0
    likely: list[Sum] = field(default_factory=list)
    small: list[str] = field(default_factory=list)


def analyse(
    name: str,
    raw: ArrayLike,
    fs: float,
    base: Sum | None,
    *,
    temperature: Array | None = None,
    seed: int = 0,
    of_record: OfRecord | None = None,
) -> ChannelResult:
    """Find, name and add what `base` lacks to be the model of `raw` (NaN where a sample is
    missing), one channel at `fs` Hz, beside what is accounted for on the record.
    """
    raw = np.asarray(raw, float)
    channel = Channel(name, raw, fs, temperature, of_record or OfRecord())
    grid = grid_of(raw[~np.isnan(raw)])
    held = None if grid is None else electronics.integral_of(base, grid[0], fs)
    found = _analyse(channel, base, seed)
    rounded = next((s for s in found.steps if s.effect == Resolution.name), None)
    alone = rounded is not None and found.unexplained is None
    differenced = any(effect.of_differences(s.parameters) for s, effect in _told(found.steps))
    if grid is None or held is None and not alone and not differenced:
        return found
    if uneven(raw[~np.isnan(raw)], *grid) is not None:
        return found  # the increments of a rounded integral have no widths of their own
    if not electronics.may_be_of_integral(raw, grid[0], fs):
        return found
    if held is not None and base is not None:
        base = Sum(
            tuple(held.with_(rounded=1) if t is held else t for t in base.terms), base.stages
        )
    return _likelier_grid(found, _analyse(channel, base, seed, integral=True), rounded)


def _likelier_grid(
    found: ChannelResult, other: ChannelResult, rounded: Step | None
) -> ChannelResult:
    """What was found with samples that are `rounded`, or the `other` with a rounded integral."""
    altered = {tuple(e.name for _, e in _told(r.steps) if e.alters) for r in (found, other)}
    alike = len(altered) == 1
    better, fewer = other.evidence - found.evidence, len(found.steps) - len(other.steps)
    if other.unexplained is not None and found.unexplained is None:
        return found
    # what is drawn for samples that are missing differs from one analysis to the other
    slack = 3.0 * np.sqrt(max(found.filled, other.filled))
    slack += max((e.unseen for _, e in _told(found.steps)), default=0.0)
    if fewer > 0 and (better > -slack or not alike):
        return other
    if fewer == 0 and alike and better > max(rounds.INDISTINCT, slack):
        return other
    if fewer == 0 and alike and abs(better) < rounds.INDISTINCT and rounded is not None:
        doubtful = replace(rounded.capped(DOUBTED), indistinguishable=[Quantization.name])
        found = replace(found, steps=[doubtful if s is rounded else s for s in found.steps])
    return found


def _told(steps: list[Step]) -> list[tuple[Step, Any]]:
    """The steps, each with its effect."""
    return [(s, effects.CATALOGUE[s.effect]) for s in steps]


def _analyse(
    channel: Channel, given: Sum | None, seed: int, *, integral: bool = False
) -> ChannelResult:
    """The channel with its grid read one way."""
    rng = np.random.default_rng([seed, sum(map(ord, channel.name))])
    left = preprocessed(channel, given, rng, integral=integral)
    bare = left.given
    if bare is None:
        start, families = free_base(left.data, left.terms)
    else:
        start, families = State(left.data, left.terms, low_pass=bare.low_pass), []
    wild = _wild(left)
    state, rivals = _named(start, wild)
    state, rivals, tests = _tested(left, state, rivals, wild)
    unexplained, small = _unexplained(left, state, tests)
    unexplained = "; ".join(filter(None, (channel.of_record.left, unexplained))) or None
    found = [f for f in of_white_noise(left.findings, state) if not noise_level.of_model(f, bare)]
    steps = [*map(step_of, found), *steps_of_items(state, rivals)]
    plain = [f.process.name for f in found if f.counted]
    steps = _doubtful(_capped(steps, state, unexplained, plain), channel.of_record)
    held, n_base = left.held_terms, len(state.base)
    base = bare if bare is not None else Sum(tuple(state.base[held:n_base]))
    parts = base, state, found, n_base - held, held
    states = [(state, 1.0)] if given is not None else alternatives(state, families)
    model, refit = grown(*parts), refits(*parts, rng) if steps else []
    path = left.with_paths
    return ChannelResult(
        channel.name,
        base if given is None else given,
        path(model),
        steps,
        [] if given is not None else absorbed(state),
        unexplained,
        tests,
        float(np.nanmean(channel.raw)),
        [path(m) for m in between(base, found, state)],
        [path(m) for m in refit],
        state.evidence,
        left.clean.filled,
        [path(m) for m in likely(states, bare, found, held, rng)],
        small,
    )


def _wild(left: Preprocessed) -> bool:
    """Whether the spectrum does not stand still: it has no stationary name then, and one round at
    the most is run.
    """
    checks = stationarity.stationarity(
        left.quiet, left.channel.fs, left.view.smooth, coarse_steps=left.coarse_steps
    )
    return min((c.log_p for c in checks), default=0.0) < VETO


def _named(state: State, wild: bool) -> tuple[State, list[Any]]:
    """The state grown by what is missing, and the rivals of each of its items."""
    state, _ = rounds.grow(state, most=1 if wild else 5)
    if wild:  # what drifts is seen in the means, whatever the spectrum does
        state, _ = rounds.grow(state, exclude=NO_DRIFT)
    if not state.items:
        return state, []
    state, rivals = rounds.swap(rounds.prune(state), passes=1 if wild else 2)
    fewer = rounds.prune(state)
    if len(fewer.items) < len(state.items):
        state, rivals = rounds.swap(fewer, passes=1)
    state, rivals = against_bases(state, rivals)
    # what does not hold in time that was not fitted is not taken
    state, rivals = held_out.without(state, rivals, held_out.lasting(state))
    return profiled(state), rivals


def _tested(
    left: Preprocessed, state: State, rivals: list[Any], wild: bool
) -> tuple[State, list[Any], list[Check]]:
    """The state, its rivals and the checks of what it leaves; before it is left without a name, two
    effects far behind one alone are tried.
    """
    tests = _checks(left, state)
    if min(c.log_p for c in tests) < residual_tests.LIMIT and state.items and not wild:
        other, _ = rounds.swap(state, passes=1, reach=np.inf)
        if other.evidence > state.evidence + MIN_EVIDENCE:
            state, rivals = rounds.swap(rounds.prune(other), passes=1)
            state = profiled(state)
            tests = _checks(left, state)
    return state, rivals, tests


def _checks(left: Preprocessed, state: State) -> list[Check]:
    rest, y, smooth = left.bared(state)
    for f in left.of_noise:
        effect: Any = f.effect
        y = effect.normal(y, f)
    return residual_tests.checks(
        state, rest, y, smooth, coarse_steps=left.coarse_steps, as_noise=left.as_noise
    )


def _unexplained(
    left: Preprocessed, state: State, tests: list[Check]
) -> tuple[str | None, list[str]]:
    """What is left without a name, in a sentence, and what is left that is too small to matter."""
    doubts = left.doubts
    if doubts and np.ptp(state.deterministic) > 0:
        # the edges of two levels are loud, too, until these are taken out
        rest, y, smooth = left.bared(state)
        doubts = noise_level.settled(replace(left.view, x=rest, y=y, smooth=smooth))[2]
    doubts = [*(f.doubt for f in left.findings if f.doubt), *doubts]
    known = () if left.given is None else (*left.given.terms, *left.given.stages)
    named = [f.effect.name for f in left.findings] + [t.name for t in known]
    worst, small = residual_tests.weighed(tests, named)
    if worst.log_p < residual_tests.LIMIT and not (doubts and worst.domain in SAID_BETTER):
        return worst.where, small
    # what was seen of the level and of the sizes says more than that they are not the model's
    return (doubts[0] if doubts else None), small


def _capped(
    steps: list[Step], state: State, unexplained: str | None, plain: list[str]
) -> list[Step]:
    """The steps with no more confidence than they deserve beside what is unexplained, or among so
    many noises that they draw any smooth spectrum. What is unexplained says nothing against the
    effects `plain`: that all samples lie on one grid, or a fifth of them on a rail, is counted.
    """
    if unexplained is not None:
        lines = sum(s.effect == Sinusoid.name for s in steps)
        return [
            s
            if s.effect in plain
            else s.capped(left_beside.most_sure(s.effect, s.parameters, unexplained, lines))
            for s in steps
        ]
    floors = sum(isinstance(t, ReadOutNoise) for t in state.fit.terms)  # these come with a filter
    if len(state.fit.slots) - len(state.base_slots) - floors > 2:
        return [s.capped(MOST_AMONG_MANY) for s in steps]
    return steps


def _doubtful(steps: list[Step], common: OfRecord) -> list[Step]:
    """The steps with no high confidence in what the make of another effect, or what is accounted
    for on the record, would explain, too.
    """
    beside, out = [effect for _, effect in _told(steps)], []
    for step, effect in _told(steps):
        step = step.capped(effect.most_sure(step.parameters, beside, common.shared))
        if common.band and getattr(effect, "local", False):
            other = [*step.indistinguishable, "vibration"]
            step = replace(step.capped(DOUBTED), indistinguishable=list(dict.fromkeys(other)))
        out.append(step)
    return out
