"""White noise with heavier tails than a normal one."""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaln, ndtr, ndtri, ndtri_exp
from scipy.stats import poisson
from scipy.stats import t as student

from imu_lib.arrays import Array
from imu_lib.processes import HeavyTails as Stage
from imu_lib.samples import two_noises
from imu_lib.samples.leaning import leaning
from imu_lib.samples.level_tails import Levels
from imu_lib.samples.uneven import uneven

from .base import ChannelEffect, ChannelView, Finding
from .noise_level_change import unsteady
from .resolution import grid_of

#: Freedom above which the tails are no heavier than uneven steps of a converter make them.
BENT = 12.0
#: Standard deviations beyond which they make no more samples than `TIMES` what is normal, the
#: logarithm of the probability of more, and standard deviations of the walk of their widths that
#: chance may move the ends by.
FURTHEST, TIMES, RARE, CHANCE = 4.5, 5.0, -12.0, 2.0
#: Gain in log-likelihood over a normal distribution, and degrees of freedom beyond which nobody
#: would tell.
GAIN, MOST = 14.0, 60.0
#: Degrees of freedom below which the variance hangs on the few largest samples.
LEAST = 2.3
#: Step of a grid, in standard deviations of the noise, beyond which its levels show, and beyond
#: which they are too few.
COARSE, COARSER = 0.5, 1.6
#: Width of a class of squared samples, of their logarithm.
NARROW = 2e-3
#: log10 p of an unsteady level below which tails may be nothing but that.
STEADY = -5.0


def _classes(square: Array) -> tuple[Array, Array]:
    """Means and numbers of squares (n,) by classes of their logarithm, so narrow that no likelihood
    of a million of them changes by a tenth.
    """
    least = 1e-12 * np.mean(square) or 1.0
    number = np.floor(np.log(np.maximum(square, least) / least) / NARROW).astype(int)
    count, total = np.bincount(number), np.bincount(number, weights=square)
    return total[count > 0] / count[count > 0], count[count > 0]


def fitted(y: Array) -> tuple[float, float, float, float]:
    """(gain over a normal distribution, degrees of freedom, scale, sd of the logarithm of the
    freedom) of the Student's distribution that is likeliest for `y` (n,).
    """
    values, count = _classes(y * y)
    n = count.sum()

    def loss(v: Array) -> float:
        freedom, scale = 2.0 + np.exp(v[0]), np.exp(2 * v[1])
        constant = gammaln(0.5 * (freedom + 1)) - gammaln(0.5 * freedom)
        constant -= 0.5 * np.log(np.pi * freedom * scale)
        return -n * constant + 0.5 * (freedom + 1) * (count @ np.log1p(values / (freedom * scale)))

    start = [np.log(4.0), 0.5 * np.log(np.average(values, weights=count) * 2 / 3)]
    best = minimize(loss, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-2})
    normal = 0.5 * n * (np.log(2 * np.pi * (count @ values) / n) + 1.0)
    h = 0.05
    curve = (
        loss(best.x + [h, 0]) - 2 * best.fun + loss(best.x - [h, 0])
    ) / h**2  # of the logarithm of what is beyond 2
    freedom = 2.0 + np.exp(best.x[0])
    sd = (freedom - 2.0) / freedom / np.sqrt(max(curve, 1e-9))
    return float(normal - best.fun), float(freedom), float(np.exp(best.x[1])), float(sd)


def _likeliest(y: Array, independent: float) -> tuple[float, Stage, dict[str, list[float]]]:
    """(gain over a normal distribution, the tails, intervals of their parameters) of samples `y`
    (n,), a share of which is `independent`.
    """
    gain, freedom, _, sd = fitted(y - np.mean(y))
    tails, intervals = Stage(freedom=freedom), {}
    leans = leaning(y, freedom)
    if leans is not None and leans[0] * independent > GAIN:
        more, tails, spread = leans
        gain, lean = gain + more, float(tails.lean or 0.0)
        intervals["lean"] = [lean - 1.96 * spread, lean + 1.96 * spread]
    reach = np.exp(1.96 * sd)
    intervals["freedom"] = [tails.freedom / reach, tails.freedom * reach]
    return gain * independent, tails, intervals


#: Width of a class of innovations, in standard deviations.
CLASS = 0.1


def _levels(view: ChannelView, grid: tuple[float, float] | None) -> Levels:
    """The samples by the levels of their coarse `grid` (step, offset), or their innovations by
    classes.
    """
    if grid is None:
        y = view.y - np.mean(view.y)
        return Levels.of(y, (CLASS * float(np.std(y)), 0.0), np.zeros(len(y)))
    seen = ~np.isnan(view.raw)
    scale = np.broadcast_to(view.scale, view.raw.shape)[seen]
    return Levels.of(view.raw[seen], grid, view.slow[seen], scale)


def _far(y: Array, moved: float) -> bool:
    """Whether more samples lie far out than uneven steps would put there, which have `moved` them
    by that many standard deviations; `TIMES` as many where that is not known.
    """
    u = (y - np.mean(y)) / np.std(y)
    expected = (1.0 if moved else TIMES) * 2.0 * float(ndtr(-FURTHEST)) * len(u)
    return bool(poisson.logsf(np.count_nonzero(np.abs(u) > FURTHEST + moved) - 1, expected) < RARE)


def _bent(view: ChannelView, y: Array, grid: tuple[float, float], freedom: float) -> bool:
    """Whether uneven steps of the converter, on a `grid` of (step, offset), bend the distribution
    as much as tails of that `freedom`: their widths add up to a walk from the middle to the end.
    """
    coarse = grid[0] / np.sqrt(view.smooth.conditional_variance)
    if freedom <= BENT and coarse <= COARSE:
        return False
    steps = uneven(view.raw[~np.isnan(view.raw)], *grid)
    if steps is None:
        return False
    moved = CHANCE * steps.scatter * np.sqrt(FURTHEST * coarse) if coarse > COARSE else 0.0
    return not _far(y, float(moved))


class HeavyTails(ChannelEffect):
    name = "heavy_tails"
    cause = (
        "The noise has many sources of unequal strength, or an interpolating or dithering "
        "converter: large deviations come more often than in normal noise."
    )
    domain = "distribution"

    def candidates(self, view: ChannelView) -> list[Finding]:
        y, independent = view.y, view.smooth.independent
        grid = grid_of(view.raw[~np.isnan(view.raw)])
        coarse = 0.0 if grid is None else grid[0] / np.sqrt(view.smooth.conditional_variance)
        if coarse > COARSER:
            return []
        variance = levels = None
        if grid is not None and coarse > COARSE:
            levels = _levels(view, grid)
            found = levels.tails(GAIN / independent)
            gain, variance = found.gain * independent, (found.sd * grid[0]) ** 2
            tails, intervals = found.with_intervals()
        else:
            gain, tails, intervals = _likeliest(y, independent)
        freedom = tails.freedom
        if gain < GAIN or freedom > MOST:
            return []
        if grid is not None and _bent(view, y, grid, freedom):
            return []
        u = (y - np.mean(y)) / np.std(y)
        lean = f", {np.count_nonzero(u > 4)} of them above" if tails.lean else ""
        finding = Finding(
            self,
            tails,
            gain,
            f"distribution of the innovations: {np.count_nonzero(np.abs(u) > 4)} of {len(u)} "
            f"beyond four standard deviations{lean}, where normal noise has {6.3e-5 * len(u):.1f}",
            intervals,
            levels=levels or _levels(view, None),
            variance=variance,
        )
        if freedom < LEAST:
            finding.doubt = two_noises.sentence(y, view.fs) or (
                "distribution of the innovations: a few large deviations among many small ones, "
                f"excess kurtosis {np.mean(u**4) - 3:.3g}: two noises that take turns"
            )
            return [finding]
        left = unsteady(y, view.fs, independent)
        if left is not None and left[0] < STEADY:
            finding.doubt = left[1]
        return [finding]

    def normal(self, y: Array, finding: Finding) -> Array:
        if finding.variance is not None:
            return y  # its levels have been judged
        freedom = finding.process.freedom
        u = (y - np.mean(y)) / np.std(y)
        if finding.process.lean:
            grid = np.linspace(u.min(), u.max(), 4000)
            below, above = finding.process.log_tails(grid)
            z = np.where(below < above, ndtri_exp(below), -ndtri_exp(above))
            return np.interp(u, grid, z)
        u = u * np.sqrt(freedom / (freedom - 2.0))
        return np.sign(u) * -ndtri(np.maximum(student.sf(np.abs(u), freedom), 1e-300))


EFFECTS = (HeavyTails(),)
