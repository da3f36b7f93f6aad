"""Simulations of a model against the measurement: the gap index.

All channels and all models of a step share the draws of a simulation, so that before and after
differ by the model and not by luck; within one model's ensemble the simulations are independent.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from imu_lib.arrays import Array
from imu_lib.ensembles.battery import battery, stack
from imu_lib.ensembles.draws import Draws
from imu_lib.processes import (
    Constant,
    NoiseLevelChange,
    Resolution,
    Saturation,
    Sum,
    Vibration,
    WhiteNoise,
)

#: Statistics of a record by domain.
Battery = dict[str, np.ndarray]
#: Simulations in an ensemble.
SIZE = 100
#: Scatter that a statistic is given which is the same in all simulations, such as the share of
#: frozen samples.
LEAST_SCATTER = 0.02


def _moving(model: Sum) -> Sum:
    """The drifts of a model but for its constant."""
    return Sum(tuple(p for p in model.drifts.terms if not isinstance(p, Constant)))


def centred(model: Sum, level: float, t: Array, temperature: Array | None) -> Sum:
    """The model with the constant that gives its simulations the record's mean before the
    electronics.
    """
    offset = level - float(np.mean(_moving(model).mean(t, temperature)))
    return Sum(
        tuple(p for p in model.terms if not isinstance(p, Constant)) + (Constant(value=offset),),
        model.stages,
    )


def behind_mean(
    model: Sum,
    mean: float,
    n: int,
    fs: float,
    temperature: Array | None = None,
    shared: float = 0.0,
) -> float:
    """The level before the electronics of a record whose output has this mean: they differ where
    it is clipped or coarsely rounded.
    """
    chain = sorted(
        (s for s in model.stages if isinstance(s, (Saturation, Resolution))), key=lambda s: s.place
    )
    if not chain:
        return mean
    f = np.geomspace(fs / n, fs / 2, 4001)
    power = Sum(model.noise.terms, tuple(s for s in model.stages if s is model.low_pass)).psd(f, fs)
    sd = np.sqrt(np.trapezoid(power, f) + shared**2 * fs)
    moving = _moving(model)
    change = next((s for s in model.stages if isinstance(s, NoiseLevelChange)), None)
    count = 50 if moving.terms or change else 1  # one instant where nothing moves
    t = np.linspace(0, n - 1, count).astype(int)
    drift = moving.mean(t / fs, None if temperature is None else temperature[t])
    sd = sd * (np.ones(len(t)) if change is None else change.factor(n, fs)[t])
    u = np.linspace(-6, 6, 6001)
    weight = np.exp(-0.5 * u * u) / np.sum(np.exp(-0.5 * u * u))
    still = np.random.default_rng(0)  # these stages draw nothing

    def excess(level: float) -> float:
        x = level + (drift - drift.mean())[:, None] + sd[:, None] * u
        for stage in chain:
            x = stage.apply(x, fs, still)
        return float(np.mean(x @ weight)) - mean

    reach = max([3 * sd.max(), *(s.lsb for s in chain if isinstance(s, Resolution))])
    if excess(mean - reach) > 0 or excess(mean + reach) < 0:
        return mean
    return float(brentq(excess, mean - reach, mean + reach, xtol=1e-4 * reach))


def draw(model: Sum, draws: Draws, *, common: Array | None = None) -> np.ndarray:
    """A realisation of the model, shape (n,)."""
    slow, quick = draws.terms(model.terms, model.low_pass, model.tails)
    return model.behind(slow, quick, draws.fs, draws.rng("electronics"), common=common)


@dataclass(frozen=True)
class Beside:
    """What a channel has beside its own model: the density N of noise that it shares with others,
    the vibrations that it feels, and the step of the number format that it is printed in.
    """

    shared: float = 0.0
    vibrations: tuple[Vibration, ...] = ()
    digits: float | None = None

    def printed(self, x: Array) -> np.ndarray:
        """Samples as the file prints them, shape (n,)."""
        return x if self.digits is None else np.rint(x / self.digits) * self.digits


def simulate(
    jobs: Sequence[tuple[Any, ...]],
    n: int,
    fs: float,
    seeds: Iterable[Any],
    temperature: Array | None,
    levels: Iterable[float],
    filtered: bool = False,
) -> list[list[Battery]]:
    """Batteries of simulations: for each job (models, start, stop in samples, `Beside`, lost
    mask or None) one list over the seeds.

    A job has one model, or several that stand for what is uncertain in it: they take turns, by the
    last number of the seed. `filtered`: the shared noise enters before the low-pass filter.
    """
    t = np.arange(n) / fs
    ready = {}
    out: list[list[Battery]] = [[] for _ in jobs]
    for seed in seeds:
        draws, made = Draws(seed, n, fs, temperature), {}
        for k, ((models, start, stop, beside, lost), level) in enumerate(zip(jobs, levels)):
            model = models[seed[-1] % len(models)]
            key = (id(model), beside)
            if key not in made:
                if id(model) not in ready:
                    ready[id(model)] = centred(model, level, t, temperature)
                model = ready[id(model)]
                before = model.low_pass if filtered else None
                common = (
                    None
                    if not beside.shared
                    else beside.shared * draws.unit(WhiteNoise(N=1.0), 0, before, "common")
                )
                for i, vibration in enumerate(beside.vibrations):
                    (moved,) = vibration.on(n, fs, draws.rng("vibration", i)).values()
                    common = moved if common is None else common + moved
                x = draw(model, draws, common=common)
                made = {key: beside.printed(x)}
            x = made[key]
            if lost is not None:
                x = filled(np.where(lost, np.nan, x))
            part = x[start:stop]
            out[k].append(
                battery(part, fs, None if temperature is None else temperature[start:stop])
            )
    return out


def filled(x: Array) -> np.ndarray:
    """Missing samples replaced by straight lines, on the measurement and on the simulations
    alike.
    """
    bad = np.isnan(x)
    if not bad.any():
        return x
    at, out = np.flatnonzero(~bad), np.array(x)
    out[bad] = np.interp(np.flatnonzero(bad), at, x[at])
    return out


@dataclass(frozen=True)
class Index:
    """The gap index, whole and by domain."""

    value: float
    domains: dict[str, float]
    spread: float


def index(measured: Battery, rows: list[Battery]) -> Index:
    """Distance of the measurement from the ensemble over the median distance of one simulation
    from the others.

    Either is standardised by simulations that it is not itself one of. The distance is the root
    mean square over all statistics, some 190, in which those that move together count as one; a
    record's index scatters by 0.06 about 1 where the model is right (0.09 with spikes), a domain's
    own index, of a few statistics, by more.
    """
    many = stack(rows)
    domains = [d for d, s in many.items() if s.shape[1]]
    squares = {d: _squares(many[d], measured[d]) for d in domains}
    weight = _weights(np.concatenate([many[d] for d in domains], axis=1))
    ends = np.cumsum([0, *(many[d].shape[1] for d in domains)])
    own = {d: weight[i:j] for d, i, j in zip(domains, ends[:-1], ends[1:])}

    def ratio(which: list[str]) -> tuple[float, float]:
        total = sum(own[d].sum() for d in which)
        each = np.sqrt(sum(squares[d][0] @ own[d] for d in which) / total)
        median = float(np.median(each)) or 1.0  # 0 where all simulations agree
        return float(np.sqrt(sum(squares[d][1] @ own[d] for d in which) / total) / median), float(
            np.quantile(each, 0.95) / median
        )

    value, spread = ratio(domains)
    return Index(value, {d: ratio([d])[0] for d in domains}, spread)


def _weights(s: Array) -> np.ndarray:
    """What each statistic counts, shape (statistics,), from simulations of shape (simulations,
    statistics).

    The mean of correlated squares scatters the least, nearly, where each has the weight 1 / sum of
    its squared correlations with all; those that chance allows (1 %) are left out.
    """
    moves = s.std(axis=0) > 1e-6 * (1 + np.abs(s.mean(axis=0)))
    out = np.ones(s.shape[1])
    if moves.sum() > 1:
        alike = np.corrcoef(s[:, moves].T) ** 2
        out[moves] = 1.0 / np.sum(np.where(alike > min(6.6 / len(s), 0.9), alike, 0.0), axis=1)
    return out


def _squares(s: Array, measured: Array) -> tuple[np.ndarray, np.ndarray]:
    """Squared deviations of each simulation from the others, shape of `s` (simulations,
    statistics), and of the measurement from all.
    """
    count = len(s)
    mean, var = s.mean(axis=0), s.var(axis=0, ddof=1)
    own = s - mean
    # mean and variance of the others, from those of all
    others = np.maximum(((count - 1) * var - own**2 * count / (count - 1)) / (count - 2), 0.0)
    alike = np.sqrt(var) <= 1e-6 * (1 + np.abs(mean))
    near = np.where(
        alike,
        0.0,
        (own * count / (count - 1)) ** 2
        / np.where(others > 0, others, 1.0)
        / (1 + 1 / (count - 1)),
    )
    far = (measured - mean) ** 2 / np.where(alike, LEAST_SCATTER**2, var) / (1 + 1 / count)
    return np.minimum(near, 1e6), np.minimum(far, 1e6)
