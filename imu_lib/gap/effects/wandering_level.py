"""A noise level that wanders."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, toeplitz
from scipy.optimize import minimize
from scipy.stats import gamma, spearmanr

from imu_lib.arrays import Array
from imu_lib.processes import WanderingLevel as Stage

from .base import ChannelEffect, ChannelView, Effect, Finding
from .noise_level_change import SMALL, SMALL_SURE, unsteady

#: Blocks whose energies are looked at, and samples in a block at the least.
BLOCKS, SHORTEST = 600, 24
#: Gain in log-likelihood that it has to bring, and what two parameters more than a single change
#: are held against it.
GAIN, HANDICAP = 20.0, 8.0
#: log10 p of an unsteady level beyond which it does more than wander.
STEADY = -5.0
#: Blocks that the correlation time has to span: what ends within one is a burst, or the edge of
#: something in the signal itself.
RESOLVED = 2.0
#: Share of a block's largest samples that the level is told without, and how much of it the others
#: have to show.
LARGEST, SPREAD = 0.1, 0.6
#: Rank correlation of the level with time from which on it only grows, or falls, and with the
#: temperature, from which on it follows that.
ONE_WAY, FOLLOWS = 0.9, 0.9
#: log10 p of a peak in the spectrum of the level below which it is periodic; ordinates it may fill,
#: and on either side of it what it is compared with.
PERIODIC, WIDTHS, BESIDE = -4.0, (1, 3, 9), 12


class Level:
    """The logarithm of the level of a white series `y` (n,) as a Gauss-Markov process seen through
    the energies of blocks.
    """

    def __init__(self, y: Array, fs: float, independent: float) -> None:
        self.m = max(SHORTEST, len(y) // BLOCKS)
        self.k = len(y) // self.m
        part = y[: self.k * self.m].reshape(self.k, self.m)
        self.energy = np.maximum(np.mean(part**2, axis=1), 1e-12)
        small = np.sort(part**2, axis=1)[:, : self.m - max(1, int(LARGEST * self.m))]
        self.small = 0.5 * np.log(np.maximum(np.mean(small, axis=1), 1e-12))
        self.log = 0.5 * np.log(self.energy)
        kurtosis = np.mean(part**4) / np.mean(self.energy**2) * (self.m + 2) / self.m
        self.noise = 0.25 * max(kurtosis - 1.0, 1.0) / (self.m * independent)
        self.step = self.m / fs
        self.ones = np.ones(self.k)

    def covariance(self, sd: float, time: float) -> Array:
        """First column of the covariance of the blocks' logarithms, without their own noise."""
        return sd**2 * np.exp(-np.arange(self.k) * self.step / time)

    def loss(self, v: Array) -> float:
        """Half of -2 log L at (log sd, log correlation time)."""
        column = self.covariance(*np.exp(v))
        column[0] += self.noise
        factor = cho_factor(toeplitz(column), lower=True)
        z = cho_solve(factor, np.column_stack([self.log, self.ones]))
        mean = (self.ones @ z[:, 0]) / (self.ones @ z[:, 1])
        rest = self.log - mean
        return float(np.sum(np.log(np.diag(factor[0]))) + 0.5 * rest @ (z[:, 0] - mean * z[:, 1]))

    def fit(self) -> tuple[float, float, Array]:
        """(sd, correlation time, sd of their logarithms (2,)) of the maximum, or None."""
        longest = self.k * self.step / 3
        best: Any = None  # scipy.optimize.OptimizeResult
        for time in np.geomspace(2 * self.step, longest, 5):
            start = [np.log(max(np.std(self.log), 1e-3)), np.log(time)]
            r = minimize(
                self.loss,
                start,
                method="Nelder-Mead",
                options={"xatol": 0.02, "fatol": 0.02, "maxiter": 60},
                bounds=((-7, 1.5), (np.log(self.step), np.log(longest))),
            )
            if best is None or r.fun < best.fun:
                best = r
        h, curve = 0.1, []
        for i in range(2):
            e = h * (np.arange(2) == i)
            curve.append((self.loss(best.x + e) - 2 * best.fun + self.loss(best.x - e)) / h**2)
        return *np.exp(best.x), 1.0 / np.sqrt(np.maximum(curve, 0.05))

    def smoothed(self, sd: float, time: float) -> tuple[Array, Array]:
        """The logarithm of the level of each block: with its own energy, and from the others alone;
        shapes (k,).
        """
        c = toeplitz(self.covariance(sd, time))
        whole = cho_factor(c + self.noise * np.eye(self.k), lower=True)
        weight = cho_solve(whole, c).T
        mean = np.mean(self.log)
        level = weight @ (self.log - mean)
        own = np.diag(weight)
        return mean + level, mean + (level - own * (self.log - mean)) / (1 - own)

    def shown(self, foretold: Array) -> float:
        """By how much of what the other blocks foretell the smaller samples of a block are louder:
        1 where all of the noise is, near 0 where a few samples are.
        """
        z = foretold - np.mean(foretold)
        return float(z @ self.small / max(z @ z, 1e-300))

    def period(self, sd: float, time: float) -> tuple[float, float]:
        """(log10 of the p-value, period in s) of the most striking peak in the spectrum of the
        level.

        A peak stands out of the periodogram that a Gauss-Markov level would have, and out of the
        ordinates on both sides: a level that falls off in another way has none.
        """
        k, ordinates = self.k, np.arange(self.k // 2 + 1)
        window = np.sin(np.pi * (np.arange(k) + 0.5) / k)
        power = np.abs(np.fft.rfft(window * (self.log - np.mean(self.log)))) ** 2
        column = self.covariance(sd, time)
        column[0] += self.noise
        lags = column * np.correlate(window, window, "full")[k - 1 :]
        model = 2.0 * np.fft.rfft(lags).real - lags[0]
        best = (0.0, np.inf)
        for width in WIDTHS:
            half = width // 2
            # neighbours under a sine window have the correlation 1/4
            free = width / (1.0 + 0.5 * (1.0 - 1.0 / width))
            for i in ordinates[4 + half : len(ordinates) - half - 1]:
                low, high = i - half - 2, i + half + 3
                sides = power[max(1, low - BESIDE) : low], power[high : high + BESIDE]
                around = [np.median(p) / np.log(2) for p in sides if len(p)]
                near = slice(i - half, i + half + 1)
                ratio = np.mean(power[near] / np.maximum(model[near], max(around, default=0.0)))
                log_p = (gamma.logsf(free * ratio, free) + np.log(len(ordinates))) / np.log(10)
                if log_p < best[0]:
                    best = float(log_p), k * self.step / i
        return best


class WanderingLevel(ChannelEffect):
    name = "wandering_level"
    cause = (
        "What makes the noise rises and falls slowly: the surroundings shake more and less, a "
        "supply or a temperature moves the gain."
    )
    domain = "stationarity"

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        # what surrounds a sensor changes the level of its noise by as much
        return SMALL_SURE if parameters["sd"] < SMALL else 1.0

    def candidates(self, view: ChannelView) -> list[Finding]:
        y, independent = view.y, view.smooth.independent
        before = unsteady(y, view.fs, independent)
        if before is None or before[0] > STEADY:
            return []
        if view.given is not None and view.given.find(self.name) is not None:
            return []
        level = Level(y, view.fs, independent)
        if level.k < 40:
            return []
        sd, time, spread = level.fit()
        known, foretold = level.smoothed(sd, time)
        if time < RESOLVED * level.step or level.shown(foretold) < SPREAD:
            return []
        gain = (
            independent
            * level.m
            * float(
                np.sum(
                    0.5 * (np.log(np.mean(level.energy)) - 2 * foretold)
                    + 0.5 * level.energy * (1 / np.mean(level.energy) - np.exp(-2 * foretold))
                )
            )
        )
        if gain < GAIN + HANDICAP:
            return []
        centre = (np.arange(level.k) + 0.5) * level.m
        scale = np.exp(np.interp(np.arange(len(y)), centre, known))
        scale /= np.sqrt(np.mean(scale**2))
        found = Finding(
            self,
            Stage(sd=float(sd), correlation_time=float(time)),
            gain - HANDICAP,
            f"variance of the innovations: {behaviour(known, view.temperature)}, over {time:.3g} s",
            {
                "sd": [sd * np.exp(-1.96 * spread[0]), sd * np.exp(1.96 * spread[0])],
                "correlation_time": [
                    time * np.exp(-1.96 * spread[1]),
                    time * np.exp(1.96 * spread[1]),
                ],
            },
            scale=scale,
        )
        after = unsteady(y / scale, view.fs, independent)
        if after is not None and after[0] < STEADY:
            found.doubt = after[1]
        periodic, period = level.period(sd, time)
        if periodic < PERIODIC:
            found.doubt = (
                "variance of the innovations: the noise rises and falls with a period of "
                f"{period:.3g} s"
            )
        return [found]


#: What a level may do, as its sentence says.
GROWS, FALLS, WANDERS = "the noise grows", "the noise falls", "the noise rises and falls"
#: And how it may go with the temperature.
WITH, AGAINST = "as the temperature does", "against the temperature"


def behaviour(known: Array, temperature: Array | None = None, *, wholly: bool = False) -> str:
    """What the logarithm of a level, `known` in blocks (k,), does over the record, and whether the
    temperature (n,) does the same; `wholly`: from its first to its last value.
    """
    level = np.exp(known - np.mean(known))
    low, high = np.quantile(level, [0.0, 1.0] if wholly else [0.025, 0.975])
    trend = float(spearmanr(np.arange(len(known)), known).statistic)
    if abs(trend) < ONE_WAY:
        text = f"{WANDERS} between {low:.2g} and {high:.2g} times its usual level"
    else:
        first, last, way = (low, high, GROWS) if trend > 0 else (high, low, FALLS)
        text = f"{way} from {first:.2g} to {last:.2g} times its usual level"
    if temperature is not None and np.ptp(temperature) > 0:
        means = [np.mean(part) for part in np.array_split(temperature, len(known))]
        alike = float(spearmanr(means, known).statistic)
        if abs(alike) > FOLLOWS:
            text += f", {WITH if alike > 0 else AGAINST}"
    return text


def in_short(where: str) -> str:
    """What the level does, of the sentence of a finding."""
    way = next((text for text in (GROWS, FALLS) if text in where), WANDERS)
    also = next((f" {text}" for text in (WITH, AGAINST) if text in where), "")
    return way + also


EFFECTS = (WanderingLevel(),)
