"""Stored studies and repeated runs as tables: coverage, outages, wavelet levels, calibrations."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from imu_lib import published
from imu_lib.calibration import repeatability as repeats


def coverage(path, methods=None):
    """A study stored by `benchmarks/interval_coverage.py`: one row per method and parameter,
    pooled over channels.

    Returns
    -------
    pandas.DataFrame
        Number of seeds, share of 95 % intervals that hold the truth, median of estimate / truth,
        standard deviation of its logarithm, share of draws in which the term was not shown. The
        row `all` pools a method's parameters.
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
    """What a benchmark stored (a file of benchmarks/results): its tables with `command` and
    `date`.
    """
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


def paper_outages(stored, what="max"):
    """What `benchmarks/outages_paper.py` stored: median and 95 % range over the draws, the paper's
    value, and in brackets the share of draws below it; outages down, models across, m.

    Returns
    -------
    pandas.DataFrame of str
    """
    columns = {}
    for name, entry in stored[what].items():
        columns[name] = [
            f"{q[2]:.3g} [{q[0]:.2g}, {q[-1]:.3g}]; paper {printed:.3g} ({rank:.0%})"
            for q, printed, rank in zip(entry["quantiles"], entry["paper"], entry["rank"])
        ]
    index = [
        f"{o.number}, {o.duration_s:.0f} s, {o.speed_km_h:.0f} km/h" for o in published.OUTAGES_2013
    ]
    return pd.DataFrame(columns, index=pd.Index(index, name="outage"))


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
    intervals that hold the truth by sensor and quantity, and the median half width of the scale
    factors'.

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
