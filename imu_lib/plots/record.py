"""Figures of records: the signals as they came, their clock, the grid they were rounded to."""

import numpy as np

from imu_lib import units
from imu_lib.plots import style

UNIT = {"gyro": (units.DEG_PER_S, "deg/s"), "accel": (units.MILLI_G, "mg")}


@style.styled
def record_signals(record, *, axes=None):
    """Every channel about its mean over time, an axis a row, gyros and accelerometers a column
    each; gaps are grey.

    Returns ndarray of axes, shape (rows, columns).
    """
    columns = [[c for c in record.channel_names if c.startswith(kind)] for kind in UNIT]
    columns = [c for c in columns if c]
    rows = max(map(len, columns))
    if axes is None:
        axes = style.grid(
            rows, len(columns), size=(4.2 * len(columns), 0.8 + 1.6 * rows), sharex=True
        )
    time = record.times()
    for column, names in enumerate(columns):
        for row, name in enumerate(names):
            factor, unit = UNIT[name.partition("_")[0]]
            panel, x = axes[row, column], record[name]
            panel.plot(
                *style.thin(time, (x - np.nanmean(x)) / factor, points=2000),
                color=style.channel_colour(name),
                linewidth=0.6,
            )
            for gap in record.gaps():
                panel.axvspan(
                    gap.start, gap.start + gap.duration, color=style.GREY, alpha=0.4, linewidth=0
                )
            panel.set(ylabel=unit)
            panel.set_title(style.channel_label(name), fontsize="small")
        for row in range(len(names), rows):
            axes[row, column].set_axis_off()
        axes[len(names) - 1, column].set(xlabel="time, s")
    return axes


@style.styled
def record_lateness(record, *, ax=None):
    """How late each stamp is, ms, against an even grid that begins with the first sample and
    misses none.
    """
    ax = style.axes(ax, x="time, s", y="stamp against even sampling, ms")
    time = record.times()
    late = (time - np.arange(record.n) / record.rate) * 1e3
    ax.plot(time, late, ".", color=style.DATA, markersize=3, label="stamps")
    kept = (record.slots() - np.arange(record.n)) / record.rate * 1e3
    ax.plot(time, kept, color=style.FIT, label="samples counted as missing")
    ax.legend(loc="upper left")
    return ax


@style.styled
def record_levels(x, resolution, *, unit=1.0, label="", ax=None):
    """How often each output value of x (n,) occurs, at most 60 steps of `resolution` about the
    median; `unit` divides both for display.
    """
    ax = style.axes(ax, x=f"output{', ' + label if label else ''}", y="samples")
    x = x[np.isfinite(x)]
    centre = np.median(x)
    near = x[np.abs(x - centre) < 30 * resolution]
    level, count = np.unique(np.rint(near / resolution), return_counts=True)
    ax.vlines(level * resolution / unit, 0, count, color=style.DATA, linewidth=2.0)
    ax.set_ylim(bottom=0)
    return ax
