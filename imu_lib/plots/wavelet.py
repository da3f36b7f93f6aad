"""Figures of wavelet de-noising: bands, thresholds, what a level does, and the edge."""

import numpy as np

from imu_lib.plots import style


@style.styled
def wavelet_bands(f, gains, bands, *, ax=None):
    """Gain of each band's reconstruction (rows of `gains` at `f`, Hz) over its nominal limits."""
    ax = style.axes(ax, x="frequency, Hz", y="gain")
    for k, (row, band) in enumerate(zip(gains, bands, strict=True)):
        colour = style.CYCLE[k % len(style.CYCLE)]
        ax.plot(f, row, color=colour, label=f"{band.name}: {band.low:.4g} to {band.high:.4g} Hz")
        ax.axvspan(max(band.low, f[0]), band.high, color=colour, alpha=0.08, linewidth=0)
    ax.set_xscale("log")
    ax.set_xlim(f[0], f[-1])
    ax.legend(loc="center left")
    return ax


@style.styled
def thresholds(summaries, *, ax=None):
    """Share of each level's energy that is left after shrinking; `summaries` is label ->
    Thresholds.
    """
    ax = style.axes(ax, x="level", y="share of the energy left")
    for (label, s), marker in zip(summaries.items(), ("o", "s", "v", "D", "x"), strict=False):
        ax.plot(
            np.arange(1, s.energy_kept.size + 1),
            np.maximum(s.energy_kept, 1e-7),
            marker=marker,
            label=style.channel_label(label),
        )
    ax.set_yscale("log")
    ax.legend()
    return ax


@style.styled
def denoised_allan(curves, *, marks=(), ax=None):
    """Allan deviation before and after; `curves` is label -> AllanCurve, the first with its
    interval, `marks` times in s.
    """
    ax = style.axes(ax, x="averaging time, s", y="Allan deviation", log=True)
    for k, (label, c) in enumerate(curves.items()):
        colour = style.CYCLE[k % len(style.CYCLE)]
        ax.plot(c.tau, c.adev, color=colour, label=label)
        if k == 0:
            style.band(ax, c.tau, c.low, c.high, color=colour)
    for t in marks:
        ax.axvline(t, color=style.BLACK, linestyle=":", linewidth=1.0)
    low = next(iter(curves.values())).adev.min()
    ax.set_ylim(bottom=low / 30)
    ax.legend()
    return ax


@style.styled
def denoised_series(t, curves, *, y="", ax=None):
    """Signals over time, `curves` is label -> array; the first is drawn thin and grey."""
    ax = style.axes(ax, x="time, s", y=y)
    for k, (label, values) in enumerate(curves.items()):
        options = (
            {"color": style.BAND, "linewidth": 0.5} if k == 0 else {"color": style.CYCLE[k - 1]}
        )
        ax.plot(t, values, label=label, **options)
    ax.legend()
    return ax


@style.styled
def edge_error(distance, errors, *, reference=None, ax=None):
    """RMS error against the distance from the end of the record, s; `errors` is label -> array."""
    ax = style.axes(
        ax,
        x="distance from the end of the record, s",
        y="RMS error, standard deviations of the noise",
    )
    for label, values in errors.items():
        ax.plot(distance, values, label=label)
    if reference is not None:
        ax.axvline(
            reference,
            color=style.BLACK,
            linestyle=":",
            label=f"memory of the transform, {reference:.3g} s",
        )
    ax.legend()
    return ax


@style.styled
def coefficient_comparison(table, *, ax=None):
    """AR(3) coefficients of several sources, label -> (alpha_1, alpha_2, alpha_3), side by side."""
    ax = style.axes(ax, y="coefficient, the paper's sign", size=(7.0, 3.6))
    width = 0.8 / len(table)
    for k, (label, alpha) in enumerate(table.items()):
        ax.bar(
            np.arange(3) + (k - (len(table) - 1) / 2) * width,
            alpha,
            width,
            label=label,
            color=style.CYCLE[k % len(style.CYCLE)],
        )
    ax.set_xticks(range(3), ["first", "second", "third"])
    ax.axhline(0, color=style.BLACK, linewidth=0.6)
    ax.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, 1.32))
    return ax
