"""Single samples thrown off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.special import log_ndtr, ndtr
from scipy.stats import chi2, kstest

from imu_lib.arrays import Array
from imu_lib.processes import Spikes as Stage
from imu_lib.samples import two_noises
from imu_lib.samples.innovations import Smooth
from imu_lib.samples.outliers import loudest, spike_odds
from imu_lib.samples.student_spikes import beyond
from imu_lib.samples.student_spikes import odds as odds_beyond

from . import heavy_tails as tails
from .base import Effect, Finding

#: From here on a surprise is looked at as a spike of its own, standard deviations.
OUTLIER = 5.0
#: Samples that a spike makes surprising, on the mean, from which on the smallest are not counted
#: one by one.
TRACES = 3.0
#: Gain and height, in standard deviations, of spikes beside heavy tails at the least.
BESIDE, FAR = 20.0, 8.0
#: Share of the samples from which on outliers that are no spikes are looked at as a second noise.
FEW = 0.005
#: Share of the samples beyond which what is thrown off is no longer single samples.
MANY = 0.1
#: Standard deviations by which a surprise and the opposite that follows may differ, such pairs at
#: the least, and their share of the outliers.
TWINS, PAIRS, MOSTLY = 5.0, 3, 0.6
#: Classes of height, standard deviations, and log10 of the p-value below which a mixture of two
#: normals does not fill them.
EDGES, SHAPE = (
    np.array([1.0, 1.5, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 4.5, 5.0, 6.0, 8.0, 11.0, 15.0, np.inf]),
    -5.0,
)


def opposites(y: Array) -> np.ndarray:
    """Surprises that their opposite follows, indices; none where these are the fewer: what is
    thrown off before increments are taken is given back by the next one.
    """
    s = 1.4826 * np.median(np.abs(y))
    far = np.abs(y) > OUTLIER * s
    alike = np.abs(y[:-1] + y[1:]) < TWINS * s
    plain = np.flatnonzero(_first(far[:-1] & far[1:] & alike))
    if len(plain) < PAIRS or 2 * len(plain) < MOSTLY * far.sum():
        return plain[:0]
    # both together stand out where neither does
    return np.flatnonzero(_first((np.abs(y[:-1] - y[1:]) > np.sqrt(2) * OUTLIER * s) & alike))


def _first(twins: Array) -> np.ndarray:
    """Of pairs that share a sample the first, mask (n,)."""
    out = np.array(twins)
    for k in np.flatnonzero(twins[1:] & twins[:-1]) + 1:
        out[k] = out[k] and not out[k - 1]
    return out


def mixture(y: Array) -> tuple[float, float, float, float]:
    """(gain, probability, scale, curvature) of the best mixture of N(0, 1) and N(0, 1 + scale^2)
    for the surprises `y`.
    """
    s = 1.4826 * np.median(np.abs(y))
    y2 = np.sort((y / s) ** 2)
    n = len(y2)
    cut = max(n - n // 20, 0)
    far, near = y2[cut:], y2[: cut : max(1, cut // 4000)]
    weight = cut / max(len(near), 1)

    def loss(v: Array) -> float:
        none, one, a = -np.logaddexp(0.0, v[0]), -np.logaddexp(0.0, -v[0]), np.exp(2 * v[1])

        def ll(z: Array) -> Array:
            return np.logaddexp(none, one - 0.5 * np.log1p(a) + 0.5 * z * a / (1 + a))

        return -(ll(far).sum() + weight * ll(near).sum())

    best: Any = None  # scipy.optimize.OptimizeResult
    outliers = far[far > OUTLIER**2]
    k = max(len(outliers), 1)
    scale = np.sqrt(np.mean(outliers)) if len(outliers) else 5.0
    for p0, s0 in ((k / n * 1.5, scale), (0.02, 2.0)):
        r = minimize(
            loss,
            [np.log(p0 / (1 - p0)), np.log(max(s0, 1.0))],
            method="Nelder-Mead",
            options={"xatol": 1e-3, "fatol": 1e-2, "maxiter": 200},
        )
        if best is None or r.fun < best.fun:
            best = r
    return -best.fun, 1 / (1 + np.exp(-best.x[0])), float(np.exp(best.x[1])), s


def normal_gain(y: Array, s: float) -> float:
    """Log-likelihood of N(0, s^2) for `y` less that of the best normal distribution, shape (n,)."""
    ratio = float(np.mean(y * y)) / s**2
    return 0.5 * len(y) * (1.0 + np.log(ratio) - ratio)


def exceedances(y: Array, s: float) -> tuple[float, float, float, float]:
    """As `mixture`, from the surprises beyond `OUTLIER` times `s` alone.

    In strongly coloured noise a spike too small to be taken out on its own leaves traces on many
    samples, which the shoulders would count as spikes of their own.
    """
    far = np.abs(y[np.abs(y) > OUTLIER * s]) / s
    n, k = len(y), len(far)
    if k < 2:
        return 0.0, 1.0 / n, OUTLIER, s

    def loss(log_scale: float) -> float:
        wide = np.sqrt(1 + np.exp(2 * log_scale))
        return k * (np.log(wide) + log_ndtr(-OUTLIER / wide)) + 0.5 * np.sum(far**2) / wide**2

    scale = float(
        np.exp(minimize_scalar(loss, method="bounded", bounds=(0.0, np.log(4 * far.max()))).x)
    )
    wide = np.sqrt(1 + scale**2)
    p = min(k / n / (2 * ndtr(-OUTLIER / wide)), 0.2)
    gain = np.sum(
        np.logaddexp(np.log1p(-p), np.log(p) - np.log(wide) + 0.5 * (far * scale / wide) ** 2)
    )
    return float(gain), p, scale, s


def shape(height: Array, tail: Callable[[float], Array | float]) -> float:
    """log10 of the p-value of the heights from one standard deviation on against `tail`, the share
    expected beyond each.

    Two per cent of every class are allowed for the whitening, and fifteen for what is missing:
    differenced rounding errors are flatter than normal ones.
    """
    count = np.histogram(height, EDGES)[0]
    beyond = np.array([tail(e) for e in EDGES[:-1]] + [0.0])
    want = len(height) * -np.diff(beyond)
    slack = np.where(count < want, 0.15, 0.02)
    return float(
        chi2.logsf(np.sum((count - want) ** 2 / (want + 1.0 + (slack * want) ** 2)), len(want) - 3)
        / np.log(10)
    )


class Spikes(Effect):
    name = "spikes"
    alters = True
    unseen = 15.0  # they are white noise to a free quantization
    cause = "Transmission errors, electrostatic discharges or shocks throw single samples off."
    domain = "distribution"

    def detect(self, y: Array, smooth: Smooth, held: Stage | None) -> Finding | None:
        """`y` are the surprises of the samples, in standard deviations."""
        if np.abs(y).max() < OUTLIER:
            return None
        pairs = opposites(y)
        if len(pairs):
            y = np.array(y)
            y[pairs + 1] = 0.0
        gain, p, scale, s = mixture(y)
        traces = smooth.traces > TRACES and gain > 14 and scale > 2.5
        if traces:
            gain, p, scale, s = exceedances(y, loudest(y))
        hit = np.flatnonzero(np.abs(y) > OUTLIER * s)
        if (
            gain < 14 or len(hit) < 2 or scale < 2.5
        ):  # a broader shoulder is another distribution, not spikes
            return None
        tailed = held is None and not traces and tails.fitted(y)[0] > gain + normal_gain(y, s)
        if tailed:  # heavy tails: spikes begin where these end, or there are none
            gain, p, scale = beyond(y)
            if gain < BESIDE or scale < FAR:
                return None
        if held is None and not traces and p > MANY:
            return None  # a second noise, not single samples
        sd = s * np.sqrt(smooth.conditional_variance)
        rate, height = p * smooth.fs, scale * sd
        if (
            held is not None
            and abs(rate / held.rate - 1) < 0.3
            and abs(height / held.scale - 1) < 0.3
        ):
            return None
        count = max(len(hit) if traces else p * len(y), 1.0)
        a, b = 1.96 / np.sqrt(count), 1.96 / np.sqrt(2 * count)
        found = Finding(
            self,
            Stage(rate=rate, scale=height, differenced=1 if len(pairs) else None),
            gain,
            f"distribution of the innovations: {len(hit)} samples beyond {OUTLIER:g} standard "
            f"deviations, the furthest at {np.abs(y).max() / s:.3g}"
            + (", each followed by its opposite as in increments" if len(pairs) else ""),
            {
                "rate": [rate * np.exp(-a), rate * np.exp(a)],
                "scale": [height * np.exp(-b), height * np.exp(b)],
            },
        )
        # a sample is a spike where the mixture says so with more than even odds
        odds = odds_beyond(y, p, scale) if tailed else spike_odds(y / s, p, scale)
        found.mask = odds > 0
        found.mask[pairs + 1] = found.mask[pairs]
        if not tailed:
            found.doubt = self.doubt(y / s, p, scale, shoulders=not traces)
        if found.doubt and p > FEW:
            found.doubt = two_noises.sentence(y, smooth.fs) or found.doubt
        return found

    @staticmethod
    def doubt(y: Array, p: float, scale: float, *, shoulders: bool = True) -> str | None:
        """Why these outliers are no spikes of normal height at random times, or None."""
        hit = np.flatnonzero(np.abs(y) > OUTLIER)
        k = len(hit)
        if k < 12:
            return None
        wide = np.sqrt(1 + scale**2)

        # heights beyond the threshold against the two normals of the mixture
        def tail(a: float | Array) -> float | Array:
            return (1 - p) * 2 * ndtr(-a) + p * 2 * ndtr(-a / wide)

        if kstest(1 - tail(np.abs(y[hit])) / tail(OUTLIER), "uniform").pvalue < 1e-4:
            return "distribution of the innovations: the heights of the outliers are not normal"
        positive = np.count_nonzero(y[hit] > 0)
        if abs(positive - k / 2) > 4 * np.sqrt(k / 4):
            return "distribution of the innovations: the outliers have mostly one sign"
        if shoulders and shape(np.abs(y), tail) < SHAPE:
            return (
                "distribution of the innovations: the shoulders are not those of spikes on "
                "normal noise"
            )
        if kstest(hit / len(y), "uniform").pvalue < 1e-4:
            return "distribution of the innovations: the outliers crowd at certain times"
        step = np.diff(hit)
        q = -np.expm1(-(step - 0.5) * k / len(y))
        if kstest(q, "uniform").pvalue < 1e-4 and len(step) > 20:
            return "distribution of the innovations: the outliers come in groups or in a rhythm"
        return None


EFFECTS = (Spikes(),)
