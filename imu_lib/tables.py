"""Coefficients side by side: channels and symbols down, methods across, in datasheet units."""

from __future__ import annotations

import pandas as pd

from imu_lib import report
from imu_lib.units import datasheet


def values_of(entry):
    """Symbol -> Estimate or SI value of what a method returned: a mapping, a fit or reading, or a Sum."""
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
        Title -> {channel -> {symbol -> value or (value, uncertainty)}} in datasheet units, as a paper prints them.
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
                if value is None or (only is not None and (channel, symbol) not in only) or (symbols and symbol not in symbols):
                    continue
                text = (report.estimate(value, symbol, channel, digits) if hasattr(value, "shown")
                        else report.number(value / datasheet(symbol, channel)[0], digits) if isinstance(value, float) else None)
                if text is not None:
                    rows.setdefault((channel, symbol), {})[title] = text
    order = [*methods, *(printed or {})]
    frame = pd.DataFrame({f"{c} {s}, {report.unit_name(s, c)}": row for (c, s), row in rows.items()}).T
    return frame.reindex(columns=[title for title in order if title in frame]).fillna("")
