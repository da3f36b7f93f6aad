"""Figures of recorded drives, from what `benchmarks/drive_gap_real.py` stores of them."""

import numpy as np

from imu_lib.plots import style

LEAST = 0.1  # m: an outage error below that of the reference itself is drawn there


@style.styled
def drive_gap_windows(drives, *, ax=None):
    """Largest error of each withheld outage, before and after the search, by drive; the bars are
    the medians.

    drives : {name: what is stored of it}
    """
    ax = style.axes(ax, y="largest error of an outage, m", size=(8.0, 4.2))
    names = [n for n, d in drives.items() if d.get("errors", {}).get("before")]
    for k, name in enumerate(names):
        errors = drives[name]["errors"]
        before, after = (np.maximum(errors[n], LEAST) for n in ("before", "after"))
        for row in zip(before, after):
            ax.plot([k - 0.2, k + 0.2], row, color=style.GREY, lw=0.7, alpha=0.7)
        for values, place, colour, label in (
            (before, k - 0.2, style.BEFORE, "before"),
            (after, k + 0.2, style.AFTER, "after"),
        ):
            at = np.full(values.size, place)
            ax.plot(at, values, "o", color=colour, ms=4, label=label if k == 0 else None)
            middle = float(np.median(values))
            ax.plot([place - 0.13, place + 0.13], [middle, middle], color=colour, lw=3)
    ax.set_yscale("log")
    ax.set_xticks(range(len(names)), names)
    ax.legend()
    return ax


@style.styled
def drive_gap_along(drives, *, axes=None):
    """Size of the whitened innovations along each drive, before and after the search; 1 is that of
    a right filter.

    drives : {name: what is stored of it}
    """
    shown = {n: d["along"] for n, d in drives.items() if d.get("along")}
    rows = -(-len(shown) // 2)
    if axes is None:
        axes = style.grid(rows, 2, size=(9.0, 2.2 * rows))
    flat = np.ravel(axes)
    for ax, (name, along) in zip(flat, shown.items()):
        for key, colour in (("before", style.BEFORE), ("after", style.AFTER)):
            size = np.array(along[key], float)
            ax.plot(along["time"], size, color=colour, label=key)
        ax.axhline(1.0, ls="--", lw=0.8, color="black")
        ax.set_yscale("log")
        ax.set_title(name, fontsize=9)
        ax.set_xlabel("time, s")
        ax.set_ylabel("size, standard deviations")
    for ax in flat[len(shown) :]:
        ax.set_visible(False)
    flat[0].legend(fontsize=7)
    return axes


@style.styled
def drive_gap_hidden(drives, *, ax=None):
    """What is found of effects hidden in recorded drives, over what was put in, with 95 %
    intervals; filled where the drive's own information promises that it can be named.

    drives : {name: what is stored of it}
    """
    rows = [(n, h) for n, d in drives.items() for h in d.get("hidden", ())]
    kinds = list(dict.fromkeys((h["effect"], h["component"], h["value"]) for _, h in rows))
    names = list(dict.fromkeys(n for n, _ in rows))
    ax = style.axes(ax, x="found, over what was put in", size=(8.0, 0.55 * len(kinds) + 1.2))
    for n, h in rows:
        k, place = kinds.index((h["effect"], h["component"], h["value"])), names.index(n)
        y = k + 0.7 * (place / max(len(names) - 1, 1) - 0.5)
        half = 0.0 if h["sd"] is None else 1.96 * h["sd"] / abs(h["put in"])
        colour = style.CYCLE[place % len(style.CYCLE)]
        ax.errorbar(
            np.clip(h["found"] / h["put in"], -1.0, 3.0), y, xerr=min(half, 4.0), fmt="o", ms=5,
            color=colour, mfc=colour if h["excited"] else "white", lw=1.0,
        )  # fmt: skip
    for place, n in enumerate(names):
        ax.plot([], [], "o", color=style.CYCLE[place % len(style.CYCLE)], label=n)
    ax.axvline(1.0, ls="--", lw=0.8, color="black")
    ax.set_xlim(-1.0, 3.0)
    labels = [f"{e} {c}".removesuffix(f" {e}") + f" {v:.3g}" for e, c, v in kinds]
    ax.set_yticks(range(len(kinds)), labels)
    ax.invert_yaxis()
    ax.legend(fontsize=7, loc="upper right")
    return ax
