"""What a fleet's table answers: outliers, drift over dates, sensor against day, shares of
effects.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import optimize, stats
from statsmodels.stats.meta_analysis import combine_effects
from statsmodels.stats.multitest import multipletests

from imu_lib.estimate import Estimate
from imu_lib.fleet import spread as spreads

#: Coefficients that a fleet is described by, in this order of methods where several have one.
KEYS = (
    ("likelihood", "N"),
    ("allan", "B"),
    ("likelihood", "K"),
    ("likelihood", "sigma"),
    ("likelihood", "correlation_time"),
    ("likelihood", "B"),
    ("allan", "Q"),
    ("allan", "R"),
)


def coefficients(table, channel, method, coefficient) -> pd.DataFrame:
    """The rows of one coefficient that have a value or an upper limit, the usable records' only."""
    rows = table[
        (table.channel == channel)
        & (table.method == method)
        & (table.coefficient == coefficient)
        & table.effect.isna()
    ]
    return rows[rows.value.notna() | rows.high.notna()]


def by_sensor(rows) -> pd.DataFrame:
    """One estimate a sensor: the mean of its records' logarithms, with the scatter from record to
    record where it has several (index sensor; columns value, low, high).
    """
    y, s = spreads.logarithms(rows.value, rows.low, rows.high)
    good = np.isfinite(y) & np.isfinite(s) & (s > 0)
    high = rows.high.to_numpy(float)
    names, own = _of_sensors(rows)
    out = np.empty((len(names), 3))
    for k, at in enumerate(own):
        shown = at[good[at]]
        if not shown.size:
            out[k] = np.nan, 0.0, np.nan if np.isnan(high[at]).all() else np.nanmin(high[at])
            continue
        mean, sd = y[shown[0]], s[shown[0]]
        if shown.size > 1:
            found = combine_effects(y[shown], s[shown] ** 2, method_re="iterated")
            mean, sd = found.mean_effect_re, found.sd_eff_w_re
        out[k] = np.exp(mean + np.array([0.0, -1.0, 1.0]) * 1.959964 * sd)
    return pd.DataFrame(out, index=names, columns=["value", "low", "high"])


def _of_sensors(rows):
    """(names of the sensors as they come, places of each one's rows)."""
    place, names = pd.factorize(rows.sensor)
    if not len(names):
        return [], []
    order = np.argsort(place, kind="stable")
    return list(names), np.split(order, np.cumsum(np.bincount(place, minlength=len(names)))[:-1])


def spread(table, channel, method, coefficient) -> spreads.Spread | None:
    """The Spread of a coefficient over the sensors, None where fewer than three show it."""
    one = by_sensor(coefficients(table, channel, method, coefficient))
    return spreads.of_units(one.value, one.low, one.high) if len(one) else None


def outliers(table, channel, method, coefficient, *, level=0.05) -> pd.DataFrame:
    """Sensors that do not belong to the others.

    Each is held against what the others predict of it: their mean and scatter (Paule and Mandel),
    its own standard error, Student's t. p-values are Holm's, so that `level` is the chance of any
    false alarm in a fleet without outliers.

    Returns
    -------
    DataFrame
        Index sensor; value, expected, ratio, p_value; most extreme first.
    """
    one = by_sensor(coefficients(table, channel, method, coefficient))
    y, s = spreads.logarithms(one.value, one.low, one.high)
    good = np.flatnonzero(np.isfinite(y) & np.isfinite(s) & (s > 0))
    columns = ["value", "expected", "ratio", "p_value"]
    if good.size < 5:
        return pd.DataFrame(columns=columns)
    y, s, names = y[good], s[good], one.index[good]
    p, expected = np.empty(y.size), np.empty(y.size)
    for i in range(y.size):
        rest = np.arange(y.size) != i
        found = combine_effects(y[rest], s[rest] ** 2, method_re="iterated")
        tau2 = max(found.tau2, 0.0)
        weight = 1 / (tau2 + s[rest] ** 2)
        expected[i] = weight @ y[rest] / weight.sum()
        z = (y[i] - expected[i]) / np.sqrt(tau2 + s[i] ** 2 + 1 / weight.sum())
        p[i] = 2 * stats.t.sf(abs(z), y.size - 2)
    if y.size * p.min() >= level:  # Holm's smallest; statsmodels collects garbage at each call
        return pd.DataFrame(columns=columns)
    adjusted = multipletests(p, method="holm")[1]
    out = pd.DataFrame(
        {
            "value": np.exp(y),
            "expected": np.exp(expected),
            "ratio": np.exp(y - expected),
            "p_value": adjusted,
        },
        index=names,
    )
    return out[out.p_value < level].sort_values("p_value")


def drift(table, channel, method, coefficient) -> Estimate | None:
    """How a coefficient grows with time, as the change of its logarithm a year: each sensor's own
    slope over its dates, combined (random effects, Hartung and Knapp's interval); None where fewer
    than three sensors have three dates or more. Dates scatter by the same amount in all sensors,
    found by Paule and Mandel's condition.
    """
    series = _series(coefficients(table, channel, method, coefficient))
    if len(series) < 3:
        return None
    # days scatter by more than the estimates' own error; by how much, all sensors tell together:
    # each alone has too few dates, and weights made of its own scatter would be as uncertain
    wanted = sum(t.size - 2 for t, _, _ in series)

    def excess(day):
        return sum(_slope(t, y, s**2 + day)[2] for t, y, s in series) - wanted

    most = max(float(np.ptp(y)) ** 2 for _, y, _ in series)
    day = optimize.brentq(excess, 0.0, 4 * most) if excess(0.0) > 0 > excess(4 * most) else 0.0
    found = np.array([_slope(t, y, s**2 + day)[:2] for t, y, s in series])
    both = combine_effects(found[:, 0], found[:, 1], method_re="iterated", use_t=True)
    mean = float(both.mean_effect_re)
    half = stats.t.ppf(0.975, len(found) - 1) * float(both.sd_eff_w_re_hksj)
    return Estimate(mean, mean - half, mean + half)


def _series(rows):
    """(dates in years, logarithms, their standard errors) of each sensor with three dates or
    more.
    """
    rows = rows[rows.date.notna()]
    if not len(rows):
        return []
    every_y, every_s = spreads.logarithms(rows.value, rows.low, rows.high)
    every_t = pd.to_datetime(rows.date).to_numpy("datetime64[D]").astype(float) / 365.25
    good = np.isfinite(every_y) & np.isfinite(every_s) & (every_s > 0)
    own = [at[good[at]] for at in _of_sensors(rows)[1]]
    return [
        (every_t[at], every_y[at], every_s[at]) for at in own if np.unique(every_t[at]).size > 2
    ]


def _slope(t, y, variance):
    """(slope, its variance, weighted sum of squares that is left) of a straight line."""
    design = np.column_stack([np.ones(t.size), t - t.mean()]) / np.sqrt(variance)[:, None]
    inverse = np.linalg.inv(design.T @ design)
    fit = inverse @ design.T @ (y / np.sqrt(variance))
    rest = y / np.sqrt(variance) - design @ fit
    return fit[1], inverse[1, 1], rest @ rest


def sensor_and_day(table, channel, method, coefficient) -> dict | None:
    """Scatter of a coefficient's logarithm from sensor to sensor and, within a sensor, from record
    to record, both apart from the estimates' own error; None where fewer than three sensors have
    two records or more.

    Restricted maximum likelihood of y_ij = mu + u_i + d_ij + e_ij with the errors known; intervals
    where the profile falls by 1.92, of the sensors by more where they have heavier tails than the
    normal (`spread.widening`).

    Returns
    -------
    dict
        `sensor`, `day` (Estimate) and `error` (float, the median standard error).
    """
    groups = []
    for _, own in coefficients(table, channel, method, coefficient).groupby("sensor"):
        y, s = spreads.logarithms(own.value, own.low, own.high)
        good = np.isfinite(y) & np.isfinite(s) & (s > 0)
        if good.any():
            groups.append((y[good], s[good]))
    if sum(len(y) > 1 for y, _ in groups) < 3:
        return None
    every = np.concatenate([y for y, _ in groups])
    size = float(np.std(every)) or 1e-6

    def misfit(sensor, day):
        total = one = two = three = 0.0
        for y, s in groups:
            w = 1 / (day[..., None] ** 2 + s**2)
            sums, first, second = w.sum(-1), w @ y, w @ y**2
            shrink = sensor**2 / (1 + sensor**2 * sums)
            total = total - np.log(w).sum(-1) + np.log1p(sensor**2 * sums)
            one = one + sums - shrink * sums**2
            two = two + first - shrink * sums * first
            three = three + second - shrink * first**2
        return 0.5 * (total + np.log(one) + three - two**2 / one)

    grid = np.concatenate([[0.0], np.geomspace(0.02 * size, 6 * size, 60)])
    surface = misfit(grid[:, None], grid[None, :])
    start = grid[list(np.unravel_index(np.argmin(surface), surface.shape))]
    best = optimize.minimize(
        lambda p: float(misfit(*np.abs(p))), start + 1e-3 * size, method="Nelder-Mead"
    )
    low = min(best.fun, surface.min())
    found = np.abs(best.x)
    weights = [1 / (found[1] ** 2 + s**2) for _, s in groups]
    wide = spreads.widening([np.average(y, weights=w) for (y, _), w in zip(groups, weights)])
    return {
        "sensor": _profiled(grid, (surface.min(axis=1) - low) / wide, found[0]),
        "day": _profiled(grid, surface.min(axis=0) - low, found[1]),
        "error": float(np.median(np.concatenate([s for _, s in groups]))),
    }


def _profiled(grid, rise, value):
    inside = np.flatnonzero(rise < 1.92)
    if not inside.size:
        return Estimate(float(value), float(value), float(value))
    first, last = inside[0], inside[-1]
    low = 0.0 if first == 0 else np.interp(1.92, rise[[first, first - 1]], grid[[first, first - 1]])
    high = (
        np.inf
        if last == grid.size - 1
        else np.interp(1.92, rise[last : last + 2], grid[last : last + 2])
    )
    return Estimate(float(value), float(min(low, value)), float(max(high, value)))


def shares(table, *, method="likelihood", level=0.95) -> pd.DataFrame:
    """In what share of the sensors each effect is found (or, with the likelihood, each sum of
    processes chosen), by channel, with Clopper and Pearson's interval.

    Returns
    -------
    DataFrame
        channel, effect, found, asked, share, low, high.
    """
    usable = table[table.error.isna()]
    own = usable[(usable.method == method) & usable.effect.notna()]
    own = own[own.confidence.isna() | (own.confidence >= 0.9) | (method != "gap")]
    out = []
    for (channel, effect), rows in own.groupby([own.channel.fillna("record"), "effect"], sort=True):
        here = usable if channel == "record" else usable[usable.channel == channel]
        asked, found = here.sensor.nunique(), rows.sensor.nunique()
        interval = stats.binomtest(found, asked).proportion_ci(level)
        out.append((channel, effect, found, asked, found / asked, interval.low, interval.high))
    names = ["channel", "effect", "found", "asked", "share", "low", "high"]
    return pd.DataFrame(out, columns=names)
