"""Figures of the gap workflow: measurement against the band of simulations, before and after; the
gap by domain.
"""

import numpy as np

from imu_lib.ensembles.battery import edges
from imu_lib.plots import style

LABELS = {
    "psd": ("frequency, Hz", "PSD, dB"),
    "allan": ("averaging time, s", "Allan deviation, dB"),
}
NAMES = {
    "psd": "spectrum",
    "lines": "lines",
    "allan": "Allan deviation",
    "autocorrelation": "autocorrelation",
    "distribution": "distribution",
    "mean": "mean",
    "variance": "variance",
    "temperature": "temperature",
}


def _abscissa(domain, count, rate, n):
    if domain == "allan":
        return 3.0 ** np.arange(count) / rate
    edge = edges(n)
    return np.sqrt(edge[:-1] * edge[1:])[:count] * rate / n


@style.styled
def band(report, *, domain="psd", rate, n, ax=None):
    """Measurement in one domain over the 95 % bands of the simulations before and after, in dB
    from the middle of the band after.

    `report` is the channel's report of `gap.close`; `domain` is "psd" or "allan"; `n` samples at
    `rate` Hz.
    """
    x, y = LABELS[domain]
    ax = style.axes(ax, x=x, y=y + " from the final model", size=(6.4, 3.6))
    measured = np.asarray(report.batteries["measured"][domain])
    after = np.array([b[domain] for b in report.batteries["after"]])
    before = np.array([b[domain] for b in report.batteries["before"]])
    t = _abscissa(domain, len(measured), rate, n)
    scale = 10 / np.log(10) * (0.5 if domain == "allan" else 1.0)
    middle = np.median(after, axis=0)
    for rows, colour, label in (
        (before, style.BEFORE, "simulations before"),
        (after, style.AFTER, "simulations after"),
    ):
        low, high = np.quantile(rows, [0.025, 0.975], axis=0)
        ax.fill_between(
            t,
            scale * (low - middle),
            scale * (high - middle),
            color=colour,
            alpha=0.3,
            lw=0,
            label=label,
        )
        ax.plot(
            t, scale * (np.median(rows, axis=0) - middle), color=colour, lw=1.0
        )  # a band may be too narrow to be seen
    ax.plot(t, scale * (measured - middle), color=style.BLACK, marker=".", label="measurement")
    ax.set_xscale("log")
    ax.legend(loc="best")
    return ax


@style.styled
def domains(report, *, ax=None):
    """Gap index by domain before and after; 1 (the line) is a measurement like any simulation."""
    ax = style.axes(ax, x="gap index", size=(6.4, 3.0))
    names = list(report.before.domains)
    place = np.arange(len(names))
    ax.barh(
        place - 0.2,
        [report.before.domains[d] for d in names],
        0.38,
        color=style.BEFORE,
        label="before",
    )
    ax.barh(
        place + 0.2,
        [report.after.domains[d] for d in names],
        0.38,
        color=style.AFTER,
        label="after",
    )
    ax.axvline(1.0, color=style.BLACK, lw=0.8)
    ax.set_yticks(place, [NAMES[d] for d in names])
    ax.invert_yaxis()
    if max(report.before.domains.values()) > 30:
        ax.set_xscale("log")
    ax.legend(loc="lower right")
    return ax


@style.styled
def score(table, *, ax=None):
    """Share of detectable cases named right with its 95 % interval, one line for each effect of a
    score table.
    """
    rows = [r for r in table if r["detectable"]]
    ax = style.axes(
        ax, x="share of detectable cases named right", size=(6.4, 0.24 * len(rows) + 0.8)
    )
    share = np.array([r["named"] / r["detectable"] for r in rows])
    interval = np.array([r["named_interval"] for r in rows])
    place = np.arange(len(rows))
    ax.errorbar(
        share,
        place,
        xerr=_bars(share, interval),
        fmt="o",
        color=style.BLUE,
        capsize=2,
    )
    ax.axvline(0.95, color=style.GREY, lw=0.8, ls="--")
    ax.set_yticks(place, [f"{r['kind']} ({r['detectable']})" for r in rows])
    ax.set_xlim(0, 1.03)
    ax.invert_yaxis()
    return ax


def _bars(value, interval):
    """Lengths of the bars (2, n) from values (n,) to the ends of their intervals (n, 2)."""
    return np.maximum([value - interval[:, 0], interval[:, 1] - value], 0)


@style.styled
def reliability(table, *, ax=None):
    """Share of right names over the confidence with which they were told, with 95 % intervals, one
    point for each bin of a table of `benchmarks/gap_reliability.py`.
    """
    ax = style.axes(ax, x="confidence", y="share of right names", size=(4.8, 4.2))
    said, right = (np.array([r[k] for r in table]) for k in ("confidence", "right"))
    interval = np.array([r["interval"] for r in table])
    ax.plot([0, 1], [0, 1], color=style.GREY, lw=0.8, ls="--")
    ax.errorbar(
        said,
        right,
        yerr=_bars(right, interval),
        fmt="o",
        color=style.BLUE,
        capsize=2,
    )
    ax.set_xlim(-0.02, 1.02)
    ax.set_ylim(-0.02, 1.02)
    return ax
