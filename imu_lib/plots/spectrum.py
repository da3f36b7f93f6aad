"""Figures of the power spectral density: raw and averaged, theory over it, lines read off, the
filter's roll-off.
"""

import numpy as np

from imu_lib import units
from imu_lib.plots import style
from imu_lib.plots.allan import NAMES
from imu_lib.processes import Sum


def _axes(ax, channel, size=style.SIZE):
    factor, unit = units.datasheet("signal", channel) if channel else (1.0, "signal unit")
    return style.axes(
        ax, x="frequency, Hz", y=f"one-sided density, ({unit})²/Hz", log=True, size=size
    ), factor**2


def _thin(f, psd, points=3000):
    """Every kind of frequency once on the logarithmic axis: 2^20 points would only blacken the
    figure.
    """
    keep = np.unique(np.geomspace(1, f.size, points).astype(int)) - 1
    return f[keep], psd[keep]


@style.styled
def spectrum(averaged, model=None, *, raw=None, channel="", ax=None):
    """An averaged spectrum with its 95 % interval; with a model, its closed form; with `raw`, that
    behind it.
    """
    ax, factor = _axes(ax, channel)
    if raw is not None:
        f, psd = _thin(raw.f, raw.psd)
        ax.plot(
            f, psd / factor, color=style.GREY, linewidth=0.4, alpha=0.7, label="before averaging"
        )
    style.band(ax, averaged.f, averaged.low / factor, averaged.high / factor, color=style.DATA)
    ax.plot(
        averaged.f, averaged.psd / factor, ".", color=style.DATA, label="averaged, 95 % interval"
    )
    if model is not None:
        model = model if isinstance(model, Sum) else Sum((model,))
        ax.plot(
            averaged.f,
            model.psd(averaged.f, averaged.fs) / factor,
            color=style.FIT,
            label="closed form",
        )
    ax.legend()
    return ax


@style.styled
def spectra(averaged, *, raw=None, axes=None):
    """Channels of one kind, channel -> averaged Spectrum; with `raw` (the same before averaging)
    in a panel of its own.
    """
    panels = [averaged] if raw is None else [raw, averaged]
    axes = np.ravel(
        style.grid(1, len(panels), size=(9.5 if raw else 7.0, 3.6), sharey=True)
        if axes is None
        else axes
    )
    for ax, panel in zip(axes, panels, strict=True):
        ax, factor = _axes(ax, next(iter(panel)))
        for channel, one in panel.items():
            colour = style.channel_colour(channel)
            f, psd = _thin(one.f, one.psd) if one.f.size > 5000 else (one.f, one.psd)
            ax.plot(
                f,
                psd / factor,
                color=colour,
                linewidth=0.5 if f is not one.f else 1.3,
                label=style.channel_label(channel),
            )
        ax.legend()
    return axes


@style.styled
def spectrum_lines(averaged, reading, *, channel="", ax=None):
    """An averaged spectrum with the lines that were read off it, thick where the stretch was
    found.
    """
    ax, factor = _axes(ax, channel)
    ax.plot(averaged.f, averaged.psd / factor, ".", color=style.DATA, label="record")
    bent = (
        averaged.fs / np.pi * np.sin(np.pi * averaged.f / averaged.fs)
    )  # of samples, a power of sin(pi f / fs)
    style.lines_read_off(ax, averaged.f, reading, channel, lambda line: line.at(bent) / factor)
    ax.set_ylim(averaged.psd.min() / factor / 4, averaged.psd.max() / factor * 4)
    ax.legend()
    return ax


@style.styled
def spectrum_terms(model, f, fs, *, ax=None):
    """The closed forms of a sum and of each of its terms: the textbook's picture of the slopes."""
    ax = style.axes(ax, x="frequency, Hz", y="one-sided density, unit²/Hz", log=True)
    for colour, term in zip(style.TERMS, model.terms, strict=False):
        ax.plot(f, term.psd(f, fs), "--", color=colour, label=NAMES.get(term.name, term.name))
    total = model.psd(f, fs)
    ax.plot(f, total, color=style.TRUTH, linewidth=2, label="sum")
    ax.set_ylim(total.min() / 4, total.max() * 2)
    ax.legend()
    return ax


@style.styled
def roll_off(averaged, models, *, channel="", ax=None):
    """The upper end of a spectrum over closed forms, label -> Sum: what a filter before the
    sampling does.
    """
    ax, factor = _axes(ax, channel)
    top = averaged.f > averaged.fs / 100
    style.band(
        ax,
        averaged.f[top],
        averaged.low[top] / factor,
        averaged.high[top] / factor,
        color=style.DATA,
    )
    ax.plot(averaged.f[top], averaged.psd[top] / factor, ".", color=style.DATA, label="record")
    f = np.linspace(averaged.fs / 100, averaged.fs / 2, 400)
    for colour, (label, model) in zip(
        (style.THEORY, style.PURPLE, style.GREEN), models.items(), strict=False
    ):
        ax.plot(
            f, np.maximum(model.psd(f, averaged.fs), 1e-300) / factor, color=colour, label=label
        )
    ax.set_ylim(averaged.psd[top].min() / factor / 8, averaged.psd[top].max() / factor * 2)
    ax.set_xscale("linear")
    ax.legend()
    return ax
