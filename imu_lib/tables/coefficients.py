"""Coefficients of several methods side by side, and readings of a Gauss-Markov process."""

from __future__ import annotations

import numpy as np
import pandas as pd

from imu_lib import report
from imu_lib.units import datasheet

#: The parameters that the usual sums have, in the order in which a table lists them.
USUAL = ("N", "B", "sigma", "correlation_time", "K")


def values_of(entry):
    """Symbol -> Estimate or SI value of what a method returned: a mapping, a fit or reading, or a
    Sum.
    """
    if hasattr(entry, "labels"):  # a Sum
        processes = list(entry)
        return {label: getattr(processes[i], name) for label, i, name in entry.labels()}
    for attribute in ("parameters", "coefficients"):
        entry = getattr(entry, attribute, entry)
    return dict(entry)


def coefficients(methods, *, printed=None, symbols=None, digits=4):
    """One row per channel and symbol, one column per method.

    Parameters
    ----------
    methods : dict
        Title -> {channel -> mapping of symbol to Estimate or SI value, fit, reading, or Sum}.
    printed : dict or None
        Title -> {channel -> {symbol -> value or (value, uncertainty)}} in datasheet units, as a
        paper prints them.
    symbols : sequence of str or None
        Which rows; by default those that any `printed` has, or else all.
    digits : int
        Significant digits.

    Returns
    -------
    pandas.DataFrame of str
    """
    rows = {}
    for title, table in (printed or {}).items():
        for channel, entry in table.items():
            for symbol, value in entry.items():
                text = f"{value[0]:g} ± {value[1]:g}" if isinstance(value, tuple) else f"{value:g}"
                rows.setdefault((channel, symbol), {})[title] = text
    only = set(rows) if printed and symbols is None else None
    for title, table in methods.items():
        for channel, entry in table.items():
            for symbol, value in values_of(entry).items():
                if (
                    value is None
                    or (only is not None and (channel, symbol) not in only)
                    or (symbols and symbol not in symbols)
                ):
                    continue
                text = (
                    report.estimate(value, symbol, channel, digits)
                    if hasattr(value, "shown")
                    else report.number(value / datasheet(symbol, channel)[0], digits)
                    if isinstance(value, float)
                    else None
                )
                if text is not None:
                    rows.setdefault((channel, symbol), {})[title] = text
    order = [*methods, *(printed or {})]
    frame = pd.DataFrame(
        {f"{c} {s}, {report.unit_name(s, c)}": row for (c, s), row in rows.items()}
    ).T
    return frame.reindex(columns=[title for title in order if title in frame]).fillna("")


def held(fits, truths):
    """Whether the 95 % interval of each parameter that has a true value holds it: {(channel,
    symbol): bool}.

    `fits` and `truths` map channels to what `values_of` reads.
    """
    true = {c: values_of(entry) for c, entry in truths.items()}
    return {
        (c, k): e.covers(true[c][k])
        for c, fit in fits.items()
        for k, e in values_of(fit).items()
        if k in true[c]
    }


def gauss_markov(truth, reading, fit):
    """Sigma and correlation time of a Gauss-Markov process by several ways, and the driving
    density that they make.

    `truth` is the Sum that has the process, `reading` what `allan.read_off` says of its curve
    (taken as the flat part, and as the process's peak), `fit` an AllanFit.
    """
    process, found = truth.find("gauss_markov"), values_of(fit)
    ways = {
        "truth": (process.sigma, process.correlation_time),
        "flat part": (reading.flat, reading.correlation_time),
        "peak": (reading.sigma, reading.peak_correlation_time),
        "fit": (found["sigma"], found["correlation_time"]),
    }
    values = {
        way: np.array([getattr(v, "value", v) for v in pair], dtype=float)
        for way, pair in ways.items()
    }
    return pd.DataFrame(
        {
            way: {"sigma": sigma, "Tc, s": time, "driving density 2 sigma²/Tc": 2 * sigma**2 / time}
            for way, (sigma, time) in values.items()
        }
    ).T


def flat_parts(records, readings, printed=None):
    """What is read off the flat part, and the standard deviation, by channel; `printed` as
    {channel: (Tc, std)} beside it.

    Returns
    -------
    pandas.DataFrame of str
    """
    table = pd.DataFrame(
        {
            c: {"Tc read, s": readings[c].correlation_time.value, "std": np.std(records[c])}
            for c in readings
        }
    ).T
    if printed:
        table[["2013: Tc, s", "2013: std"]] = [printed[c] for c in table.index]
    return table.astype(float).map("{:.4g}".format).replace("nan", "none found")


def autoregressive_models(models, printed=None):
    """Coefficients (the papers' sign), variance of the driving noise and largest pole of models.

    Parameters
    ----------
    models : dict
        Title -> model with `alpha`, `sigma` and `poles`.
    printed : dict or None
        Title -> (alpha, beta0²) as a paper prints them.

    Returns
    -------
    pandas.DataFrame of float
    """
    rows = {title: [*m.alpha, m.sigma**2, np.max(np.abs(m.poles))] for title, m in models.items()}
    for title, (alpha, variance) in (printed or {}).items():
        rows[title] = [*alpha, variance, np.max(np.abs(np.roots([1.0, *alpha])))]
    order = max(map(len, rows.values())) - 2
    names = [*(f"alpha {k + 1}" for k in range(order)), "beta0²", "largest pole"]
    return pd.DataFrame(rows, index=names).T
