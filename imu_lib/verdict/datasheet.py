"""The coefficients of a record as a datasheet would print them, each with its interval."""

from __future__ import annotations

import pandas as pd

from imu_lib import report
from imu_lib.estimate import Estimate

#: Symbol -> what a datasheet calls it on gyros and on accelerometers, and the method it is from.
ROWS = {
    "N": ("angle random walk N", "velocity random walk N", "likelihood"),
    "B": ("bias instability B", "bias instability B", "allan"),
    "K": ("rate random walk K", "acceleration random walk K", "likelihood"),
    "sigma": ("Gauss-Markov sigma", "Gauss-Markov sigma", "likelihood"),
    "correlation_time": ("correlation time Tc", "correlation time Tc", "likelihood"),
    "Q": ("angle quantization Q", "velocity quantization Q", "allan"),
    "R": ("rate ramp R", "acceleration ramp R", "allan"),
}


def _limit(estimate):
    """What an estimate allows at most."""
    return None if estimate is None else Estimate(None, 0.0, estimate.high)


def bias_instability(channel):
    """Of the chosen sum where flicker noise is in it, else of the flat part of the Allan curve."""
    found = channel.likelihood.get("B")
    return found if found is not None and found.shown else channel.allan.get("B")


def coefficient(channel, symbol: str) -> Estimate | None:
    """What the datasheet prints of a channel."""
    if symbol == "B":
        return bias_instability(channel)
    estimate = getattr(channel, ROWS[symbol][2]).get(symbol) or channel.allan.get(symbol)
    if symbol == "R" and "ramp" not in {t.name for t in channel.model.terms}:
        return _limit(estimate)  # the chosen sum explains the rise otherwise
    return estimate


def datasheet(result, sensor: str) -> pd.DataFrame:
    """One row per coefficient, one column per axis; `value [95 % interval]`, or `< limit`.

    Parameters
    ----------
    result : imu_lib.characterise.Characterisation
    sensor : "gyro" or "accel"
    """
    names = [name for name in result.channels if name.startswith(sensor)]
    rows = {}
    for symbol, (gyro, accel, _) in ROWS.items():
        cells = {}
        for name in names:
            estimate = coefficient(result[name], symbol)
            cells[name[-1]] = (
                "not shown" if estimate is None else report.estimate(estimate, symbol, name, 3)
            )
        if set(cells.values()) != {"not shown"}:
            title = gyro if sensor == "gyro" else accel
            rows[f"{title}, {report.unit_name(symbol, names[0])}"] = cells
    rows["sum of processes"] = {name[-1]: result[name].choice.name for name in names}
    rows["goodness of fit, p"] = {
        name[-1]: report.probability(result[name].choice.p_value) for name in names
    }
    return pd.DataFrame(rows).T
