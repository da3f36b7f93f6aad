"""A noise level that grows or falls over a good part of the record."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from imu_lib.arrays import Array
from imu_lib.processes import NoiseLevelChange as Stage

from .base import ChannelEffect, ChannelView, Finding
from .noise_level_change import unsteady
from .wandering_level import STEADY, Level, behaviour

#: Trial beginnings and lengths, shares of the record; the shortest is no sudden change.
BEGINNINGS = (0.0, 0.15, 0.3, 0.45, 0.6)
LENGTHS = (0.25, 0.4, 0.6, 0.8, 1.0)
#: Gain in log-likelihood that it has to bring, and what its three parameters are held against it.
GAIN, HANDICAP = 20.0, 6.0
#: Log-likelihood by which a shape of the 95 % interval is below the best, shapes that are tried,
#: and ratios about the best, in logarithms.
DROP, GRID, RATIOS = 0.5 * 3.84, 25, np.linspace(-0.4, 0.4, 9)
#: Log-likelihood that a beginning and an end within the record have to bring over a change that
#: goes on all the time: two parameters, at 95 %.
WHOLE = 0.5 * 5.99
#: Cosines of the record in which a change bends away from a straight one, standard deviations from
#: which on one is seen, and their share of the change at the most: more is no growing.
BENDS, SEEN, PART = 5, 3.0, 0.35
#: Trial shapes.
PLACES = len(BEGINNINGS) * len(LENGTHS)


class GradualLevel(ChannelEffect):
    name = "noise_level_change"
    key = "noise_level_change:gradual"
    alters = True
    #: Before the sudden change, which the catalogue knows by this name.
    order = 49
    cause = (
        "What makes the noise grows or fades through the record: the sensor warms up, a supply "
        "sags, something begins to shake."
    )
    domain = "stationarity"

    def candidates(self, view: ChannelView) -> list[Finding]:
        y, independent = view.y, view.smooth.independent
        if view.given is not None and view.given.find(self.name) is not None:
            return []
        before = unsteady(y, view.fs, independent)
        if before is None or before[0] > STEADY:
            return []
        level = Level(y, view.fs, independent)
        if level.k < 40:
            return []
        gain, process, spread, when = fitted(level, y, view)
        if gain < GAIN + HANDICAP:
            return []
        scale = process.factor(len(y), view.fs)
        path = np.log(scale[(np.arange(level.k) * level.m)])
        bent = _bent(level, path)
        scale = scale * np.exp(bent(np.arange(len(y))))
        after = unsteady(y / scale, view.fs, independent)
        if after is not None and after[0] < STEADY:
            return []
        uneven = ", faster and slower by turns" if np.any(bent(np.arange(level.k))) else ""
        start, stop = process.time, process.time + (process.duration or 0.0)
        ratio = process.ratio
        return [
            Finding(
                self,
                process,
                gain - HANDICAP,
                f"variance of the innovations: {behaviour(path, view.temperature, wholly=True)}, "
                f"from {max(start, 0.0):.0f} to {min(stop, len(y) / view.fs):.0f} s{uneven}",
                {"ratio": [ratio * np.exp(-1.96 * spread), ratio * np.exp(1.96 * spread)], **when},
                scale=scale,
                places=PLACES,
            )
        ]


def fitted(
    level: Level, y: Array, view: ChannelView
) -> tuple[float, Stage, float, dict[str, list[float]]]:
    """(gain over a steady level, the change, standard deviation of the logarithm of its ratio,
    95 % intervals of its beginning and its duration).
    """
    whole = len(y) / view.fs
    time = (np.arange(level.k) + 0.5) * level.step
    weight = level.m * view.smooth.independent

    def shape(begin: float, length: float) -> Array:
        return np.clip((time - begin) / length, 0.0, 1.0)

    def gain(ratio: float, s: Array) -> float:
        square = (1.0 + (np.exp(ratio) - 1.0) * s) ** 2
        mean = np.mean(level.energy / square)  # before the change
        return float(0.5 * weight * np.sum(np.log(np.mean(level.energy)) - np.log(mean * square)))

    def loss(v: Array) -> float:
        return -gain(v[0], shape(v[1] * whole, np.exp(v[2]) * whole))

    best = -np.inf, [0.0, 0.0, 0.0]
    for begin in BEGINNINGS:
        for length in LENGTHS:
            if begin + length > 1.01:
                continue
            s = shape(begin * whole, length * whole)
            centred = s - s.mean()
            ratio = float(centred @ level.log / (centred @ centred))
            value = gain(ratio, s)
            if value > best[0]:
                best = value, [ratio, begin, np.log(length)]
    bounds = ((-4.0, 4.0), (0.0, 0.8), (np.log(0.2), 0.0))
    options = {"xatol": 1e-3, "fatol": 1e-2, "maxiter": 200}
    r = minimize(loss, best[1], method="Nelder-Mead", bounds=bounds, options=options)
    plain = _all_the_time(loss, r.x)
    if loss(plain) < r.fun + WHOLE:
        r.x, r.fun = plain, loss(plain)
    centred = shape(r.x[1] * whole, np.exp(r.x[2]) * whole)
    centred = centred - centred.mean()
    spread = 1.0 / np.sqrt(max(2.0 * weight * float(centred @ centred), 1e-12))
    process = Stage(
        ratio=float(np.exp(r.x[0])),
        time=float(r.x[1] * whole),
        duration=float(np.exp(r.x[2]) * whole),
    )
    near = [
        (b, d)
        for b in np.r_[np.linspace(0.0, 0.8, GRID), r.x[1]]
        for d in np.r_[np.linspace(0.2, 1.0, GRID), np.exp(r.x[2])]
        if max(gain(g, shape(b * whole, d * whole)) for g in r.x[0] + RATIOS) > -r.fun - DROP
    ]
    begins, lengths = np.array(near).T * whole
    step = 0.8 * whole / (GRID - 1)  # an end lies between a shape that is in and one that is not
    when = {
        "time": [max(0.0, float(begins.min()) - step), float(begins.max()) + step],
        "duration": [float(lengths.min()) - step, min(whole, float(lengths.max()) + step)],
    }
    return -float(r.fun), process, float(spread), when


def _bent(level: Level, path: Array) -> Callable[[Array], Array]:
    """By how much the logarithm of the level bends away from the `path` (k,) of a straight change,
    at samples: its slowest cosines where they stand out, nothing where together they are no small
    part of the change.
    """
    whole = level.k * level.m
    centre = (np.arange(level.k) + 0.5) * level.m
    orders = np.arange(1, BENDS + 1)

    def cosines(at: Array) -> Array:
        return np.cos(np.pi * orders * np.minimum(at / whole, 1.0)[:, None])

    rest = level.log - path
    size = 2.0 / level.k * ((rest - rest.mean()) @ cosines(centre))
    size = np.where(np.abs(size) > SEEN * np.sqrt(2.0 * level.noise / level.k), size, 0.0)
    if np.std(cosines(centre) @ size) > PART * np.std(path):
        size = np.zeros(BENDS)
    return lambda at: cosines(at) @ size


def _all_the_time(loss: Callable[[Array], float], start: Array) -> Array:
    """The change (logarithm of its ratio, beginning, logarithm of its length, both in shares of the
    record) of least `loss` of those from the first sample to the last.
    """
    r = minimize_scalar(
        lambda v: loss(np.array([v, 0.0, 0.0])), bracket=(0.9 * start[0], 1.1 * start[0])
    )
    return np.array([float(r.x), 0.0, 0.0])


EFFECTS = (GradualLevel(),)
