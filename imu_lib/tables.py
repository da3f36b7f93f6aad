"""Tables that chapters print: coefficients side by side, readings of a Gauss-Markov process,
outages, stored studies.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from imu_lib import published, report
from imu_lib.calibration import repeatability as repeats
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
    (taken as the flat part, and as
    the process's peak), `fit` an AllanFit.
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


def coverage(path, methods=None):
    """A study stored by `benchmarks/interval_coverage.py`: one row per method and parameter,
    pooled over channels.

    Returns
    -------
    pandas.DataFrame
        Number of seeds, share of 95 % intervals that hold the truth, median of estimate / truth,
        standard deviation of
        its logarithm, share of draws in which the term was not shown. The row `all` pools a
        method's parameters.
    """
    stored = json.loads(Path(path).read_text())["methods"]
    rows = {}
    for method in methods or stored:
        entry = stored[method]
        seeds = entry["seeds"][1] - entry["seeds"][0] + 1
        for name, line in entry["pooled"].items():
            rows[method, name] = (
                seeds,
                line["covered"],
                line.get("median_ratio"),
                line.get("sd_of_log"),
                line["not_shown"],
            )
        rows[method, "all"] = (seeds, entry["pooled_all"], None, None, None)
    return pd.DataFrame(
        rows, index=["seeds", "covered", "median ratio", "scatter of log", "not shown"], dtype=float
    ).T


def coverage_by_channel(path, methods, parameters=("N", "sigma", "correlation_time", "K", "flat")):
    """Of the same study the share of intervals that hold the truth, channels down, (method,
    parameter) across.
    """
    stored = json.loads(Path(path).read_text())["methods"]
    columns = {
        (method, k): {
            c: lines[k]["covered"] for c, lines in stored[method]["channels"].items() if k in lines
        }
        for method in methods
        for k in parameters
    }
    return pd.DataFrame(columns)


def stored(path):
    """What a benchmark stored (benchmarks/results/*.json): its tables with `command` and `date`."""
    return json.loads(Path(path).read_text(encoding="utf-8"))


def medians(columns, *, digits=1, predicted=None):
    """Median errors with their 95 % intervals, models down: `columns` {title: {model: {"median":
    (value, low, high), ...}}}.

    `predicted` names the column whose predicted standard deviation stands beside.

    Returns
    -------
    pandas.DataFrame of str
    """
    text = "{0:.{3}f} [{1:.{3}f}, {2:.{3}f}]".format
    table = {
        title: {name: text(*m["median"], digits) for name, m in entries.items()}
        for title, entries in columns.items()
    }
    if predicted:
        table[f"predicted, {predicted}"] = {
            name: f"{m['predicted']:.{digits}f}" for name, m in columns[predicted].items()
        }
    return pd.DataFrame(table)


def outage_errors(studies):
    """Mean and maximum errors of the 2013 paper's seven outages, m, models across; in brackets
    what the paper prints.

    `studies` are the `OutageStudy` of its drives, whose outages are numbered on.

    Returns
    -------
    pandas.DataFrame of str
    """
    names, rows = list(studies[0].models), {}
    for what in ("mean", "max"):
        ours = {n: np.concatenate([s.errors(n, what=what) for s in studies]) for n in names}
        theirs = published.outage_errors_2013(what)
        for k, o in enumerate(published.OUTAGES_2013):
            rows[o.number, what] = {n: f"{ours[n][k]:.3g} ({theirs[n][k]:.3g})" for n in names}
    return pd.DataFrame(
        {
            f"{o.number}, {o.duration_s:.0f} s, {what}": rows[o.number, what]
            for o in published.OUTAGES_2013
            for what in ("mean", "max")
        }
    ).T


def level_errors(ours):
    """Maximum errors of the 2013 paper's Table 6 by wavelet level, m: as printed, and `ours`
    {level: (7,)} beside it.

    Returns
    -------
    pandas.DataFrame of float
    """
    printed = {f"paper, {level}": values for level, values in published.level_errors_2013().items()}
    index = [f"{o.number}*, {o.speed_table6_km_h:.0f} km/h" for o in published.OUTAGES_2013]
    return pd.DataFrame(
        printed | {f"ours, {level}": values for level, values in ours.items()}, index=index
    )


def repeatability(results, means, deviations):
    """How results repeat: {quantity: (runs, axes)} with the `means` and `deviations` {quantity:
    (axes or more)} that a paper prints.

    Returns
    -------
    pandas.DataFrame of str
    """
    rows = {}
    for quantity, values in results.items():
        for axis, column, mean, deviation in zip(
            "xyz", np.asarray(values).T, means[quantity], deviations[quantity]
        ):
            found = repeats(column)
            rows[f"{quantity} {axis}"] = {
                "mean": f"{found.mean.value:.3f}",
                "St.D.": f"{found.sd:.3f}",
                "paper, mean": f"{mean:g}",
                "paper, St.D.": f"{deviation:g}",
            }
    return pd.DataFrame(rows).T


def calibration_coverage(study):
    """What `benchmarks/calibration_coverage.py` stored, numbers of poses across: share of 95 %
    intervals that hold the truth by
    sensor and quantity, and the median half width of the scale factors'.

    Returns
    -------
    pandas.DataFrame of str
    """
    rows = {}
    for name, entry in study["results"].items():
        poses, sensor, quantity = name.split(", ")
        rows.setdefault(f"{sensor}, {quantity}", {})[poses] = f"{entry['coverage_percent']:.0f} %"
        if quantity == "scale factor":
            rows.setdefault(f"{sensor}, half width", {})[poses] = (
                f"{100 * entry['median_half_width']:.2g} %"
            )
    return pd.DataFrame(rows).T
