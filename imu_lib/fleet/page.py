"""The summary of a fleet as text: tables in datasheet units, and what is to be known of them."""

from __future__ import annotations

import numpy as np

from imu_lib import units
from imu_lib.fleet.spread import CONFIDENCE, CONTENT
from imu_lib.words import listed, number


def text(summary) -> str:
    """Spreads, outliers and what they do to these, changes over dates, notes."""
    lines = [
        f"{number(summary.sensors, 'sensor')}, {number(summary.records, 'record')}, "
        f"{len(summary.errors)} left out",
        "",
    ]
    lines += _spreads(summary) + _outliers(summary) + _dates(summary) + _changes(summary)
    return "\n".join(lines + [f"note: {note}" for note in summary.notes])


def _table(rows):
    widths = [max(len(r[i]) for r in rows) for i in range(len(rows[0]))]
    return ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)).rstrip() for r in rows]


def _spreads(summary):
    if not summary.spreads:
        return ["fewer than three sensors show a coefficient: there is no spread to tell"]
    share, sure = round(100 * CONTENT), round(100 * CONFIDENCE)
    head = ("coefficient", "unit", "sensors", "typical", "scatter", f"worst of {share} %")
    rows = [
        (f"{channel} {key}", units.datasheet(key.split()[-1], channel)[1])
        + (f"{s.shown} of {s.units}", *_told(s, key, channel))
        for channel, found in summary.spreads.items()
        for key, s in found.items()
    ]
    return _table([head, *rows]) + [
        "",
        "typical [95 % interval]; scatter: standard deviation from unit to unit, the error of each "
        f"estimate taken off; worst: {share} % of all units stay below, with {sure} % confidence",
    ]


def _told(s, key, channel):
    """(typical, scatter, worst) in words."""
    factor, _ = units.datasheet(key.split()[-1], channel)
    return (
        f"{s.typical.scaled(1 / factor):.4g}",
        f"{s.scatter.scaled(100).value:.2g} % [{100 * s.scatter.low:.2g}, "
        f"{100 * s.scatter.high:.2g}]",
        f"{s.worst / factor:.4g}",
    )


def _outliers(summary):
    lines, named = [], {}
    for o in summary.outliers:
        named.setdefault((o["channel"], f"{o['method']} {o['coefficient']}"), []).append(o)
    for (channel, key), found in named.items():
        method, symbol = key.split()
        lines += [
            f"outlier: {o['sensor']}, {channel} {symbol} ({method}) is "
            f"{o['ratio']:.3g} times what the others predict (p = {o['p_value']:.1g})"
            for o in found
        ]
        who = listed([str(o["sensor"]) for o in found])
        less = summary.without_outliers.get(channel, {}).get(key)
        if less is None:
            lines.append(f"  the table includes {who}; without, too few sensors are left")
            continue
        typical, scatter, worst = _told(less, key, channel)
        lines.append(
            f"  the table includes {who}; without: typical {typical}, scatter {scatter}, "
            f"worst of {round(100 * CONTENT)} % {worst}"
        )
    return lines


def _dates(summary):
    """Change a year and scatter from date to date of each coefficient."""
    rows = []
    for channel, found in summary.spreads.items():
        for key in found:
            d = summary.drifts.get(channel, {}).get(key)
            two = summary.days.get(channel, {}).get(key)
            if d is None and two is None:
                continue
            one = ("-", "-", "-", "-")
            if two is not None:
                one = (_percent(two["sensor"]), _percent(two["day"]), two["of"])
                one += (f"{100 * two['error']:.2g} %",)
            rows.append((f"{channel} {key}", "-" if d is None else _change(d), *one))
    if not rows:
        return _silent(summary)
    head = ("coefficient", "change a year", "sensor to sensor", "within a sensor", "from")
    head += ("one estimate",)
    return ["", *_table([head, *rows]), "", *_silent(summary)]


def _percent(estimate):
    return f"{100 * estimate.value:.2g} % [{100 * estimate.low:.2g}, {100 * estimate.high:.2g}]"


def _change(d):
    ends = ", ".join(f"{100 * np.expm1(min(v, 50.0)):.3g}" for v in (d.low, d.high))
    return f"{100 * np.expm1(min(d.value, 50.0)):.3g} % [{ends}]"


def _silent(summary):
    """Why no drift is told, each reason once."""
    why = {}
    for channel, found in summary.no_drift.items():
        for key, reason in found.items():
            why.setdefault(reason, []).append(f"{channel} {key}")
    every = sum(len(found) for found in summary.spreads.values())
    return [
        f"no drift is stated{'' if len(of) == every else ' of ' + listed(of)}: {reason}"
        for reason, of in why.items()
    ]


def _changes(summary):
    lines, two = [], False
    for channel, found in summary.drifts.items():
        for key, d in found.items():
            if d.common:
                lines.append(
                    f"{channel} {key}: the sensors leave the line in time together on {d.common} "
                    "(temperature, bench?); the interval of its drift is that of the dates' means"
                )
            if d.low > 0 or d.high < 0:
                two = two or d.dates <= 3
                lines.append(_drift(channel, key, d))
    if two:
        lines.append(
            "of two or three dates, what was other on a day for all (temperature, bench) is hardly "
            "told from what goes on with time"
        )
    if summary.drifts:
        n = sum(len(found) for found in summary.drifts.values())
        lines.append(f"one in twenty of {n} such intervals leaves out 0 by chance" * (n > 1))
    for s in summary.steps:
        lines.append(
            f"step: {s['sensor']}, {s['channel']} {s['coefficient']} ({s['method']}) changes to "
            f"{s['ratio']:.3g} times from {s['before']} to {s['after']}, the others to "
            f"{s['expected']:.3g} times (p = {s['p_value']:.1g}): calibrated anew, repaired?"
        )
    return [line for line in lines if line]


def _drift(channel, key, d):
    if d.dates > 2:
        return f"drift: {channel} {key} changes by {_change(d)} a year"
    whole = [100 * np.expm1(v * d.years) for v in (d.value, d.low, d.high)]
    return (
        f"drift: {channel} {key} changes by {whole[0]:.3g} % [{whole[1]:.3g}, {whole[2]:.3g}] from "
        f"{d.first} to {d.last} ({d.sensors} sensors, each against itself)"
    )
