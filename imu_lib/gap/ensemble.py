"""Simulations of a model against the measurement: the gap index.

All channels and all models of a step share the white draws of a simulation, so that before and after
differ by the model and not by luck; within one model's ensemble the simulations are independent.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from imu_lib.gap.battery import battery, stack
from imu_lib.processes import Constant, Sum

#: Simulations in an ensemble.
SIZE = 100
#: Correlation time, s, from which on noise passes a filter in the sensor unchanged.
PASSES = 10.0
#: Scatter that a statistic is given which is the same in all simulations, such as the share of frozen samples.
ALIKE = 0.02


class Replay:
    """A random generator that hands out the same normal draws again for the next model."""

    def __init__(self, seed):
        self._normal, self._cache, self._at = np.random.default_rng(seed), [], 0
        self._other = np.random.default_rng([*np.atleast_1d(seed), 1])

    def rewind(self):
        self._at = 0
        return self

    def standard_normal(self, size=None):
        if size is None or np.ndim(size) or not isinstance(size, (int, np.integer)):
            return self._other.standard_normal(size)
        if self._at == len(self._cache):
            self._cache.append(self._normal.standard_normal(size))
        draw = self._cache[self._at]
        if len(draw) < size:
            draw = self._cache[self._at] = np.concatenate([draw, self._normal.standard_normal(size - len(draw))])
        self._at += 1
        return draw[:size].copy()

    def __getattr__(self, name):
        return getattr(self._other, name)


def centred(model: Sum, level: float, t, temperature) -> Sum:
    """The model with the constant that gives its simulations the record's mean before the electronics."""
    drifts = Sum(tuple(p for p in model.drifts.terms if p.name != "constant"))
    offset = level - float(np.mean(drifts.mean(t, temperature)))
    return Sum(tuple(p for p in model.terms if p.name != "constant") + (Constant(value=offset),), model.stages)


def draw(model: Sum, n: int, fs: float, rng, *, temperature=None, common=None):
    """A realisation of the model, shape (n,).

    Where a filter runs at many times the sampling rate, the quick noise is drawn behind it from its folded spectrum, and
    what is slow passes it unchanged.
    """
    if model.low_pass is None or model.low_pass.grid(fs)[0] <= 2:
        return model.simulate(n, fs, rng, temperature=temperature, common=common)
    size = next_fast_len(n + 4096, real=True)
    f = np.maximum(np.arange(size // 2 + 1), 1) * fs / size
    parts = {kind: tuple(t for t in model.terms if _passage(t) == kind) for kind in ("unchanged", "slow", "quick")}

    def behind(terms):
        if not terms:
            return np.zeros(n)
        density = Sum(terms, (model.low_pass,)).psd(f, fs)
        return irfft(rfft(rng.standard_normal(size)) * np.sqrt(density * fs / 2), size)[:n]
    slow = Sum(parts["unchanged"]).simulate(n, fs, rng, temperature=temperature) + behind(parts["slow"])
    return model.behind(slow, behind(parts["quick"]), fs, rng, common=common)


def _passage(term) -> str:
    """How a process passes a filter: unchanged, as slow noise that is filtered, as quick noise whose level may change."""
    if term.deterministic or term.name in ("random_walk", "flicker", "telegraph") or getattr(term, "correlation_time", 0.0) > PASSES:
        return "unchanged"
    return "quick" if term.fast else "slow"


def simulate(jobs, n: int, fs: float, seeds, temperature, levels) -> list[list[dict]]:
    """Batteries of simulations: for each job (model, start, stop in samples, shared N or 0, lost mask or None) one list over the seeds."""
    t = np.arange(n) / fs
    ready = [centred(model, level, t, temperature) for (model, *_), level in zip(jobs, levels)]
    out = [[] for _ in jobs]
    for seed in seeds:
        rng = Replay(seed)
        made = {}
        for k, (model, (_, start, stop, shared, lost)) in enumerate(zip(ready, jobs)):
            key = (id(jobs[k][0]), shared)
            if key not in made:
                common = None if not shared else rng._other.standard_normal(n) * shared * np.sqrt(fs)
                made = {key: draw(model, n, fs, rng.rewind(), temperature=temperature, common=common)}
            x = made[key]
            if lost is not None:
                x = filled(np.where(lost, np.nan, x))
            part = x[start:stop]
            out[k].append(battery(part, fs, None if temperature is None else temperature[start:stop]))
    return out


def filled(x):
    """Missing samples replaced by straight lines, on the measurement and on the simulations alike."""
    bad = np.isnan(x)
    if not bad.any():
        return x
    at = np.flatnonzero(~bad)
    return np.interp(np.arange(len(x)), at, x[at])


@dataclass(frozen=True)
class Index:
    """The gap index, whole and by domain."""

    value: float
    domains: dict
    spread: float


def index(measured: dict, rows: list[dict]) -> Index:
    """Distance of the measurement from the ensemble over the median distance of one simulation from the others.

    The distance is the root mean square over all statistics, so that one record's index scatters by some 0.1 about 1 where
    the model is right; a domain's own index, of a few statistics, by more.
    """
    many, count = stack(rows), len(rows)
    near, far = {}, {}
    for d, s in many.items():
        if s.shape[1] == 0:
            continue
        mean, sd = s.mean(axis=0), s.std(axis=0, ddof=1)
        sd = np.where(sd > 1e-6 * (1 + np.abs(mean)), sd, ALIKE)
        z = (measured[d] - mean) / sd / np.sqrt(1 + 1 / count)
        near[d] = ((s - mean) / sd) ** 2 * count / (count - 1)
        far[d] = np.minimum(np.abs(z), 1e3) ** 2

    def ratio(whole, each):
        each = np.sqrt(np.mean(each, axis=1))
        median = float(np.median(each)) or 1.0             # 0 where all simulations agree
        return float(np.sqrt(np.mean(whole)) / median), float(np.quantile(each, 0.95) / median)
    value, spread = ratio(np.concatenate(list(far.values())), np.concatenate(list(near.values()), axis=1))
    return Index(value, {d: ratio(far[d], near[d])[0] for d in far}, spread)
