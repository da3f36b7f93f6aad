"""Figures of the calibration: rests, poses, the laboratory tests, repeatability."""

from __future__ import annotations

import numpy as np

from imu_lib.plots import style
from imu_lib.units import DEG, MILLI_G


@style.styled
def rest_windows(accel, fs, rests, *, ax=None):
    """Moving standard deviation of a record with the threshold found and the rests shaded.

    `accel` (n, 3) m/s^2 (its unit labels nothing: the axis is in the reading's unit), `rests` a
    `RestWindows`.
    """
    ax = style.axes(ax, x="time, s", y="standard deviation over 1 s, unit of the reading")
    t = np.arange(len(accel)) / fs
    ax.semilogy(
        *style.thin(t, np.maximum(rests.deviation, 1e-12)),
        color=style.DATA,
        lw=0.8,
        label="moving deviation",
    )
    ax.axhline(rests.threshold, color=style.THEORY, label="threshold found")
    for k, (a, b) in enumerate(zip(rests.start, rests.stop)):
        ax.axvspan(
            t[a], t[b - 1], color=style.GREEN, alpha=0.2, lw=0, label="at rest" if k == 0 else None
        )
    ax.set_ylim(top=8 * rests.deviation.max())
    ax.legend(loc="upper right", ncols=3)
    return ax


@style.styled
def pose_magnitudes(before, after, gravity, *, ax=None):
    """Length of the specific force of each pose before and after calibration, as a departure
    from gravity in mg; (k,) m/s^2 each.
    """
    ax = style.axes(ax, x="pose", y="|specific force| - g, mg")
    number = np.arange(1, len(after) + 1)
    if before is not None:
        ax.plot(
            number,
            (np.asarray(before) - gravity) / MILLI_G,
            "o",
            color=style.BEFORE,
            label="as read",
        )
    ax.plot(
        number, (np.asarray(after) - gravity) / MILLI_G, "o", color=style.AFTER, label="calibrated"
    )
    ax.axhline(0, color=style.TRUTH, lw=0.8)
    ax.legend()
    return ax


@style.styled
def panel_readings(time, reading, fits=(), *, ax=None):
    """Readings of a turned panel (n, 3) m/s^2 with the fitted sinusoids (2008 paper, Fig. 6)."""
    ax = style.axes(ax, x="time, s", y="specific force, m/s²")
    for i, axis in enumerate("xyz"):
        ax.plot(time, reading[:, i], ".", ms=1.5, color=style.channel_colour(axis), label=axis)
    for k, fit in enumerate(fits):
        model = fit.bias.value + (1 + fit.scale_factor.value) * fit.reference
        ax.plot(time, model, color=style.BLACK, lw=0.8, label="fit" if k == 0 else None)
    ax.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), markerscale=4, ncols=4
    )  # the sinusoids fill the axes
    return ax


@style.styled
def rate_table(reading, fs, rates, means, *, dwell=20.0, settle=10.0, ax=None):
    """A stepped rate-table run: readings (n,) rad/s, and the mean of each step over the part that
    is used (Fig. 9).
    """
    ax = style.axes(ax, x="time, s", y="yaw rate, deg/s")
    t = np.arange(len(reading)) / fs
    ax.plot(t, np.asarray(reading) / DEG, color=style.DATA, lw=0.8, label="reading")
    middle = dwell * np.arange(len(rates)) + (settle + dwell) / 2
    ax.plot(middle, np.asarray(means) / DEG, "o", color=style.FIT, label="mean after settling")
    ax.legend()
    return ax


@style.styled
def line_residuals(fit, *, ax=None):
    """What the fitted line leaves at each reference rate, deg/s."""
    ax = style.axes(ax, x="table rate, deg/s", y="residual, deg/s")
    ax.plot(fit.reference / DEG, fit.residual / DEG, "o", color=style.DATA)
    ax.axhline(0, color=style.TRUTH, lw=0.8)
    return ax


@style.styled
def repeatability(values, *, truth=None, unit="", labels=None, ax=None):
    """A result over repeated runs: values {name: (r,)} with their mean and one standard deviation
    (Figs. 7 and 8).

    `truth` {name: (r,)} draws what each run really had.
    """
    ax = style.axes(ax, x="run", y=unit)
    for name, color in zip(values, style.CYCLE):
        v = np.asarray(values[name])
        run = np.arange(1, len(v) + 1)
        ax.plot(run, v, "o-", color=color, lw=0.8, label=(labels or {}).get(name, name))
        ax.axhspan(v.mean() - v.std(ddof=1), v.mean() + v.std(ddof=1), color=color, alpha=0.1, lw=0)
        ax.axhline(v.mean(), color=color, lw=0.8, ls="--")
        if truth is not None:
            ax.plot(run, truth[name], "x", color=style.TRUTH, ms=6)
    ax.legend(ncols=3)
    return ax


@style.styled
def repeatability_panels(results, *, truth, units, axes=None):
    """`repeatability` of several quantities side by side: results {quantity: (r, k)} and truth
    {quantity: (r, k or more)}, columns x, y, z; `units` label the panels in turn."""
    axes = style.grid(1, len(results), size=(9.0, 3.4)) if axes is None else axes
    for ax, (name, found), unit in zip(np.ravel(axes), results.items(), units, strict=True):
        repeatability(
            dict(zip("xyz", found.T)), truth=dict(zip("xyz", truth[name].T)), unit=unit, ax=ax
        )
    return axes


@style.styled
def triad_intervals(
    triads,
    *,
    quantity="scale_factors",
    factor=100.0,
    unit="scale factor error, %",
    truth=None,
    ax=None,
):
    """A quantity of several triads side by side with 95 % intervals; `triads` {name: Triad},
    `truth` (3,).
    """
    ax = style.axes(ax, x=unit, y="")
    ticks = []
    for row, (name, triad) in enumerate(triads.items()):
        estimates = getattr(triad, quantity)
        named = estimates.items() if isinstance(estimates, dict) else zip("xyz", estimates)
        for k, (axis, e) in enumerate((a, e) for a, e in named if e is not None):
            y = len(ticks)
            color = style.CYCLE[row % len(style.CYCLE)]
            ax.plot([e.low * factor, e.high * factor], [y, y], color=color)
            ax.plot(e.value * factor, y, "o", color=color)
            if truth is not None:
                ax.plot(truth[k] * factor, y, "x", color=style.TRUTH, ms=7)
            ticks.append(f"{name} {axis}")
    ax.set_yticks(range(len(ticks)), ticks)
    ax.invert_yaxis()
    return ax
