"""Figures on the wavelet level that a moving vehicle can afford (2013 paper, Section 5.6)."""

from __future__ import annotations

import numpy as np

from imu_lib.plots import style


@style.styled
def level_curves(studies, *, units=None, size=(9.0, 3.8)):
    """RMS error against the level, one panel a channel; `studies` {channel: LevelStudy}, `units`
    {channel: (factor, name)}.
    """
    panels = style.grid(1, len(studies), size=size)[0]
    for ax, (channel, study) in zip(panels, studies.items()):
        factor, unit = (units or {}).get(channel, (1.0, "signal unit"))
        levels = np.arange(len(study.loss))
        for (name, rms), color in zip(study.rms.items(), style.CYCLE):
            ax.semilogy(
                levels, rms / factor, "o-" if "whole" in name else "s--", color=color, label=name
            )
        ax.semilogy(
            levels[1:],
            study.loss[1:] / factor,
            ":",
            color=style.BLACK,
            label="motion lost by the low-pass",
        )
        ax.semilogy(
            levels, study.noise / factor, "-.", color=style.GREY, label="noise left by the low-pass"
        )
        least = min(rms.min() for rms in study.rms.values()) / factor
        ax.set(
            title=style.channel_label(channel),
            xlabel="levels",
            ylabel=f"RMS error, {unit}",
            ylim=(least / 4, None),
        )
    panels[0].legend(fontsize="x-small")
    return panels[0]


@style.styled
def band_energy(choices, *, fs=100.0, units=None, size=(9.0, 3.6)):
    """Motion and noise in each detail band, one panel a channel; `choices` {channel: {label:
    LevelChoice}}.
    """
    panels = style.grid(1, len(choices), size=size)[0]
    for ax, (channel, rows) in zip(panels, choices.items()):
        factor, unit = (units or {}).get(channel, (1.0, "signal unit"))
        for (label, choice), color in zip(rows.items(), style.CYCLE):
            levels = np.arange(1, len(choice.noise_variance) + 1)
            middle = fs / 2**levels / np.sqrt(2)
            motion = np.where(
                choice.p_value < 0.001, choice.motion_variance, np.nan
            )  # what noise alone may do is not drawn
            ax.loglog(middle, np.sqrt(motion) / factor, "o-", color=color, label=f"{label}: motion")
            ax.loglog(
                middle,
                np.sqrt(choice.noise_variance) / factor,
                "x--",
                color=color,
                label=f"{label}: at rest",
            )
        ax.set(
            title=style.channel_label(channel),
            xlabel="middle of the band, Hz",
            ylabel=f"standard deviation, {unit}",
        )
    panels[0].legend(fontsize="x-small")
    return panels[0]


@style.styled
def denoised_detail(time, curves, *, unit="", ax=None):
    """A stretch of one signal, or of its error, in several forms; `curves` {label: (n,)}, the
    first in grey, the last in black.
    """
    ax = style.axes(ax, x="time, s", y=unit)
    names = list(curves)
    for k, name in enumerate(names):
        color = "#BBBBBB" if k == 0 else style.TRUTH if k == len(names) - 1 else style.CYCLE[k - 1]
        ax.plot(time, curves[name], color=color, lw=0.7 if k == 0 else 1.3, label=name)
    ax.legend()
    return ax
