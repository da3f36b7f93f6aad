"""Figures of the likelihood fit: spectrum with the model over it, its terms, residuals,
candidates, intervals.
"""

import numpy as np
from scipy.stats import chi2

from imu_lib import units
from imu_lib.likelihood import density, residuals
from imu_lib.processes import Sum

from . import style

LABELS = {
    "white_noise": "white noise",
    "gauss_markov": "Gauss-Markov",
    "gauss_markov_2": "second-order Gauss-Markov",
    "random_walk": "random walk",
    "flicker": "flicker",
    "quantization": "quantization",
}


def _bands(statistics, per_decade=10):
    """Statistics merged for drawing: frequency, density, its 95 % interval."""
    group = np.unique(np.floor(np.log10(statistics.frequency) * per_decade), return_inverse=True)[1]
    count = np.bincount(group, statistics.count)
    power = np.bincount(group, statistics.power)
    f = np.exp(np.bincount(group, np.log(statistics.frequency)) / np.bincount(group))
    keep = count > 0
    count, power = count[keep], power[keep]
    return f[keep], power / count, power / chi2.ppf(0.975, count), power / chi2.ppf(0.025, count)


@style.styled
def fitted_spectrum(fit, *, unit="unit", ax=None):
    """Averaged spectrum of a record with the fitted model over it and each of its terms dashed."""
    ax = style.axes(ax, x="frequency, Hz", y=f"one-sided density, ({unit})$^2$/Hz", log=True)
    f, value, low, high = _bands(fit.statistics)
    style.band(ax, f, low, high, color=style.DATA, label="95 % interval")
    ax.plot(f, value, ".", color=style.DATA, label="record")
    dense = np.geomspace(fit.statistics.frequency[0], fit.statistics.frequency[-1], 300)
    noise = fit.model.noise
    for colour, term in zip(
        (style.GREEN, style.PURPLE, style.ORANGE, style.SKY, style.GREY), noise.terms
    ):
        one = Sum((term,), tuple(s for s in noise.stages if s.name == "low_pass"))
        ax.plot(
            dense,
            one.psd(dense, fit.statistics.rate),
            "--",
            color=colour,
            label=LABELS.get(term.name, term.name),
        )
    ax.plot(dense, noise.psd(dense, fit.statistics.rate), color=style.FIT, label="model")
    ax.set_ylim(0.2 * low.min(), 5 * value.max())
    ax.legend()
    return ax


@style.styled
def fit_residuals(fit, *, ax=None):
    """Normal scores of the bands under the fitted model; 95 % of them lie between the lines if it
    is true.
    """
    ax = style.axes(ax, x="frequency, Hz", y="normal score")
    ax.semilogx(
        fit.statistics.frequency, residuals(fit.statistics, fit.model), ".", color=style.DATA
    )
    for level in (-1.96, 1.96):
        ax.axhline(level, color=style.BLACK, linewidth=0.8)
    ax.set_title(f"goodness of fit: p = {fit.p_value:.2g}")
    return ax


@style.styled
def candidates(choice, *, ax=None):
    """Candidate sums by the distance of their BIC from the best, with each one's goodness of
    fit.
    """
    rows = choice.rows()[::-1]
    ax = style.axes(
        ax, x="BIC above the best (logarithmic from 10 on)", size=(7.0, 0.4 * len(rows) + 1.0)
    )
    value = np.array([row[2] for row in rows])
    colours = [style.AFTER if row[4] > 0.05 else style.BEFORE for row in rows]
    ax.barh([row[0] for row in rows], np.maximum(value, 0.15), color=colours)
    ax.set_xscale("symlog", linthresh=10)
    ax.axvline(2 * np.log(20), color=style.BLACK, linewidth=0.8)
    for y, row in enumerate(rows):
        ax.annotate(
            f"p = {row[4]:.1g}",
            (max(row[2], 0.15), y),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize="small",
        )
    ax.margins(x=0.15)
    return ax


@style.styled
def intervals(estimates, *, truth=None, unit="", ax=None):
    """Estimates of one quantity by several methods, a dict of name to Estimate, with the truth as
    a line.
    """
    ax = style.axes(ax, x=unit, size=(7.0, 0.4 * len(estimates) + 0.9))
    for y, e in enumerate(reversed(estimates.values())):
        if e.value is None:
            if np.isfinite(e.high):
                ax.plot([e.high], [y], "<", color=style.GREY)
                ax.plot([0, e.high], [y, y], ":", color=style.GREY)
            continue
        high = e.high if np.isfinite(e.high) else 3 * e.value
        ax.plot([max(e.low, 0), high], [y, y], color=style.DATA, linewidth=2)
        ax.plot([e.value], [y], "o", color=style.DATA)
    ax.set_yticks(range(len(estimates)), list(reversed(estimates)))
    ax.set_ylim(-0.6, len(estimates) - 0.4)
    if truth is not None:
        ax.axvline(truth, color=style.TRUTH, linewidth=1, label="truth")
        ax.legend()
    return ax


def _sensor_unit(channel):
    """(factor to the plotted unit, its name): deg/h for a gyro, mg for an accelerometer."""
    return (units.DEG_PER_HOUR, "deg/h") if channel.startswith("gyro") else (units.MILLI_G, "mg")


@style.styled
def characterised_allan(result, sensor, *, ax=None):
    """Allan deviations of a sensor's axes with the chosen models over them, from a
    Characterisation.
    """
    factor, unit = _sensor_unit(sensor)
    ax = style.axes(ax, x="averaging time, s", y=f"Allan deviation, {unit}", log=True)
    for name in (name for name in result.channels if name.startswith(sensor)):
        curve, colour = result[name].curve, style.channel_colour(name)
        style.band(ax, curve.tau, curve.low / factor, curve.high / factor, color=colour)
        ax.plot(curve.tau, curve.adev / factor, ".", color=colour, label=style.channel_label(name))
        ax.plot(
            curve.tau,
            np.sqrt(result[name].model.noise.avar(curve.tau, curve.fs)) / factor,
            color=colour,
        )
    ax.legend(title="points: record, lines: model")
    return ax


@style.styled
def characterised_spectrum(result, sensor, *, ax=None):
    """Averaged spectra of a sensor's axes with the chosen models over them, from a
    Characterisation.
    """
    factor, unit = _sensor_unit(sensor)
    ax = style.axes(ax, x="frequency, Hz", y=f"one-sided density, ({unit})$^2$/Hz", log=True)
    for name in (name for name in result.channels if name.startswith(sensor)):
        statistics, colour = result[name].choice.fit.statistics, style.channel_colour(name)
        f, value, _, _ = _bands(statistics)
        ax.plot(f, value / factor**2, ".", color=colour, label=style.channel_label(name))
        ax.plot(
            statistics.frequency,
            density(statistics, result[name].model.noise) / factor**2,
            color=colour,
        )
    ax.legend(title="points: record, lines: model")
    return ax


@style.styled
def models_allan(curve, models, *, channel, ax=None):
    """An Allan deviation with several models of it, a dict of name to Sum."""
    factor, unit = _sensor_unit(channel)
    ax = style.axes(
        ax,
        x="averaging time, s",
        y=f"Allan deviation, {unit}",
        log=True,
        title=style.channel_label(channel),
    )
    style.band(ax, curve.tau, curve.low / factor, curve.high / factor, color=style.DATA)
    ax.plot(curve.tau, curve.adev / factor, ".", color=style.DATA, label="record")
    for colour, (name, model) in zip((style.FIT, style.PAPER, style.GREEN), models.items()):
        ax.plot(
            curve.tau,
            np.sqrt(model.noise.avar(curve.tau, curve.fs)) / factor,
            color=colour,
            label=name,
        )
    ax.legend()
    return ax


@style.styled
def spectral_lines(lines, *, unit, factor=1.0, ax=None):
    """Spectral lines by channel, a dict of name to ((frequency, rms), ...): do the channels share
    them?
    """
    ax = style.axes(ax, x="frequency, Hz", y=f"rms of the line, {unit}")
    for shift, (name, found) in enumerate(lines.items()):
        f, rms = np.array(found).reshape(-1, 2).T
        ax.semilogy(
            f,
            rms / factor,
            ("o", "x", "+")[shift % 3],
            color=style.channel_colour(name),
            markersize=4,
            fillstyle="none",
            label=style.channel_label(name),
        )
    ax.legend()
    return ax


@style.styled
def coverage(shares, *, draws, ax=None):
    """Share of 95 % intervals that hold the truth: dict of method to {parameter: share}, with what
    chance allows at 95 %.
    """
    parameters = list(dict.fromkeys(p for row in shares.values() for p in row))
    ax = style.axes(ax, y="share that holds the truth")
    width = 0.8 / len(shares)
    for k, (method, row) in enumerate(shares.items()):
        at = [i + (k - (len(shares) - 1) / 2) * width for i, p in enumerate(parameters) if p in row]
        ax.bar(
            at,
            [row[p] for p in parameters if p in row],
            width * 0.9,
            label=method,
            color=style.CYCLE[k],
        )
    spread = 1.96 * np.sqrt(0.95 * 0.05 / draws)
    ax.axhspan(0.95 - spread, min(0.95 + spread, 1.0), color=style.GREY, alpha=0.3, zorder=0)
    ax.axhline(0.95, color=style.BLACK, linewidth=0.8)
    ax.set_xticks(range(len(parameters)), parameters)
    ax.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return ax
