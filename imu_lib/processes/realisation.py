"""A realisation of a sum of processes and its output stages, in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from imu_lib.arrays import Array

from . import folded
from .autoregressive import Autoregressive
from .deterministic import Sinusoid
from .heavy_tails import HeavyTails
from .low_pass import LowPass
from .stages import NoiseLevelChange, Resolution
from .wandering_level import WanderingLevel
from .white import WhiteNoise

if TYPE_CHECKING:
    from .sum import Sum

#: Stages that act on the fast noise alone, not on the sum of all.
ON_NOISE = (LowPass, NoiseLevelChange, HeavyTails, WanderingLevel)


#: Share of the white noise at half the sampling rate up to which noise with a memory counts for
#: nothing there.
MAX_SHARE_OF_WHITE = 0.01


def moves_within_steps(model: Sum, fs: float) -> bool:
    """Whether something in front of a moving average moves within the steps of its coarse grid so
    that it shows: a line, or noise with a memory that does not drown in the white noise there.
    """
    low_pass = model.low_pass
    if low_pass is None or low_pass.taps is None:
        return False
    rate = fs * low_pass.grid(fs)[0]
    white = memory = 0.0
    for term in model.terms:
        if term is model.rounding or term.behind_filter:
            continue
        if isinstance(term, Autoregressive):
            if abs(term.rate / rate - 1.0) > 1e-6:
                return True  # it runs on a grid of its own
        elif isinstance(term, WhiteNoise):
            white += float(term.psd(fs / 2, rate))
        elif isinstance(term, Sinusoid):
            return True
        elif not term.deterministic:
            memory += float(term.psd(fs / 2, rate))
    return memory > MAX_SHARE_OF_WHITE * white


def of(
    model: Sum,
    n: int,
    fs: float,
    rng: np.random.Generator,
    *,
    temperature: Array | None = None,
    common: Array | None = None,
) -> Array:
    """As `Sum.simulate`."""
    low_pass = model.low_pass
    fine = moves_within_steps(model, fs)
    steps, before = (1, 0) if low_pass is None else low_pass.grid(fs, fine)
    size, rate = n * steps + before, fs * steps
    start = -before / rate
    if temperature is not None and (steps, before) != (1, 0):
        at = start + np.arange(size) / rate
        temperature = np.interp(at, np.arange(n) / fs, temperature)
    slow, quick, of_record = np.zeros(size), np.zeros(size), np.zeros(n)
    for term in model.terms:
        if term is model.rounding:
            continue
        if term.behind_filter:
            of_record += term.simulate(n, fs, rng)
            continue
        tails, density = (model.tails, term.N) if isinstance(term, WhiteNoise) else (None, 0.0)
        if tails is not None and low_pass is not None:
            longer = n + len(folded.response(low_pass, fs)) - 1
            drawn = term.simulate(longer, fs, rng)
            tailed = tails.given(drawn, density * np.sqrt(fs), rng)
            of_record += folded.behind(tailed, low_pass, fs)
            continue
        part = quick if term.fast else slow
        drawn = term.simulate(size, rate, rng, temperature=temperature, start=start)
        part += drawn if tails is None else tails.given(drawn, density * np.sqrt(rate), rng)
    if low_pass is not None:
        slow, quick = (low_pass.run(x, fs, n, fine) for x in (slow, quick))
    return behind(model, slow, quick + of_record, fs, rng, common=common)


def behind(
    model: Sum,
    slow: Array,
    quick: Array,
    fs: float,
    rng: np.random.Generator,
    *,
    common: Array | None = None,
) -> Array:
    """As `Sum.behind`."""
    for stage in model.stages:
        if isinstance(stage, NoiseLevelChange):
            quick = quick * stage.factor(len(quick), fs)
        elif isinstance(stage, WanderingLevel):
            quick = quick * stage.draw(len(quick), fs, rng)
    x = slow + quick
    if common is not None:
        x = x + common
    stages = [s for s in model.stages if not isinstance(s, ON_NOISE)]
    chain = [(s.place, s.apply) for s in stages]
    if model.rounding is not None:  # the integral is rounded where samples would be
        chain.append((Resolution.place - 0.5, model.rounding.round))
    for _, act in sorted(chain, key=lambda link: link[0]):
        x = act(x, fs, rng)
    return x
