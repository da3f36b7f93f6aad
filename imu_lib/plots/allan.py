"""Figures of the Allan deviation: curves with intervals, theory over them, lines read off, errors,
fits.
"""

import numpy as np

from imu_lib import units
from imu_lib.allan import papers_error
from imu_lib.plots import style
from imu_lib.processes import Sum

NAMES = {
    "Q": "quantization",
    "N": "random walk of the integral",
    "B": "bias instability",
    "K": "rate random walk",
    "R": "ramp",
    "quantization": "quantization",
    "white_noise": "white noise",
    "flicker": "flicker",
    "random_walk": "random walk",
    "ramp": "ramp",
    "gauss_markov": "Gauss-Markov",
    "sinusoid": "sinusoid",
}


def _axes(ax, channel, size=style.SIZE):
    factor, unit = units.datasheet("signal", channel) if channel else (1.0, "signal unit")
    return style.axes(
        ax, x="averaging time, s", y=f"Allan deviation, {unit}", log=True, size=size
    ), factor


def _fit_height(ax, values, factor):
    values = np.concatenate([np.ravel(v) for v in values]) / factor
    values = values[np.isfinite(values) & (values > 0)]
    ax.set_ylim(values.min() / 3, values.max() * 2)


@style.styled
def allan(curve, model=None, *, channel="", ax=None):
    """An Allan curve with its 95 % interval; with a model, the closed form over it and each term
    dashed.
    """
    ax, factor = _axes(ax, channel)
    style.band(
        ax,
        curve.tau,
        curve.low / factor,
        curve.high / factor,
        color=style.DATA,
        label="95 % interval",
    )
    ax.plot(curve.tau, curve.adev / factor, ".", color=style.DATA, label="record")
    if model is not None:
        model = model if isinstance(model, Sum) else Sum((model,))
        # whole numbers of samples: between them an averaging time has no exact closed form
        tau = (
            np.unique(np.rint(np.geomspace(curve.tau[0], curve.tau[-1], 300) * curve.fs)) / curve.fs
        )
        for colour, term in zip(
            style.TERMS, [t for t in model.terms if np.any(t.avar(tau, curve.fs) > 0)], strict=False
        ):
            ax.plot(
                tau,
                np.sqrt(term.avar(tau, curve.fs)) / factor,
                "--",
                color=colour,
                linewidth=1.0,
                label=NAMES.get(term.name, term.name),
            )
        ax.plot(tau, np.sqrt(model.avar(tau, curve.fs)) / factor, color=style.FIT, label="model")
    _fit_height(ax, [curve.adev], factor)
    ax.legend()
    return ax


@style.styled
def allan_curves(curves, *, kind="", ax=None):
    """Several channels of one kind on one set of axes, channel -> AllanCurve, with their
    intervals.

    `kind` ("gyro", "accel") picks them by name; where there is none, nothing is drawn.
    """
    curves = {channel: curve for channel, curve in curves.items() if channel.startswith(kind)}
    if not curves:
        return ax
    ax, factor = _axes(ax, next(iter(curves)))
    for channel, curve in curves.items():
        colour = style.channel_colour(channel)
        style.band(ax, curve.tau, curve.low / factor, curve.high / factor, color=colour)
        ax.plot(curve.tau, curve.adev / factor, color=colour, label=style.channel_label(channel))
    _fit_height(ax, [curve.adev for curve in curves.values()], factor)
    ax.legend()
    return ax


@style.styled
def allan_lines(curve, reading, *, channel="", ax=None):
    """An Allan curve with the lines that were read off it, thick where the stretch was found."""
    ax, factor = _axes(ax, channel)
    ax.plot(curve.tau, curve.adev / factor, ".", color=style.DATA, label="record")
    style.lines_read_off(ax, curve.tau, reading, channel, lambda line: line.at(curve.tau) / factor)
    _fit_height(ax, [curve.adev], factor)
    ax.legend()
    return ax


@style.styled
def allan_panels(curves, readings, *, kind="", axes=None):
    """`allan_lines` of the channels of one kind side by side, channel -> AllanCurve and channel ->
    Reading.
    """
    curves = {channel: curve for channel, curve in curves.items() if channel.startswith(kind)}
    axes = style.grid(1, len(curves), size=(9.5, 3.6)) if axes is None else axes
    for ax, (channel, curve) in zip(np.ravel(axes), curves.items(), strict=True):
        allan_lines(curve, readings[channel], channel=channel, ax=ax)
        ax.set_title(style.channel_label(channel))
    return axes


@style.styled
def allan_terms(model, tau, *, ax=None, title=""):
    """The closed forms of a sum and of each of its terms: the textbook's picture of the slopes."""
    ax = style.axes(
        ax, x="averaging time, s", y="Allan deviation, signal unit", log=True, title=title
    )
    for colour, term in zip(style.TERMS, model.terms, strict=False):
        ax.plot(
            tau, np.sqrt(term.avar(tau)), "--", color=colour, label=NAMES.get(term.name, term.name)
        )
    total = np.sqrt(model.avar(tau))
    ax.plot(tau, total, color=style.TRUTH, linewidth=2, label="sum")
    ax.set_ylim(total.min() / 4, total.max() * 2)
    ax.legend()
    return ax


@style.styled
def allan_errors(curve, *, channel="", fit=None, axes=None):
    """A curve with bars of one standard error by the papers' formula, and that error against the
    degrees of freedom.
    """
    left, right = np.ravel(style.grid(1, 2, size=(9.0, 3.4)) if axes is None else axes)
    left, factor = _axes(left, channel)
    every = slice(None, None, 3)
    error = curve.papers_error
    left.errorbar(
        curve.tau[every],
        curve.adev[every] / factor,
        yerr=(curve.adev * error)[every] / factor,
        fmt=".",
        color=style.DATA,
        capsize=2,
    )
    style.axes(right, x="averaging time, s", y="relative standard error", log=True)
    right.plot(curve.tau, error, color=style.PAPER, label="papers: n/m clusters")
    right.plot(
        curve.tau,
        np.sqrt(0.5 / curve.edf),
        color=style.DATA,
        label="degrees of freedom, overlapped",
    )
    if fit is not None:
        right.plot(fit.tau, fit.sd, "x", color=style.FIT, label="from the fitted model")
    right.legend()
    return np.array([left, right])


@style.styled
def allan_deviations(curves, model, *, ax=None, channel=""):
    """Several kinds of deviation of one record, label -> (tau, deviation), over the Allan closed
    form.
    """
    ax, factor = _axes(ax, channel)
    for colour, (label, (tau, value)) in zip(style.CYCLE, curves.items(), strict=False):
        ax.plot(
            tau,
            np.asarray(value) / factor,
            ".-",
            markersize=3,
            linewidth=0.8,
            color=colour,
            label=label,
        )
    tau = np.unique(np.concatenate([np.asarray(t) for t, _ in curves.values()]))
    ax.plot(tau, np.sqrt(model.avar(tau)) / factor, color=style.TRUTH, label="closed form, Allan")
    ax.legend()
    return ax


@style.styled
def coefficients(table, *, ax=None, title="", logarithmic=True):
    """Estimates side by side: label -> {method: Estimate or value}; bars are 95 % intervals,
    arrows upper limits.
    """
    methods = list(dict.fromkeys(m for row in table.values() for m in row))
    ax = style.axes(ax, title=title, size=(7.0, 0.5 * len(table) + 1.4))
    for k, row in enumerate(table.values()):
        for j, method in enumerate(methods):
            if method not in row:
                continue
            y, e = k + 0.7 * (j / max(len(methods) - 1, 1) - 0.5), row[method]
            colour = style.CYCLE[j % len(style.CYCLE)]
            name = method if k == 0 else None
            if not hasattr(e, "shown"):
                ax.plot(e, y, "D", color=colour, markersize=5, label=name)
            elif e.shown:
                ax.plot([e.low, e.high], [y, y], color=colour)
                ax.plot(e.value, y, "o", color=colour, label=name)
            else:
                ax.plot(e.high, y, "<", color=colour, label=name)
    ax.set_yticks(range(len(table)), list(table))
    if logarithmic:
        ax.set_xscale("log")
    ax.invert_yaxis()
    ax.legend()
    return ax


@style.styled
def papers_error_map(durations_h, fs, *, ax=None):
    """The papers' relative error against averaging time for several record lengths (h)."""
    ax = style.axes(ax, x="averaging time, s", y="relative standard error", log=True)
    for hours in durations_h:
        n = int(hours * 3600 * fs)
        m = np.unique(np.geomspace(1, n // 3, 80).astype(int))
        ax.plot(m / fs, papers_error(n, m), label=f"{hours:g} h")
    ax.legend()
    return ax
