"""Which units do not belong to the others: by their values, and by how they change over dates."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy import stats

from imu_lib.fleet import spread as spreads
from imu_lib.fleet.pooling import pooled
from imu_lib.fleet.questions import by_date, by_sensor, coefficients

#: Fewest units of which one can be told not to belong.
LEAST = 5
#: How many units that look sound are put aside to see whether they hid others.
AHEAD = 5


def outliers(table, channel, method, coefficient, *, level=0.05) -> pd.DataFrame:
    """Sensors that do not belong to the others.

    Each is held against what the others predict of it: their mean and scatter (Paule and Mandel),
    its own standard error, Student's t. The most extreme is put aside and the others looked at
    again (Rosner 1983), so that two of the same kind do not hide each other; `level` is the chance
    of any false alarm in a fleet without outliers.

    Returns
    -------
    DataFrame
        Index sensor; value, expected (of the sensors that are no outliers), ratio, p_value
        (Bonferroni's, against these); most extreme first.

    References
    ----------
    Rosner 1983, Technometrics 25, 165.
    """
    rows = coefficients(table, channel, method, coefficient)
    return outliers_of(by_sensor(rows), level=level)


def outliers_of(one, *, level=0.05) -> pd.DataFrame:
    """As `outliers`, of one estimate a sensor (`questions.by_sensor`)."""
    y, s = spreads.logarithms(one.value, one.low, one.high)
    good = np.flatnonzero(np.isfinite(y) & np.isfinite(s) & (s > 0))
    return _named(y[good], s[good], one.index[good], level).drop(columns="place")


def steps(table, channel, method, coefficient, *, level=0.05) -> pd.DataFrame:
    """Sensors that change from one date to their next unlike the others over the same two dates:
    another calibration, a repair, a fall.

    Asked where five sensors or more have the same two dates after each other; what all of them
    change is `expected`.

    Returns
    -------
    DataFrame
        Index sensor; before, after (dates), ratio, expected, p_value; most extreme first.
    """
    return steps_of(by_date(coefficients(table, channel, method, coefficient)), level=level)


def steps_of(dated, *, level=0.05) -> pd.DataFrame:
    """As `steps`, of one logarithm a sensor and date (`questions.by_date`)."""
    pairs = _pairs(dated)
    columns = ["before", "after", "ratio", "expected", "p_value"]
    groups = [own for _, own in pairs.groupby(["before", "after"]) if len(own) >= LEAST]
    found = []
    for own in groups:
        odd = _named(own.y.to_numpy(), own.s.to_numpy(), own.index, level / len(groups))
        odd = odd.assign(
            before=own.before.to_numpy()[odd.place], after=own.after.to_numpy()[odd.place]
        )
        found.append(odd.assign(ratio=odd.value, p_value=len(groups) * odd.p_value))
    if not any(len(odd) for odd in found):
        return pd.DataFrame(columns=columns)
    return pd.concat([odd for odd in found if len(odd)])[columns].sort_values("p_value")


def _pairs(dated):
    """What each sensor changes from a date to its next, index sensor: before, after, y, s."""
    out = []
    for sensor, own in dated[dated.date.notna()].groupby("sensor", sort=False):
        own = own.sort_values("date")
        y, s, date = own.y.to_numpy(), own.s.to_numpy(), own.date.to_numpy()
        for k in range(len(own) - 1):
            size = float(np.hypot(s[k], s[k + 1]))
            out.append((sensor, date[k], date[k + 1], float(y[k + 1] - y[k]), size))
    return pd.DataFrame(out, columns=["sensor", "before", "after", "y", "s"]).set_index("sensor")


def _named(y, s, names, level) -> pd.DataFrame:
    """The places of what does not belong, with its value, what is expected, ratio, p-value."""
    odd = _places(y, s, level)
    sound = np.setdiff1d(np.arange(y.size), odd)
    rows = []
    for i in odd:
        own = np.append(sound, i)
        expected, z = (v[-1] for v in _against_rest(y[own], s[own]))
        p = min(1.0, 2 * stats.t.sf(abs(z), sound.size - 1) * y.size)
        rows.append((i, np.exp(y[i]), np.exp(expected), np.exp(y[i] - expected), p))
    columns = ["place", "value", "expected", "ratio", "p_value"]
    out = pd.DataFrame(rows, columns=columns, index=names[odd])
    return out.astype({"place": int}).sort_values("p_value")


def _places(y, s, level):
    """Places of those that do not belong, by Rosner's rule."""
    left, aside, odd = np.arange(y.size), [], 0
    while left.size >= LEAST and len(aside) < min(odd + AHEAD, y.size // LEAST):
        z = np.abs(_against_rest(y[left], s[left])[1])
        most = int(np.argmax(z))
        aside.append(left[most])
        if 2 * stats.t.sf(z[most], left.size - 2) * left.size < level:
            odd = len(aside)
        left = np.delete(left, most)
    return np.array(aside[:odd], int)


def _against_rest(y, s):
    """(expected, z) of each value by all others."""
    rest = pooled(y, s, ~np.eye(y.size, dtype=bool))
    return rest.mean, (y - rest.mean) / np.sqrt(rest.between + s**2 + rest.error**2)
