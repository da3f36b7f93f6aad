"""Figures of autocorrelations and of the Gauss-Markov process read from them."""

import numpy as np

from imu_lib.plots import style


@style.styled
def autocorrelations(curves, *, exact=None, ax=None):
    """Autocorrelation of each of `curves` (label -> Autocorrelation), the 95 % band of white
    noise, and `exact`.

    `exact` is (label, function of the lag in s) or None.
    """
    ax = style.axes(ax, x="lag, s", y="autocorrelation")
    for label, curve in curves.items():
        colour = style.channel_colour(label) if label[-2:] in ("_x", "_y", "_z") else None
        t, rho = style.thin(curve.lag, curve.rho)
        ax.plot(t, rho, color=colour, label=style.channel_label(label))
        half = curve.white_band()
    ax.axhspan(-half, half, color=style.BAND, alpha=0.25, linewidth=0, label="95 % of white noise")
    if exact:
        ax.plot(curve.lag, exact[1](curve.lag), color=style.TRUTH, linestyle="--", label=exact[0])
    ax.set_xlim(-0.02 * curve.lag[-1], curve.lag[-1])  # the drop from lag 0 is a line of its own
    ax.legend(loc="best")
    return ax


@style.styled
def before_and_after(before, after, *, titles=("raw", "de-noised"), axes=None):
    """Two panels of autocorrelations, each label -> Autocorrelation."""
    if axes is None:
        axes = style.grid(1, 2, size=(9.0, 3.4), sharey=True)[0]
    for ax, curves, title in zip(axes, (before, after), titles, strict=True):
        autocorrelations.__wrapped__(curves, ax=ax)
        ax.set_title(title)
    axes[1].set_ylabel("")
    axes[1].get_legend().remove()
    return axes


@style.styled
def gauss_markov_fit(fit, *, truth=None, unit=("", 1.0), ax=None):
    """Autocovariance of the block means, the fit, and the true autocovariance (a function of the
    lag) if known.
    """
    name, factor = unit
    ax = style.axes(
        ax, x="lag, s", y=f"autocovariance of block means{', (' + name + ')²' if name else ''}"
    )
    scale = 1 / factor**2
    ax.plot(
        fit.lag[1:],
        fit.autocovariance[1:] * scale,
        "o",
        color=style.DATA,
        label=f"record, means of {fit.block} samples",
    )
    ax.plot(
        fit.lag[1:],
        fit.fitted[1:] * scale,
        color=style.FIT,
        label="fit, the record's own mean taken off",
    )
    if truth is not None:
        ax.plot(fit.lag[1:], truth(fit.lag[1:]) * scale, "--", color=style.TRUTH, label="truth")
    ax.axhline(0, color=style.BAND, linewidth=0.8)
    ax.legend()
    return ax


@style.styled
def record_length(ratio, scatter, *, rule, ax=None):
    """Relative scatter of estimates (label -> array) against record length in correlation times,
    with the `rule`.
    """
    ax = style.axes(
        ax, x="record length, correlation times", y="relative standard deviation", log=True
    )
    for label, values in scatter.items():
        ax.plot(ratio, values, "o-", label=label)
    fine = np.geomspace(min(ratio), max(ratio), 50)
    ax.plot(fine, rule(fine), "--", color=style.TRUTH, label="rule, sqrt(2 Tc / T)")
    ax.axvline(200, color=style.BAND, linewidth=0.8)
    ax.axhline(0.1, color=style.BAND, linewidth=0.8)
    ax.legend()
    return ax
