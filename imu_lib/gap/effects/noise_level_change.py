"""A change of the noise level at one instant."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import chi2

from imu_lib.arrays import Array
from imu_lib.processes import NoiseLevelChange as Stage

from .base import ChannelEffect, ChannelView, Effect, Finding

#: Gain in log-likelihood of a change of level. Twice its largest value over all instants exceeds u
#: with a probability of about ln(n^2) sqrt(u / 2 pi) exp(-u / 2) (Csorgo and Horvath 1997, Theorem
#: 1.3.1): 1e-4 for an hour at 100 Hz.
MIN_GAIN = 13.0
#: Seconds, and share of the record, before and after a change at the least: a louder second at the
#: end is somebody who stops the logger, and no level that stays.
STAYS = (3.0, 0.02)
#: Logarithm of a ratio below which a name is no more than even.
SMALL, SMALL_SURE = 0.04, 0.5
#: Block lengths over which the noise has to keep its level, s, and parts of a record that is too
#: short for the first of these; blocks at the least, and samples in one.
SCALES, PARTS = (5.0, 20.0, 60.0, 300.0), (40, 12)
LEAST_BLOCKS, LEAST_SAMPLES = 8, 24
#: Share of the variance of the block energies that a loud stretch explains, and share of the record
#: that it lasts at the most.
EXPLAINED, MOST_LOUD = 0.6, 0.5
#: Blocks among which it is looked for.
MOST_BLOCKS = 300


def energies(y: Array, fs: float, seconds: float) -> tuple[Array, int]:
    """Mean square of a white series in blocks, and the degrees of freedom of each."""
    m = max(1, int(round(seconds * fs)))
    k = len(y) // m
    return np.mean((y[: k * m] ** 2).reshape(k, m), axis=1), m


def unsteady(y: Array, fs: float, independent: float = 1.0) -> tuple[float, str] | None:
    """(log10 of the p-value, where) of the worst scale at which the mean square wanders more than
    chance; None below three blocks.

    `independent` is the share of the samples that are independent of one another. Two tests at
    each scale: dispersion of the block energies, and the largest line in their periodogram.
    """
    worst, of_worst = (0.0, ""), (np.zeros(0), 0.0)
    kurt = max(
        np.mean(y**4) / np.mean(y**2) ** 2 - 1.0, 0.5
    )  # variance of y^2 in units of its mean
    for seconds in _scales(len(y), fs):
        e, m = energies(y, fs, seconds)
        k, free = len(e), m * independent
        if k < LEAST_BLOCKS:
            continue
        z = (e / e.mean() - 1.0) * np.sqrt(free / kurt)
        log_p = chi2.logsf(np.sum(z**2), k - 1) / np.log(10)
        line = (
            np.abs(np.fft.rfft(z - z.mean()))[1 : (k + 1) // 2] ** 2 / k
        )  # the last ordinate of an even number has no phase
        log_line = (np.log(len(line)) - line.max()) / np.log(10)
        low = min(log_p, log_line)
        if low < worst[0]:
            of_worst = e, seconds
            wander, chance = 100 * np.std(e) / e.mean(), 100 * np.sqrt(kurt / free)
            worst = (
                low,
                f"variance of the innovations over {seconds:g} s: it wanders by {wander:.2g} % "
                f"where chance allows {chance:.2g} %",
            )
    return (worst[0], worst[1] + _loudest(*of_worst)) if worst[1] else None


def _loudest(e: Array, seconds: float) -> str:
    """From when to when the noise is louder than in the rest of the record, where two levels
    explain its block energies `e` for the most part.
    """
    join = -(-len(e) // MOST_BLOCKS)
    e = e[: len(e) // join * join].reshape(-1, join).mean(axis=1)
    k, c, seconds = len(e), np.concatenate([[0.0], np.cumsum(e)]), seconds * join
    i, j = np.triu_indices(k + 1, 1)
    keep = (j - i <= MOST_LOUD * k) & (j - i < k)
    i, j = i[keep], j[keep]
    inside, count = c[j] - c[i], j - i
    on, off = inside / count, (c[-1] - inside) / (k - count)
    explained = count * (k - count) / k * (on - off) ** 2
    best = int(np.argmax(np.where(on > off, explained, -1.0)))
    if explained[best] < EXPLAINED * np.sum((e - e.mean()) ** 2):
        return ""
    return (
        f", loudest from {i[best] * seconds:.0f} to {j[best] * seconds:.0f} s, "
        f"{np.sqrt(on[best] / off[best]):.2g} times the rest"
    )


def _scales(n: int, fs: float) -> tuple[float, ...]:
    """Block lengths for a record of `n` samples, s."""
    if n / fs >= LEAST_BLOCKS * SCALES[0]:
        return SCALES
    return tuple(n / fs / part for part in PARTS if n >= LEAST_SAMPLES * part)


def change_point(y: Array, independent: float = 1.0, edge: int = 20) -> tuple[float, int, float]:
    """(gain, index, ratio) of the best single change of variance of a white series, to the sample,
    with `edge` samples on either side of it.

    Where the series has heavier shoulders than a normal one (a few levels of a coarse grid), its
    energy scatters more and the gain counts for less.
    """
    n = len(y)
    square = np.minimum(y**2, 25.0)  # a spike that was left over is no change of level
    c = np.cumsum(square)
    total = c[-1]
    k = np.arange(edge, n - edge)
    a, b = c[k - 1] / k, (total - c[k - 1]) / (n - k)
    gain = 0.5 * (n * np.log(total / n) - k * np.log(a) - (n - k) * np.log(b))
    i = int(np.argmax(gain))
    kurt = np.mean((square / np.where(np.arange(n) < k[i], a[i], b[i])) ** 2) - 1.0
    return (
        float(independent * gain[i] * 2.0 / max(kurt, 2.0)),
        int(k[i]),
        float(np.sqrt(b[i] / a[i])),
    )


class NoiseLevelChange(ChannelEffect):
    name = "noise_level_change"
    alters = True
    cause = "The gain, the supply or the vibration around the sensor changed at one instant."
    domain = "stationarity"

    def candidates(self, view: ChannelView) -> list[Finding]:
        independent = view.smooth.independent
        found = self.detect(view.y, view.fs, independent)
        if found is None:
            return []
        if found.doubt is None and view.given is not None:
            found = self.anchored(found, view.y, view.fs, view.model_level, independent)
        found.scale = found.process.factor(len(view.y), view.fs)
        return [found]

    def most_sure(self, parameters: dict[str, Any], beside: list[Effect], shared: float) -> float:
        # levels of recorded signals wander by as much through what surrounds the sensor
        return SMALL_SURE if abs(np.log(parameters["ratio"])) < SMALL else 1.0

    def detect(self, y: Array, fs: float, independent: float = 1.0) -> Finding | None:
        """`y` is the whitened fast noise, a share of whose samples is `independent`."""
        n = len(y)
        edge = max(20, n // 400)
        gain, k, ratio = change_point(y, independent, edge)
        if gain < MIN_GAIN:
            return None
        stays = int(min(STAYS[0] * fs, STAYS[1] * n))
        if min(k, n - k) < stays:
            gain, k, ratio = change_point(y, independent, stays)
            if gain < MIN_GAIN or min(k, n - k) < 2 * stays:  # the rest of the loud end
                return None
        sd = np.sqrt((0.5 / k + 0.5 / (n - k)) / independent)
        slack = self._time_slack(y, k, independent)
        after = y.copy()
        after[k:] /= ratio
        found = Finding(
            self,
            Stage(ratio=ratio, time=k / fs),
            gain,
            f"variance of the innovations: {20 * np.log10(ratio):+.2f} dB from {k / fs:.1f} s on",
            {
                "ratio": [ratio * np.exp(-1.96 * sd), ratio * np.exp(1.96 * sd)],
                "time": [(k - slack) / fs, (k + slack) / fs],
            },
        )
        found.places = 2.0 * np.log(n) * np.sqrt(gain / np.pi)
        left = unsteady(after, fs, independent)
        if left is not None and left[0] < -5:
            found.doubt = left[1]
        return found

    @staticmethod
    def anchored(
        found: Finding, y: Array, fs: float, level: float, independent: float = 1.0
    ) -> Finding:
        """The change measured from the given model's level where the noise before it has that
        level.

        `level` is the variance of `y` as a multiple of the model's.
        """
        k = int(round(found.process.time * fs))
        before, after = level * np.mean(y[:k] ** 2), level * np.mean(y[k:] ** 2)
        if abs(before - 1.0) > 4.0 * np.sqrt(2.0 / (k * independent)):
            return found
        ratio, sd = float(np.sqrt(after)), np.sqrt(0.5 / ((len(y) - k) * independent))
        return replace(
            found,
            process=found.process.with_(ratio=ratio),
            intervals={
                **found.intervals,
                "ratio": [ratio * np.exp(-1.96 * sd), ratio * np.exp(1.96 * sd)],
            },
        )

    @staticmethod
    def _time_slack(y: Array, k: int, independent: float) -> float:
        """Half width, in samples, of the range of change points within 2.5 of the best
        log-likelihood.
        """
        n = len(y)
        c = np.cumsum(y**2)
        edge = max(20, n // 400)
        i = np.arange(edge, n - edge)
        a, b = c[i - 1] / i, (c[-1] - c[i - 1]) / (n - i)
        gain = -0.5 * independent * (i * np.log(a) + (n - i) * np.log(b))
        near = i[gain > gain.max() - 2.5]
        return float(max(abs(near.min() - k), abs(near.max() - k), 1))


EFFECTS = (NoiseLevelChange(),)
