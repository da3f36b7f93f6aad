"""A signal between two levels, decoded from noise and from a drift: expectation maximisation on a
hidden Markov chain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.fft import dct, idct
from scipy.special import expit

from imu_lib.arrays import Array
from imu_lib.gap import chain
from imu_lib.processes import Telegraph

#: Step in the logarithms of distance and rate over which the bend of the likelihood is measured.
BEND = 0.02
#: Rounds of the expectation maximisation.
ROUNDS = 12


def _cosines(x: Array) -> Array:
    """Orthonormal cosine transform of a series less its mean, shape (n,)."""
    return dct(x - x.mean(), norm="ortho")


def _amplitude(y: Array, w: Array, v: float, var: float, quiet: Any) -> tuple[float, float]:
    """Distance of the two levels by generalised least squares of `y` on the expected states `w` -
    of variance `v` each - and its standard deviation; `quiet` is the share of white noise, of
    variance `var`, in the noise at each ordinate.

    `y` and `w` are given by their cosine transforms.
    """
    square = max(float(np.sum(quiet * w**2) + v * np.mean(quiet) * len(w)), 1e-300)
    return float(np.sum(quiet * y * w)) / square, float(np.sqrt(var / square))


def _beyond_spectrum(
    y: Array, rest: Array, w: Array, a: float, flip: float, ll: float, var: float, quiet: Any
) -> float:
    """Log-likelihood of two levels beyond that of the Gaussian process of the same spectrum.

    The first is a lower bound: the expectation over the paths, of probability `ll` under white
    noise of variance `var` in `rest` = `y` less its drift, of the likelihood of `y` under the noise
    with its drift, less their divergence from what the flips foretell. The second is Whittle's, on
    the same cosine transform. Equal where the noise is white.
    """
    n = len(y)
    power, left = _cosines(y)[1:] ** 2, _cosines(y - a * w)[1:] ** 2
    noise = var / np.broadcast_to(quiet, n)[1:]
    unknown = 0.5 * a * a * np.mean(1 / noise) * np.sum(0.25 - w**2)
    levels = (
        0.5 * np.sum((power - left) / noise) - unknown + ll - np.sum(a * rest * w - a * a / 8) / var
    )
    phi = 1 - 2 * flip
    both = (
        noise
        + 0.25
        * a
        * a
        * (1 - phi * phi)
        / np.abs(1 - phi * np.exp(-1j * np.pi * np.arange(1, n) / n)) ** 2
    )
    return float(levels + 0.5 * np.sum(np.log(both / noise) + power / both - power / noise))


@dataclass(frozen=True, eq=False)
class TwoLevels:
    """Two levels as they were decoded.

    Attributes
    ----------
    process : processes.Telegraph
    signal : ndarray, shape (n,)
        One path of those that the record leaves open, at random: their mean would follow the noise,
        of which less were left than there is.
    unknown : float
        Share of the levels' variance that the noise leaves unknown.
    flips : float
        Expected number of flips.
    beyond : float
        Log-likelihood beyond that of a Gauss-Markov process of the same spectrum.
    sd : float
        Standard deviation of the distance of the levels, by least squares.
    left : ndarray, shape (k,)
        The record in means over `step` s, less its drift and middle.
    step : float, s
    variance : float
        Of the white noise in these means.
    states : ndarray, shape (k,)
        Probability of the upper level in each of them.
    """

    process: Telegraph
    signal: np.ndarray
    unknown: float
    flips: float
    beyond: float
    sd: float
    left: np.ndarray
    step: float
    variance: float
    states: np.ndarray

    def differs(self, given: Telegraph, duration: float) -> float:
        """Log-likelihood by which their distance or their flips speak against a `given`
        telegraph.
        """
        distance = np.log(self.process.amplitude / given.amplitude) / self.spread()[0]
        expected, flips = given.rate * duration, max(self.flips, 1e-3)
        return float(max(0.5 * distance**2, flips * np.log(flips / expected) - flips + expected))

    def dwells(self) -> list[tuple[int, int]]:
        """(first, one behind the last) of the means on one level, one after the other."""
        upper = self.states > 0.5
        edge = np.flatnonzero(upper[1:] != upper[:-1]) + 1
        return list(zip([0, *edge.tolist()], [*edge.tolist(), len(upper)]))

    def own_levels(self) -> float:
        """Log evidence for a level of its own in each dwell, a step to it each time, against two
        levels in turn: the means of the dwells about that of their level, under a prior as wide as
        the jumps.
        """
        dwells, total = self.dwells(), 0.0
        for same in (dwells[::2], dwells[1::2]):
            size = np.array([last - first for first, last in same], float)
            mean = np.array([self.left[first:last].mean() for first, last in same])
            if len(same) < 2:
                continue
            sharp = self.process.amplitude**2 * size / self.variance
            chi = (mean - np.average(mean, weights=size)) ** 2 * size / self.variance
            total += float(np.sum(0.5 * (chi * sharp / (1.0 + sharp) - np.log1p(sharp))))
            total += 0.5 * float(np.log1p(sharp.max()))  # one of the levels is free in either
        return total

    def spread(self) -> tuple[float, float]:
        """Standard deviations of the logarithms of distance and rate, from the bend of the
        likelihood of the chain: counted flips say how often, but where the noise is loud not
        surely when, nor how many in a row.
        """

        def log_likelihood(u: float, v: float) -> float:
            flip = _flips(self.process.rate * np.exp(v), self.step)
            return chain.posterior(
                self.left, self.process.amplitude * np.exp(u), flip, self.variance
            )[1]

        h, top = BEND, log_likelihood(0.0, 0.0)
        bend = np.empty((2, 2))
        for k, (u, v) in enumerate(((h, 0.0), (0.0, h))):
            bend[k, k] = log_likelihood(u, v) - 2 * top + log_likelihood(-u, -v)
        bend[0, 1] = bend[1, 0] = 0.25 * (
            log_likelihood(h, h)
            - log_likelihood(h, -h)
            - log_likelihood(-h, h)
            + log_likelihood(-h, -h)
        )
        # the counted flips and the least squares are all that there can be known
        least = np.array([self.sd / self.process.amplitude, 1.0 / np.sqrt(max(self.flips, 1.0))])
        size, axes = np.linalg.eigh(-bend / h**2)
        if size.min() <= 0:  # it does not bend: no maximum of its own
            return float(least[0]), float(least[1])
        sd = np.sqrt(np.sum(axes**2 / size, axis=1))
        return float(max(sd[0], least[0])), float(max(sd[1], least[1]))


def _flips(rate: float, step: float) -> float:
    """Probability that the level is another one `step` s later."""
    return float(0.5 * -np.expm1(-2 * rate * step))


def _in_means(x: Array, fs: float, start: Telegraph, density: float) -> tuple[Array, int]:
    """The record in means less the middle between its levels, and the samples in each: a small part
    of a dwell, and no longer than it takes to see on which level the signal is.
    """
    seen = 2.0 * density * fs / start.amplitude**2
    q = int(max(1, min(round(fs / (12 * start.rate)), seen, len(x) // 64)))
    k = len(x) // q
    y = x[: k * q].reshape(k, q).mean(axis=1)
    return y - 0.5 * (np.quantile(y, 0.1) + np.quantile(y, 0.9)), q


def _beside_walk(y: Array, a: float, flip: float, var: float, gain: Array) -> Array:
    """Probability of the upper level, shape (n,), before the drift of Wiener `gain` is known: from
    the jumps alone, beside the walk that is as loud as the white noise at the same ordinate.

    Before its first jump a level is known from the end of the record only, after the last from its
    start.
    """
    walk = var * (np.pi * np.count_nonzero(gain > 0.5) / len(y)) ** 2
    forward = chain.followed(y, a, flip, var, walk)
    back = np.ascontiguousarray(y[::-1])  # of another layout it would be compiled once more
    backward = chain.followed(back, a, flip, var, walk)[::-1]
    return np.asarray(expit(forward + backward))


def decoded(
    x: Array,
    fs: float,
    start: Telegraph,
    density: float,
    drift_gain: Callable[[int, float], Array] | None = None,
    *,
    rounds: int = ROUNDS,
    fixed: bool = False,
) -> TwoLevels | None:
    """Two levels by expectation maximisation, or None where they are lost on the way.

    Parameters
    ----------
    x : ndarray, shape (n,)
    fs : float, Hz
    start : processes.Telegraph
    density : float
        N^2 of the white noise.
    drift_gain : callable, optional
        Of (size, rate): the Wiener gain of the model's own drift on a real transform of `size`
        points at a decimated rate.
    fixed : bool
        Their distance and their rate stay as they start.
    """
    y, q = _in_means(x, fs, start, density)
    k, var = len(y), density * fs / q
    a, rate, middle, drift = start.amplitude, start.rate, 0.0, np.zeros(k)
    gain = None if drift_gain is None else drift_gain(2 * k, fs / q)[:k]
    waves = _cosines(y)
    # share of the noise that is white at each ordinate
    quiet = 1.0 if gain is None else 1.0 - gain
    if gain is not None:
        s = _beside_walk(y, a, _flips(rate, q / fs), var, gain)
        drift = idct((waves - a * _cosines(s - 0.5)) * gain, norm="ortho")
    for _ in range(rounds):
        if not (np.isfinite(a) and a > 0):
            return None
        s, _, flips = chain.posterior(y - drift - middle, a, _flips(rate, q / fs), var)
        rest = y - drift
        if min(np.sum(s), np.sum(1 - s)) < 2:
            return None
        states = _cosines(s - 0.5)
        own, sd = _amplitude(waves, states, np.mean(s * (1 - s)), var, quiet)
        middle = 0.5 * (np.average(rest, weights=s) + np.average(rest, weights=1 - s))
        seldom, often = 2.0 * fs / len(x), fs / q / 4
        rate = -0.5 * np.log1p(-2 * min(flips / (k - 1), 0.45)) * fs / q
        a, rate = (a, start.rate) if fixed else (own, float(np.clip(rate, seldom, often)))
        if gain is not None:
            drift = idct((waves - a * states) * gain, norm="ortho")
    if not (np.isfinite(a) and a > 0):  # the last round may have lost the levels
        return None
    left, flip = y - drift - middle, _flips(rate, q / fs)
    s, ll, flips = chain.posterior(left, a, flip, var)
    beyond = _beyond_spectrum(y, left, s - 0.5, a, flip, ll, var, quiet)
    path = chain.path(left, a, flip, var, np.random.default_rng(k).random(k))
    signal = a * (path[np.minimum(np.arange(len(x)) // q, k - 1)] - 0.5)
    process = Telegraph(amplitude=float(a), rate=rate)
    unknown = float(4 * np.mean(s * (1 - s)))
    return TwoLevels(process, signal, unknown, float(flips), beyond, sd, left, q / fs, var, s)
