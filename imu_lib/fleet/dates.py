"""What a fleet's table says of time: drift over dates, sensor against day."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import optimize, stats

from imu_lib.estimate import Estimate
from imu_lib.fleet import spread as spreads
from imu_lib.fleet.pooling import pooled
from imu_lib.fleet.questions import by_date, coefficients

#: Fewest sensors with several dates of which a drift is told.
LEAST = 3
#: Chance that what the units have in common on a date is found where they have nothing.
FALSE = 0.05


@dataclass(frozen=True)
class Drift(Estimate):
    """Change of a coefficient's logarithm a year, 95 % interval.

    Attributes
    ----------
    sensors, dates : int
        Sensors with two dates or more, and the dates that they have.
    first, last : str
    years : float
        Between the two.
    common : str or None
        The date on which all units lie off the line together; the interval is then of the dates,
        not of the units.
    """

    sensors: int = 0
    dates: int = 0
    first: str = ""
    last: str = ""
    years: float = 0.0
    common: str | None = None

    def to_json(self):
        told = {k: getattr(self, k) for k in ("sensors", "dates", "first", "last", "common")}
        return super().to_json() | told


def drift(table, channel, method, coefficient) -> Drift | None:
    """How a coefficient grows with time: each sensor's own slope over its dates, combined (random
    effects, Hartung and Knapp's interval); of two dates that all sensors have this is the paired
    comparison. None where fewer than three sensors have two dates or more (`without_drift`).

    Dates scatter by the same amount in all sensors, found by Paule and Mandel's condition about
    the sensors' own slopes, or about one slope where these leave nothing. Where three dates or
    more show that the units rise and fall together, the interval is that of a line through the
    dates' means: what a day has in common is then no drift (three dates show it in four of five
    such fleets; two never do).
    """
    return drift_of(by_date(coefficients(table, channel, method, coefficient)))


def drift_of(dated) -> Drift | None:
    """As `drift`, of one logarithm a sensor and date (`questions.by_date`)."""
    series = _series(dated)
    if len(series) < LEAST:
        return None
    day = _day_variance(series)
    found = np.array([_slope(t, y, s**2 + day)[:2] for t, y, s in series])
    both = pooled(found[:, 0], np.sqrt(found[:, 1]))
    mean = float(both.mean[0])
    half = float(stats.t.ppf(0.975, len(found) - 1) * both.robust[0])
    every = np.unique(np.concatenate([t for t, _, _ in series]))
    common = None
    if (together := _together(series)) is not None:
        mean, half, common = together
    first, last = (_day(t) for t in every[[0, -1]])
    years = float(every[-1] - every[0])
    return Drift(
        mean, mean - half, mean + half, len(series), every.size, first, last, years, common
    )


def without_drift(table, channel, method, coefficient) -> str:
    """Why no drift of a coefficient is told, in a sentence."""
    rows = coefficients(table, channel, method, coefficient)
    return without_drift_of(rows, by_date(rows))


def without_drift_of(rows, dated) -> str:
    """As `without_drift`, of the rows of a coefficient and `questions.by_date` of them."""
    if not rows.date.notna().any():
        return (
            "no record has a date; it is read from the names (unit1_2024-05-01.npz) or from a "
            "manifest's column `date`"
        )
    several = len(_series(dated))
    if rows.date.dropna().nunique() == 1:
        return f"all records are of one date, {rows.date.dropna().iloc[0]}"
    many = "no sensor shows" if not several else f"only {several} sensor{'s' * (several > 1)} show"
    return f"{many}{'s' * (several == 1)} it on two dates or more, three such sensors are needed"


def _day(t):
    return str(np.datetime64(round(t * 365.25), "D"))


def _day_variance(series):
    """Variance of a date's logarithm beside the estimates' own error, of all sensors alike."""
    most = 4 * max(float(np.ptp(y)) ** 2 for _, y, _ in series)
    wanted = sum(t.size - 2 for t, _, _ in series)
    own = wanted >= LEAST  # own slopes leave enough to tell the scatter of dates
    if not own:
        wanted = sum(t.size - 1 for t, _, _ in series) - 1

    def excess(day):
        found = np.array([_slope(t, y, s**2 + day) for t, y, s in series])
        about = found[:, 2].sum()
        if not own:
            mean = np.average(found[:, 0], weights=1 / found[:, 1])
            about += np.sum((found[:, 0] - mean) ** 2 / found[:, 1])
        return about - wanted

    return optimize.brentq(excess, 0.0, most) if excess(0.0) > 0 > excess(most) else 0.0


def _together(series):
    """(slope, half its interval, date) of a line through the dates' means where the units leave
    their own lines together on a date; None where they do not, or where fewer than three sensors
    have the same three dates or more.
    """
    dates = {}
    for t, y, _ in series:
        dates.setdefault(tuple(t), []).append(y)
    t, values = max(dates.items(), key=lambda entry: len(entry[1]) * (len(entry[0]) > 2))
    t, values = np.array(t), np.array(values)
    if t.size < 3 or len(values) < LEAST:
        return None
    design = np.column_stack([np.ones(t.size), t - t.mean()])
    rest = values - values @ design @ np.linalg.pinv(design)
    error = rest.std(axis=0, ddof=1) / np.sqrt(len(rest))
    size = np.abs(rest.mean(axis=0)) / np.maximum(error, 1e-12)
    p = 2 * stats.t.sf(size, len(rest) - 1) * t.size
    if p.min() > FALSE:
        return None
    means = values.mean(axis=0)
    left = rest.mean(axis=0)
    slope = np.linalg.lstsq(design, means, rcond=None)[0][1]
    error = np.sqrt(left @ left / (t.size - 2) / np.sum((t - t.mean()) ** 2))
    worst = int(np.argmax(np.abs(left)))
    return float(slope), float(stats.t.ppf(0.975, t.size - 2) * error), _day(t[worst])


def _series(dated):
    """(dates in years, logarithms, their standard errors) of each sensor with two dates or more."""
    dated = dated[dated.date.notna()].sort_values("date", kind="stable")
    t = pd.to_datetime(dated.date).to_numpy("datetime64[D]").astype(float) / 365.25
    y, s = dated.y.to_numpy(float), dated.s.to_numpy(float)
    own = dated.groupby("sensor", sort=False).indices.values()
    return [(t[at], y[at], s[at]) for at in own if len(at) > 1]


def _slope(t, y, variance):
    """(slope, its variance, weighted sum of squares that is left) of a straight line."""
    design = np.column_stack([np.ones(t.size), t - t.mean()]) / np.sqrt(variance)[:, None]
    inverse = np.linalg.inv(design.T @ design)
    fit = inverse @ design.T @ (y / np.sqrt(variance))
    rest = y / np.sqrt(variance) - design @ fit
    return fit[1], inverse[1, 1], rest @ rest


def sensor_and_day(table, channel, method, coefficient) -> dict | None:
    """Scatter of a coefficient's logarithm from sensor to sensor and, within a sensor, from date to
    date (where no sensor has two dates: from record to record), both apart from the estimates' own
    error; None where fewer than three sensors have two of them or more.

    Restricted maximum likelihood of y_ij = mu + u_i + d_ij + e_ij with the errors known; intervals
    where the profile falls by 1.92, of the sensors by more where they have heavier tails than the
    normal (`spread.widening`).

    Returns
    -------
    dict
        `sensor`, `day` (Estimate), `error` (float, the median standard error) and `of`, "date" or
        "record".
    """
    rows = coefficients(table, channel, method, coefficient)
    return sensor_and_day_of(rows, by_date(rows))


def sensor_and_day_of(rows, dated) -> dict | None:
    """As `sensor_and_day`, of the rows of a coefficient and `questions.by_date` of them."""
    of = "date"
    if not dated.sensor.duplicated().any() or dated.date.isna().any():
        of, dated = "record", by_date(rows.assign(date=None))
    groups = [(own.y.to_numpy(), own.s.to_numpy()) for _, own in dated.groupby("sensor", sort=True)]
    if sum(len(y) > 1 for y, _ in groups) < LEAST:
        return None
    size = float(np.std(np.concatenate([y for y, _ in groups]))) or 1e-6
    grid = np.concatenate([[0.0], np.geomspace(0.02 * size, 6 * size, 60)])
    surface = _misfit(groups, grid[:, None], grid[None, :])
    start = grid[list(np.unravel_index(np.argmin(surface), surface.shape))]
    best = optimize.minimize(
        lambda p: float(_misfit(groups, *np.abs(p))), start + 1e-3 * size, method="Nelder-Mead"
    )
    low = min(best.fun, surface.min())
    found = np.abs(best.x)
    weights = [1 / (found[1] ** 2 + s**2) for _, s in groups]
    wide = spreads.widening([np.average(y, weights=w) for (y, _), w in zip(groups, weights)])
    return {
        "sensor": _profiled(grid, (surface.min(axis=1) - low) / wide, found[0]),
        "day": _profiled(grid, surface.min(axis=0) - low, found[1]),
        "error": float(np.median(np.concatenate([s for _, s in groups]))),
        "of": of,
    }


def _misfit(groups, sensor, day):
    """Minus the restricted log-likelihood at these two scatters, which broadcast."""
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
