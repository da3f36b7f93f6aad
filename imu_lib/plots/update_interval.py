"""Figures of the update-interval study (2008 paper, Figs. 14 to 19 and Table 4)."""

from __future__ import annotations

import numpy as np

from imu_lib.plots import style


@style.styled
def planar_tracks(drive, found, interval, *, fixes=None, around=None, ax=None):
    """True track and the first run's estimated tracks with a fix every `interval` s; `found`
    {model: Errors} (Figs. 14, 15), and `fixes` (n, 2) of that run alone; `around` (time s, metres)
    shows no more than those metres about where the drive is at that time.
    """
    ax = style.axes(ax, x="east, m", y="north, m", title=f"a fix every {interval} s")
    ax.plot(
        drive.position[:, 1],
        drive.position[:, 0],
        color=style.TRUTH,
        lw=2.5,
        alpha=0.3,
        label="truth",
    )
    for k, ((name, errors), color) in enumerate(zip(found.items(), style.CYCLE)):
        track = drive.position + errors.track
        ax.plot(track[:, 1], track[:, 0], color=color, lw=1.6 - 0.7 * k, label=name)
    if fixes is not None:
        every = round(interval * drive.fs)
        at = slice(every - 1, None, every)
        ax.plot(fixes[at, 1], fixes[at, 0], ".", color=style.BLACK, ms=2, label="fixes alone")
    if around is None:
        ax.set_aspect("equal", adjustable="datalim")
    else:
        north, east = drive.position[np.searchsorted(drive.time, around[0])]
        ax.set(
            aspect="equal",
            xlim=(east - around[1], east + around[1]),
            ylim=(north - around[1], north + around[1]),
        )
    ax.legend()
    return ax


@style.styled
def planar_errors(drive, study, names, *, fixes=None, intervals=(1, 5, 10, 20), size=(9.0, 8.0)):
    """Horizontal error of the first run over time by model, a panel an interval (Figs. 16 to 19).

    names : the models drawn, the first below the next; fixes : (n, 2) of the same run, whose own
    errors are drawn at the fixes that are used
    """
    panels = style.grid(2, (len(intervals) + 1) // 2, size=size, sharex=True).ravel()
    for ax, interval in zip(panels, intervals):
        for k, (name, color) in enumerate(zip(names, style.CYCLE)):
            track = study[interval][name].track
            ax.plot(drive.time, np.hypot(*track.T), color=color, lw=2.4 - 1.5 * k, label=name)
        if fixes is not None:
            every = round(interval * drive.fs)
            at = slice(every - 1, None, every)
            off = np.hypot(*(fixes - drive.position)[at].T)
            ax.plot(drive.time[at], off, ".", color=style.BLACK, ms=3, label="fixes alone")
        ax.set(title=f"a fix every {interval} s", ylabel="horizontal error, m")
    for ax in panels[-2:]:
        ax.set_xlabel("time, s")
    panels[0].legend()
    return panels[0]


@style.styled
def rms_by_interval(study, published=(), *, ax=None):
    """Horizontal RMS error against the interval between fixes, pooled over the runs, with the
    paper's two rows.
    """
    ax = style.axes(ax, x="interval between fixes, s", y="horizontal RMS error, m", log=True)
    intervals = list(study)
    for k, (name, color) in enumerate(zip(next(iter(study.values())), style.CYCLE)):
        rms = [study[t][name].pooled[2] for t in intervals]
        ax.plot(
            intervals, rms, "o-", color=color, lw=3.0 - 0.5 * k, ms=7 - k, label=name
        )  # equal curves stay visible
    if published:
        for rows, mark, label in (
            ("ar4_m", "^", "2008 paper, AR(4)"),
            ("gm1_m", "v", "2008 paper, GM(1)"),
        ):
            ax.plot(
                [r.interval_s for r in published],
                [getattr(r, rows)[2] for r in published],
                mark,
                color=style.BLACK,
                mfc="none",
                ms=8,
                label=label,
            )
    ax.legend(fontsize="x-small")
    return ax


@style.styled
def paired_ratios(ratios, *, ax=None):
    """Ratios of errors with 95 % intervals against the interval between fixes; `ratios` {label:
    {interval: Estimate}}.
    """
    ax = style.axes(ax, x="interval between fixes, s", y="error of one over the other")
    for k, ((label, rows), color) in enumerate(zip(ratios.items(), style.CYCLE)):
        x = np.array(list(rows), float) * 1.05 ** (k - (len(ratios) - 1) / 2)
        v = np.array([[e.value, e.value - e.low, e.high - e.value] for e in rows.values()]).T
        ax.errorbar(x, v[0], yerr=v[1:], fmt="o", color=color, capsize=3, label=label)
    ax.axhline(1.0, color=style.TRUTH, lw=0.8)
    ax.set_xscale("log")
    ax.set_xticks(list(next(iter(ratios.values()))), [str(t) for t in next(iter(ratios.values()))])
    ax.minorticks_off()
    ax.legend()
    return ax
