"""What a fleet's table answers: one estimate a sensor, their spread, shares of effects."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from imu_lib.estimate import Z95
from imu_lib.fleet import spread as spreads
from imu_lib.fleet.pooling import pooled

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


def by_date(rows) -> pd.DataFrame:
    """One logarithm a sensor and date, of the records that show the coefficient: several records of
    a sensor on one date are averaged, so that a date does not count twice; records without a date
    stand for themselves (columns sensor, date, y, s; in the order in which they come).
    """
    y, s = spreads.logarithms(rows.value, rows.low, rows.high)
    good = np.isfinite(y) & np.isfinite(s) & (s > 0)
    rows, y, s = rows[good], y[good], s[good]
    dated = rows.date.notna().to_numpy()
    days = rows.date.astype(object).where(dated, [str(k) for k in range(len(rows))])
    found = [
        (rows.sensor.iloc[at[0]], rows.date.iloc[at[0]] if dated[at[0]] else None)
        + _mean(y[at], s[at])
        for at in _places(rows.sensor.astype(str) + "\n" + days.astype(str))[1]
    ]
    return pd.DataFrame(found, columns=["sensor", "date", "y", "s"])


def by_sensor(rows, dated=None) -> pd.DataFrame:
    """One estimate a sensor: the mean of its dates' logarithms (`dated`: `by_date` of the rows,
    where that is at hand), with the scatter from date to date where it has several (index sensor;
    columns value, low, high).
    """
    dated = by_date(rows) if dated is None else dated
    high = rows.high.to_numpy(float)
    shown = dict(zip(*_places(dated.sensor), strict=True))
    y, s = dated.y.to_numpy(float), dated.s.to_numpy(float)
    names, own = _places(rows.sensor)
    out = np.empty((len(names), 3))
    for k, (name, at) in enumerate(zip(names, own, strict=True)):
        if name not in shown:
            out[k] = np.nan, 0.0, np.nan if np.isnan(high[at]).all() else np.nanmin(high[at])
            continue
        mean, sd = _mean(y[shown[name]], s[shown[name]])
        out[k] = np.exp(mean + np.array([0.0, -1.0, 1.0]) * Z95 * sd)
    return pd.DataFrame(out, index=names, columns=["value", "low", "high"])


def _mean(y, s):
    """(mean, its standard error) of values that scatter by more than their errors, if they do."""
    if y.size == 1:
        return float(y[0]), float(s[0])
    found = pooled(y, s)
    return float(found.mean[0]), float(found.error[0])


def _places(names):
    """(the names as they come, places of each one's rows)."""
    place, known = pd.factorize(names)
    if not len(known):
        return [], []
    order = np.argsort(place, kind="stable")
    return list(known), np.split(order, np.cumsum(np.bincount(place, minlength=len(known)))[:-1])


def spread(table, channel, method, coefficient) -> spreads.Spread | None:
    """The Spread of a coefficient over the sensors, None where fewer than three show it."""
    rows = coefficients(table, channel, method, coefficient)
    return spread_of(by_sensor(rows))


def spread_of(one) -> spreads.Spread | None:
    """As `spread`, of one estimate a sensor (`by_sensor`)."""
    return spreads.of_units(one.value, one.low, one.high) if len(one) else None


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
