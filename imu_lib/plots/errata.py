"""Figures of the chapter on printed numbers that do not hold."""

import numpy as np

from imu_lib.plots import style


@style.styled
def unstable_response(poles_by_channel, *, seconds=3.0, fs=100.0, ax=None):
    """Largest pole of each printed AR model, as the factor by which its response grows or decays
    in time.

    poles_by_channel: dict of channel name to complex ndarray, shape (p,).
    """
    ax = style.axes(ax, x="time, s", y="|largest pole| ^ (time x rate)")
    t = np.arange(0, seconds, 1 / fs)
    for channel, poles in poles_by_channel.items():
        largest = np.max(np.abs(poles))
        ax.plot(
            t,
            largest ** (t * fs),
            color=style.channel_colour(channel),
            linestyle="-" if channel.startswith("accel") else "--",
            label=f"{style.channel_label(channel)}: {largest:.3f}",
        )
    ax.set_yscale("log")
    ax.axhline(1.0, color=style.GREY, linewidth=0.8)
    ax.legend()
    return ax


@style.styled
def outage_ratios(outages, *, model="18AVWD", than="15AR", ax=None):
    """Ratio of the maximum errors of two models by outage, with the mean of ratios and the ratio
    of sums.

    outages: sequence with `number` and `max_m`, as `published.OUTAGES_2013`.
    """
    better = np.array([o.max_m[model] for o in outages])
    worse = np.array([o.max_m[than] for o in outages])
    ax = style.axes(ax, x="outage", y=f"maximum error of {model} over {than}")
    ax.bar([o.number for o in outages], better / worse, color=style.SKY, width=0.6)
    ax.axhline(np.mean(better / worse), color=style.BLUE, label="mean of the ratios")
    ax.axhline(
        better.sum() / worse.sum(), color=style.VERMILION, linestyle="--", label="ratio of the sums"
    )
    ax.axhline(1.0, color=style.GREY, linewidth=0.8)
    ax.legend(loc="upper right", bbox_to_anchor=(1.0, 0.97))  # below the line at 1
    return ax
