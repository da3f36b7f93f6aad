"""Figures of drives, filters and outages."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from imu_lib.navigation import consistency

from . import style


@style.styled
def solution_errors(solution, drive, *, ax=None):
    """Errors of a solution against the truth of a simulated drive, with the filter's two-sigma
    bands: position, velocity, attitude.
    """
    time, error, p = consistency.errors(solution, drive)
    sd = np.sqrt(np.diagonal(p, axis1=1, axis2=2))
    axes = style.grid(3, 3, size=(9.0, 6.0), sharex=True)
    for k, (unit, scale) in enumerate((("m", 1.0), ("m/s", 1.0), ("deg", 180.0 / np.pi))):
        for j in range(3):
            a, i = axes[k, j], 3 * k + j
            style.band(a, time, -2.0 * scale * sd[:, i], 2.0 * scale * sd[:, i])
            a.plot(time, scale * error[:, i], lw=0.8)
            top = scale * max(
                6.0 * float(np.median(sd[:, i])),
                1.1 * float(np.quantile(np.abs(error[:, i]), 0.99)),
            )
            a.set_ylim(-top, top)  # the first seconds' bands would dwarf the rest
            a.set_title(
                f"{('position', 'velocity', 'attitude')[k]} {('north', 'east', 'down')[j]}, {unit}"
            )
    for a in axes[2]:
        a.set_xlabel("time, s")
    return axes[0, 0]


@style.styled
def nees_over_time(time, values, *, freedom=9, ax=None):
    """Mean NEES over runs with the 99.7 % band in which it lies where the filter is honest.

    time : (k,) s; values : ndarray, shape (runs, k)
    """
    ax = style.axes(ax, x="time, s", y=f"mean NEES of {len(values)} drives")
    band = consistency.band(values[:, 0], freedom)
    style.band(
        ax, time, np.full(len(time), band.low), np.full(len(time), band.high), label="99.7 % band"
    )
    ax.plot(time, np.mean(values, axis=0))
    ax.axhline(freedom, color=style.BLACK, lw=0.8)
    ax.legend()
    return ax


@style.styled
def free_inertial(error_time, errors, *, labels, ax=None):
    """Horizontal error of free inertial runs on a log-log scale: errors, sequence of (k,) m."""
    ax = style.axes(ax, x="time, s", y="horizontal error, m", log=True)
    for e, label in zip(errors, labels):
        ax.plot(error_time, e, label=label)
    ax.legend()
    return ax


@style.styled
def paired_intervals(rows, *, ax=None):
    """Ratios of errors with their 95 % intervals, one per line; left of 1 the first model is
    better.

    rows : sequence of `statistics.Paired`
    """
    ax = style.axes(
        ax,
        x="ratio of maximum errors (geometric mean, 95 % interval)",
        size=(7.0, 0.4 * len(rows) + 1.2),
    )
    for i, pair in enumerate(rows):
        colour = style.BLUE if pair.decided else style.GREY
        ax.plot([pair.low, pair.high], [i, i], color=colour, lw=2.0)
        ax.plot(pair.ratio, i, "o", color=colour)
    ax.axvline(1.0, color=style.BLACK, lw=0.8)
    ax.set_yticks(range(len(rows)), [f"{pair.better} over {pair.than}" for pair in rows])
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.invert_yaxis()
    return ax
