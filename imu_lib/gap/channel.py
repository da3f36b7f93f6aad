"""The workflow on one channel: electronics, noise level, lines, then the competition, then whether
anything is left.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from imu_lib.gap import (
    effects,
    electronics,
    held_out,
    measured,
    noise_level,
    rounds,
    steadiness,
    verdict,
)
from imu_lib.gap.base_fit import absorbed, alternatives, free_base
from imu_lib.gap.data import Data
from imu_lib.gap.drifts import profiled
from imu_lib.gap.effects.base import ChannelView
from imu_lib.gap.effects.resolution import grid_of
from imu_lib.gap.grown import between, grown, likely, refits
from imu_lib.gap.innovations import Smooth, whitened
from imu_lib.gap.state import State
from imu_lib.gap.steps import Step, steps_of_findings, steps_of_items
from imu_lib.processes import CommonMode, Sum

#: Effects whose doubts leave the name without high confidence.
DOUBTED = 0.5
#: Confidence at the most where three noises or more had to be added.
MANY = 0.8
#: Part of the shared noise's variance by which its estimate may be off.
SHARED = 0.1
#: What is found in single samples or their level: evidences of records that differ in it can't be
#: compared.
SAMPLES = ("saturation", "stuck", "spikes", "noise_level_change")
#: Log evidence by which spikes too small to be seen, white noise to a free quantization, may
#: mislead the choice between grids.
UNSEEN = 15.0
#: log10 p of the stationarity tests below which only one round is run for the noises.
VETO = -9.0
NO_DRIFT = tuple(e.name for e in effects.COMPETITORS if e not in effects.DRIFTS)


@dataclass(frozen=True)
class ChannelResult:
    """What was found in a channel.

    `base` is the model it started from (fitted where none was given), `model` the grown one,
    `evidence` its log evidence for
    the cleaned record, `steps` the effects in the order found, `absorbed` what a free base may
    have swallowed, `unexplained`
    None or a sentence, `refit` models fitted to the first part of the record, one a simulation,
    empty where that part does not
    show every effect, `filled` the number of samples that were filled in,
    `likely` grown models that stand for what the fit leaves uncertain.
    """

    name: str
    base: Sum
    model: Sum
    steps: list[Step]
    absorbed: list[str]
    unexplained: str | None
    checks: list = field(default_factory=list)
    mean: float = 0.0
    between: list = field(default_factory=list)
    refit: list = field(default_factory=list)
    evidence: float = 0.0
    filled: int = 0
    likely: list = field(default_factory=list)


def analyse(
    name: str,
    raw,
    fs: float,
    base: Sum | None,
    *,
    temperature=None,
    seed: int = 0,
    shared: float = 0.0,
    filtered: bool = False,
    known=None,
    progress=None,
) -> ChannelResult:
    """Find, name and add what `base` lacks to be the model of `raw` (NaN where a sample is
    missing), one channel at `fs` Hz.

    `shared` is the density N of noise that the channel shares with others and that is accounted
    for on the record; it enters
    before the channel's low-pass filter where it is `filtered`. `known`, shape (n,), is what else
    the record puts into the channel (vibration).
    """
    options = {
        "temperature": temperature,
        "seed": seed,
        "shared": shared,
        "filtered": filtered,
        "known": known,
        "progress": progress,
    }
    raw = np.asarray(raw, float)
    grid = grid_of(raw[~np.isnan(raw)])
    held = None if grid is None else electronics.integral_of(base, grid[0], fs)
    found = _analyse(name, raw, fs, base, **options)
    rounded = next((s for s in found.steps if s.effect == "resolution"), None)
    alone = rounded is not None and found.unexplained is None
    if grid is None or held is None and not alone and not any(map(_of_differences, found.steps)):
        return found
    if not electronics.may_be_of_integral(raw, grid[0], fs):
        return found
    if held is not None:
        base = Sum(
            tuple(held.with_(rounded=1) if t is held else t for t in base.terms), base.stages
        )
    other = _analyse(name, raw, fs, base, integral=True, **options)
    alike = (
        len({tuple(s.effect for s in r.steps if s.effect in SAMPLES) for r in (found, other)}) == 1
    )
    better, fewer = other.evidence - found.evidence, len(found.steps) - len(other.steps)
    if other.unexplained is None or found.unexplained is not None:
        # what is drawn for samples that are missing differs from one analysis to the other
        slack = 3.0 * np.sqrt(max(found.filled, other.filled)) + (
            UNSEEN if any(s.effect == "spikes" for s in found.steps) else 0.0
        )
        if (
            fewer > 0
            and (better > -slack or not alike)
            or fewer == 0
            and alike
            and better > max(rounds.NEAR, slack)
        ):
            return other
        if fewer == 0 and alike and abs(better) < rounds.NEAR and rounded is not None:
            doubtful = replace(rounded.capped(DOUBTED), indistinguishable=["quantization"])
            found = replace(found, steps=[doubtful if s is rounded else s for s in found.steps])
    return found


def _of_differences(step) -> bool:
    """Whether a step beside a grid may come of rounding the integral: differenced errors, white
    noise the less, samples that agree.
    """
    if step.effect == "parameter_change":
        return step.parameters["name"] in ("N", "Q")
    return (
        step.effect in ("quantization", "stuck")
        or step.effect == "autoregressive"
        and len(step.parameters["phi"]) == 1
    )


def _analyse(
    name, raw, fs, base, *, temperature, seed, shared, filtered, known, progress, integral=False
) -> ChannelResult:
    say = progress or (lambda text: None)
    rng = np.random.default_rng([seed, sum(map(ord, name))])
    mean = float(np.nanmean(raw))
    given = base
    drift = np.zeros(len(raw))
    if given is not None and given.drifts.terms:
        moving = Sum(
            tuple(
                t
                for t in given.drifts.terms
                if t.name != "constant" and not (t.name == "sinusoid" and t.phase is None)
            )
        )
        drift = moving.mean(np.arange(len(raw)) / fs, temperature)
    say("electronics")
    clean = electronics.undo(raw, fs, given, rng, integral=integral, known=known)
    x = clean.x - drift
    findings = list(clean.findings)
    terms = [] if given is None else [t for t in given.terms if not t.deterministic]
    if shared > 0:
        terms.append(CommonMode(N=shared, channels=(name,), filtered=1 if filtered else None))
    if clean.of_integral is not None and (given is None or given.rounding is None):
        terms.append(clean.of_integral)
    held_terms = len(terms) - (0 if given is None else len(given.noise.terms))
    # -- noise level
    # ---------------------------------------------------------------------------------------
    say("noise level")
    y = whitened(clean.x - clean.coarse, clean.smooth) / clean.swing
    low_pass = None if given is None else given.low_pass
    level = 1.0 if given is None else noise_level.model_level(clean, terms, low_pass, fs)
    # jumps and lines that stand out keep their size whatever the noise does
    view = ChannelView(x - clean.coarse, y, raw, fs, clean.smooth, given, level, temperature)
    held = None if given is None else given.find("noise_level_change")
    if held is not None:
        view = noise_level.scaled(view, held.factor(len(x), fs))
    view, of_noise, doubts = noise_level.settled(view)
    findings += of_noise
    x, y = view.x + clean.coarse, view.y
    # -- lines
    # ---------------------------------------------------------------------------------------------
    say("lines")
    data = Data(
        x, fs, white=clean.white, temperature=temperature, extra=clean.extra, blind=clean.blind
    )
    lines, data = held_out.steady(*effects.CATALOGUE["sinusoid"].find(data), data)
    if given is not None:
        foreseen = [t.frequency for t in given.terms if t.name == "sinusoid" and t.phase is None]
        lines = [
            (item, s)
            for item, s in lines
            if not any(abs(f - item.process.frequency) < 2 / data.duration for f in foreseen)
        ]
    findings += [item for item, _ in lines]
    # -- the competition
    # -------------------------------------------------------------------------------------
    say("candidates")
    if given is None:
        state, families = free_base(data, terms)
    else:
        state = State(data, terms, low_pass=given.low_pass)
    n_base = len(state.base)
    # a spectrum that does not stand still has no stationary name: one round at the most, and no
    # confidence
    quiet = whitened(data.x - clean.coarse, clean.smooth) / clean.swing if lines else y
    coarse_steps = clean.step is not None and clean.step > 1.2 * np.sqrt(
        clean.smooth.conditional_variance
    )
    unsteady = min(
        steadiness.stationarity(quiet, fs, clean.smooth, coarse_steps=coarse_steps),
        key=lambda c: c.log_p,
        default=None,
    )
    wild = unsteady is not None and unsteady.log_p < VETO
    state, _ = rounds.grow(state, progress=say, most=1 if wild else 5)
    if wild:  # what drifts is seen in the means, whatever the spectrum does
        state, _ = rounds.grow(state, progress=say, exclude=NO_DRIFT)
    rivals = [{} for _ in state.items]
    if state.items:
        state, rivals = rounds.swap(rounds.prune(state), passes=1 if wild else 2)
        fewer = rounds.prune(state)
        if len(fewer.items) < len(state.items):
            state, rivals = rounds.swap(fewer, passes=1)
        # what does not hold in time that was not fitted is not taken
        state, rivals = held_out.without(state, rivals, held_out.lasting(state))
        state = profiled(state)
    # -- what is left
    # ----------------------------------------------------------------------------------------
    say("what is left")

    def bared(state):
        rest = data.x - state.deterministic
        smooth = Smooth(rest, fs)
        return rest, whitened(rest, smooth) / clean.swing, smooth

    def left(state):
        rest, y, smooth = bared(state)
        for f in of_noise:
            y = f.effect.normal(y, f)
        return verdict.checks(state, rest, y, smooth, coarse_steps=coarse_steps)

    tests = left(state)
    if min(c.log_p for c in tests) < verdict.LIMIT and state.items and not wild:
        # before it is left without a name: two effects far behind one alone
        other, _ = rounds.swap(state, passes=1, reach=np.inf)
        if other.evidence > state.evidence + rounds.EVIDENCE:
            state, rivals = rounds.swap(rounds.prune(other), passes=1)
            state = profiled(state)
            tests = left(state)
    worst = min(tests, key=lambda c: c.log_p)
    if doubts and np.ptp(state.deterministic) > 0:
        # the edges of two levels are loud, too, until these are taken out
        rest, y, smooth = bared(state)
        doubts = noise_level.settled(replace(view, x=rest, y=y, smooth=smooth))[2]
    doubts += [f.doubt for f in findings if f.doubt]
    unexplained = None
    if worst.log_p < verdict.LIMIT:
        # what was seen of the level says more than that it changes
        unexplained = doubts[0] if doubts and worst.domain == "stationarity" else worst.where
    elif doubts:
        unexplained = doubts[0]
    steps = steps_of_findings(findings, fs) + steps_of_items(state, rivals)
    if unexplained is not None:
        steps = [s.capped(measured.beside_unexplained(s.effect)) for s in steps]
    elif (
        len(state.fit.slots) - len(state.base_slots) > 2
    ):  # so many noises draw any smooth spectrum
        steps = [s.capped(MANY) for s in steps]
    steps = _doubtful(steps, shared)
    base_sum = given if given is not None else Sum(tuple(state.base[held_terms:n_base]))
    parts = base_sum, state, findings, n_base - held_terms, held_terms
    model = grown(*parts)
    refit = refits(*parts, rng) if steps else []
    swallowed = [] if given is not None else absorbed(state)
    return ChannelResult(
        name,
        base_sum,
        model,
        steps,
        swallowed,
        unexplained,
        tests,
        mean,
        between(base_sum, findings, state),
        refit,
        state.evidence,
        clean.filled,
        likely(
            [(state, 1.0)] if given is not None else alternatives(state, families),
            given,
            findings,
            held_terms,
            rng,
        ),
    )


def _doubtful(steps, shared):
    """The steps with no high confidence in what the make of another would explain, too.

    A filter that is not of the catalogue's kinds leaves a slope near half the sampling rate; where
    an angle or a velocity is
    rounded instead of the sample, its errors are differenced, and N stands for the white noise
    that the grid then lacks. The
    density of `shared` noise is known to some per cent, and a channel's own N makes up for the
    rest.
    """
    names = {s.effect for s in steps}
    out = []
    for s in steps:
        if "low_pass" in names and s.effect in ("quantization", "autoregressive"):
            s = s.capped(MANY)
        if s.effect == "parameter_change" and s.parameters["name"] == "N":
            moved = abs(s.parameters["to"] ** 2 - s.parameters["from"] ** 2)
            if {"resolution", "quantization"} <= names or moved < SHARED * shared**2:
                s = s.capped(DOUBTED)
        out.append(s)
    return out
