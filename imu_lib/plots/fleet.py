"""Figures of a fleet: coefficients over units and dates, shares, sensor against day."""

import numpy as np

from imu_lib import units

from . import style


def _unit(channel, coefficient):
    factor, name = units.datasheet(coefficient, channel)
    return factor, f"{coefficient} of {style.channel_label(channel)}, {name}"


@style.styled
def fleet_spread(by_sensor, spread, channel, coefficient, *, outliers=(), ax=None):
    """One coefficient over the units, smallest first, with each one's interval; the typical value,
    the middle 90 % of all units, and the worst of 95 %.

    by_sensor : DataFrame of `fleet.by_sensor`; spread : `fleet.Spread`; outliers : names of sensors
    to be marked.
    """
    factor, label = _unit(channel, coefficient)
    ax = style.axes(ax, x="unit, by size", y=label)
    one = by_sensor.sort_values("value")
    place = np.arange(len(one))
    for odd, colour, name in ((False, style.DATA, "units"), (True, style.VERMILION, "outlier")):
        mine = np.isin(one.index, list(outliers)) == odd
        if mine.any():
            value = one.value[mine] / factor
            error = [value - one.low[mine] / factor, one.high[mine] / factor - value]
            ax.errorbar(place[mine], value, np.abs(error), fmt="o", color=colour, label=name)
    typical, size = spread.typical.value / factor, spread.scatter.value
    ends = typical * np.exp(np.array([-1.645, 1.645]) * size)
    ax.axhspan(*ends, color=style.BAND, alpha=0.2, label="middle 90 % of all units")
    ax.axhline(typical, color=style.BLACK, label="typical")
    ax.axhline(spread.worst / factor, color=style.PURPLE, ls="--", label="worst of 95 %")
    ax.legend()
    return ax


@style.styled
def fleet_dates(rows, channel, coefficient, *, drift=None, ax=None):
    """One coefficient of each unit over its dates, and the drift that all of them share.

    rows : DataFrame of `fleet.coefficients`; drift : Estimate of `fleet.drift`, or None.
    """
    factor, label = _unit(channel, coefficient)
    ax = style.axes(ax, x="date", y=label)
    rows = rows[rows.date.notna() & rows.value.notna()]
    time = rows.date.to_numpy("datetime64[D]")
    for sensor in rows.sensor.unique():
        mine = (rows.sensor == sensor).to_numpy()
        order = np.argsort(time[mine])
        value = rows.value[mine].to_numpy()[order] / factor
        ax.plot(time[mine][order], value, ".-", color=style.DATA, alpha=0.5)
    if drift is not None:
        years = (time - time.min()).astype(float) / 365.25
        grid = np.linspace(0.0, years.max(), 50)
        middle = np.exp(np.mean(np.log(rows.value / factor)))
        days = time.min() + (grid * 365.25).astype("timedelta64[D]")
        turn = grid - years.mean()
        ax.plot(days, middle * np.exp(drift.value * turn), color=style.FIT, label="drift in common")
        ends = [middle * np.exp(slope * turn) for slope in (drift.low, drift.high)]
        style.band(ax, days, np.minimum(*ends), np.maximum(*ends), color=style.FIT)
        ax.legend()
    ax.tick_params(axis="x", rotation=20)
    return ax


@style.styled
def fleet_days(found, *, ax=None):
    """Scatter from sensor to sensor, from day to day of one sensor, and the error of one estimate.

    found : mapping of a name to what `fleet.sensor_and_day` gives.
    """
    ax = style.axes(ax, x="", y="scatter, per cent")
    kinds = (("sensor", "sensor to sensor", style.BLUE), ("day", "day to day", style.ORANGE))
    for k, (key, label, colour) in enumerate(kinds):
        place = np.arange(len(found)) + 0.2 * (k - 0.5)
        value = np.array([f[key].value for f in found.values()])
        ends = np.array([[f[key].low, f[key].high] for f in found.values()])
        error = 100 * np.abs(np.stack([value - ends[:, 0], ends[:, 1] - value]))
        ax.errorbar(place, 100 * value, error, fmt="o", color=colour, label=label)
    error = [100 * f["error"] for f in found.values()]
    ax.plot(np.arange(len(found)), error, "_", ms=20, color=style.GREY, label="one estimate")
    ax.set_xticks(np.arange(len(found)), list(found))
    ax.set_ylim(0)
    ax.legend(loc="upper center")
    return ax


@style.styled
def fleet_shares(shares, *, ax=None):
    """Share of the units that show each effect (or sum of processes), with its 95 % interval.

    shares : DataFrame of `fleet.shares`.
    """
    ax = style.axes(ax, x="share of the units, per cent")
    place = np.arange(len(shares))[::-1]
    value = 100 * shares.share.to_numpy()
    error = np.abs(np.stack([value - 100 * shares.low, 100 * shares.high - value]))
    ax.errorbar(value, place, xerr=error, fmt="o", color=style.DATA)
    ax.set_yticks(place, [f"{c}: {e}" for c, e in zip(shares.channel, shares.effect)])
    ax.set_xlim(0, 100)
    return ax
