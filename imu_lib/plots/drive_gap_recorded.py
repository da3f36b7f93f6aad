"""Figures of recorded drives, from what `benchmarks/drive_gap_real.py` stores of them."""

import numpy as np

from imu_lib.plots import style

PROMISED = 15.0  # nats from which on a name is to be expected
LEAST = 0.1  # m: an outage error below that of the reference itself is drawn there


@style.styled
def drive_gap_outages(drives, *, ax=None):
    """Median of the largest errors of withheld outages, before and after the search, by drive; thin
    lines are single outages, where they are stored.

    drives : {name: what is stored of it}
    """
    ax = style.axes(ax, y="largest error of an outage, m", size=(8.0, 4.2))
    shown = {n: d for n, d in drives.items() if d["outages"]}
    for k, d in enumerate(shown.values()):
        errors = d.get("errors") or {"before": [], "after": []}
        for row in zip(errors["before"], errors["after"]):
            ax.plot([k - 0.2, k + 0.2], np.maximum(row, LEAST), color=style.GREY, lw=0.7, alpha=0.7)
        medians = d["outages"]["median_max_error"]
        both = medians["before"], medians["after"]
        ax.plot([k - 0.2, k + 0.2], both, color="black", lw=1.5)
        for place, value, colour, label, above in zip(
            (k - 0.2, k + 0.2), both, (style.BEFORE, style.AFTER), ("before", "after"), (8, -16)
        ):
            ax.plot(place, value, "o", color=colour, ms=9, label=label if k == 0 else None)
            ax.annotate(f"{value:.3g}", (place, value), (0, above), textcoords="offset points",
                        ha="center", fontsize=8)  # fmt: skip
    ax.set_yscale("log")
    ax.set_xlim(-0.6, len(shown) - 0.4)
    ax.set_xticks(range(len(shown)), [f"{n} ({d['outages']['windows']})" for n, d in shown.items()])
    ax.legend()
    return ax


def promised(hidden):
    """Nats that the drive's own information promises for what was hidden in it."""
    if hidden["expected"] is not None:
        return hidden["expected"]
    return 0.0 if hidden["sd"] is None else 0.5 * (hidden["put in"] / hidden["sd"]) ** 2


@style.styled
def drive_gap_hidden(drives, *, ax=None):
    """What is found of effects hidden in recorded drives, over what was put in, with 95 %
    intervals; filled where the drive's own information promises that it can be named.

    drives : {name: what is stored of it}
    """
    rows = [(n, h) for n, d in drives.items() for h in d.get("hidden", ())]
    kinds = list(dict.fromkeys((h["effect"], h["component"]) for _, h in rows))
    names = list(dict.fromkeys(n for n, _ in rows))
    ax = style.axes(ax, x="found, over what was put in", size=(8.0, 0.55 * len(kinds) + 1.2))
    seen: dict = {}
    for n, h in rows:
        k, place = kinds.index((h["effect"], h["component"])), names.index(n)
        seen[k, place] = seen.get((k, place), -1) + 1  # of two sizes one stands below the other
        y = k + 0.6 * (place / max(len(names) - 1, 1) - 0.5) + 0.1 * seen[k, place]
        half = 0.0 if h["sd"] is None else 1.96 * h["sd"] / abs(h["put in"])
        colour = style.CYCLE[place % len(style.CYCLE)]
        ax.errorbar(
            np.clip(h["found"] / h["put in"], -1.0, 3.0), y, xerr=min(half, 4.0), fmt="o", ms=5,
            color=colour, mfc=colour if promised(h) >= PROMISED else "white", lw=1.0,
        )  # fmt: skip
    for place, n in enumerate(names):
        ax.plot([], [], "o", color=style.CYCLE[place % len(style.CYCLE)], label=n)
    ax.axvline(1.0, ls="--", lw=0.8, color="black")
    ax.set_xlim(-1.0, 3.0)
    ax.set_yticks(range(len(kinds)), [f"{e}, {c}" for e, c in kinds])
    ax.invert_yaxis()
    ax.legend(fontsize=7, loc="upper right")
    return ax
