"""Figures of outages: maps, growth of the error, all outages over each other, errors by model."""

import numpy as np
from scipy.stats import chi2

from imu_lib import published
from imu_lib.navigation import earth

from . import style


def _colour(study, name):
    return style.CYCLE[list(study.models).index(name) % len(style.CYCLE)]


@style.styled
def outage_map(study, drive, *, model=None, first=1, mark="", ax=None):
    """The drive from above, its outages in colour and, dashed, where one model would have gone
    (2013 paper, Figs. 18, 20, 23); they are numbered from `first` on,
    with `mark` behind each number.
    """
    ax = style.axes(ax, x="east, m", y="north, m", size=(6.4, 5.6))
    model = model or next(iter(study.models))
    solution = study.models[model].solution
    ned = earth.meters(solution.position[::20], solution.position[0])
    ax.plot(ned[:, 1], ned[:, 0], color=style.GREY, lw=1.0, label="with GNSS")
    for i, (w, path) in enumerate(zip(study.windows, study.models[model].path)):
        inside = (solution.time >= w.start) & (solution.time <= w.start + w.duration)
        real = earth.meters(solution.position[inside], solution.position[0])
        free = earth.meters(path, solution.position[0])
        ax.plot(
            real[:, 1], real[:, 0], color=style.BLUE, lw=3.0, label="outages" if i == 0 else None
        )
        ax.plot(
            free[:, 1],
            free[:, 0],
            color=style.VERMILION,
            lw=1.2,
            ls="--",
            label=f"{model} without GNSS" if i == 0 else None,
        )
        if len(study.windows) <= 12:
            ax.annotate(
                f"{first + i}{mark}",
                (real[0, 1], real[0, 0]),
                textcoords="offset points",
                xytext=(8, 8),
                zorder=10,
                bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": style.BLUE, "lw": 0.6},
            )
    ax.set_aspect("equal", adjustable="datalim")
    ax.locator_params(axis="x", nbins=6)
    ax.legend()
    return ax


@style.styled
def outage_maps(studies, drives, *, model=None, mark="", axes=None):
    """`outage_map` of several drives side by side, their outages numbered on."""
    axes = style.grid(1, len(drives), size=(9.0, 4.2)) if axes is None else axes
    first = 1
    for study, drive, ax in zip(studies, drives, np.ravel(axes), strict=True):
        outage_map(study, drive, model=model, first=first, mark=mark, ax=ax)
        first += len(study.windows)
    return axes


@style.styled
def outage_tracks(study, index, *, names=None, ax=None):
    """One outage in the north-east plane: the way with GNSS and each model's way without (2013
    paper, Figs. 21a, 22a, 24a, 25a).
    """
    ax = style.axes(ax, x="east, m", y="north, m", size=(5.0, 4.4))
    w = study.windows[index]
    names = names or list(study.models)
    solution = study.models[names[0]].solution
    inside = (solution.time >= w.start) & (solution.time <= w.start + w.duration)
    origin = solution.position[inside][0]
    real = earth.meters(solution.position[inside], origin)
    ax.plot(real[:, 1], real[:, 0], color=style.BLACK, lw=2.5, label="with GNSS")
    for name in names:
        free = earth.meters(study.models[name].path[index], origin)
        ax.plot(free[:, 1], free[:, 0], color=_colour(study, name), label=name)
    ax.set_aspect("equal", adjustable="datalim")
    ax.legend()
    return ax


@style.styled
def outage_growth(study, index, *, names=None, against=None, sigma=True, ax=None):
    """Horizontal error of each model over one outage, with the filter's own standard deviation
    dotted (2013 paper, Figs. 21b to 25b).
    """
    against = against or ("reference" if "reference" in study.against else "full_gnss")
    ax = style.axes(ax, x="time since the last fix, s", y="horizontal error, m", size=(5.0, 4.0))
    for name in names or study.models:
        m = study.models[name]
        ax.plot(m.time[index], m.error[against][index], color=_colour(study, name), label=name)
        if sigma:
            ax.plot(m.time[index], m.sigma[index], color=_colour(study, name), ls=":", lw=0.9)
    ax.set_ylim(0.0, 1.15 * max(m.error[against][index].max() for m in study.models.values()))
    ax.legend()
    return ax


@style.styled
def outage_details(study, indices, *, against=None, axes=None):
    """A row for each outage: `outage_tracks` and `outage_growth` (2013 paper, Figs. 21, 22, 24,
    25).
    """
    axes = style.grid(len(indices), 2, size=(9.0, 3.5 * len(indices))) if axes is None else axes
    for row, index in zip(axes, indices, strict=True):
        outage_tracks(study, index, ax=row[0])
        outage_growth(study, index, against=against, ax=row[1])
    return axes


@style.styled
def outage_fan(study, *, name=None, against=None, ax=None):
    """All outages of one model laid over each other, with the radius that the filter expects to
    hold 95 % of them. Of fewer than 20 outages the largest error is drawn in the place of what
    95 % of them keep to.

    For a horizontal error of unequal and correlated components, the 95 % radius lies between 1.73
    (one round cloud) and 1.96 (a line) times the horizontal standard deviation; the round one is
    drawn.
    """
    name = name or next(iter(study.models))
    against = against or ("reference" if "reference" in study.against else "full_gnss")
    m = study.models[name]
    ax = style.axes(ax, x="time since the last fix, s", y="horizontal error, m")
    longest = max(m.time, key=len)
    count = len(m.time)
    few = count < 20  # of which one is more than 5 %
    for time, error in zip(m.time, m.error[against]):
        ax.plot(time, error, color=style.BLUE, lw=0.7, alpha=0.8 if few else 0.35)
    grid = np.linspace(0.0, longest[-1], 61)[1:]
    at = np.array(
        [
            [np.interp(g, t, e) if g <= t[-1] else np.nan for g in grid]
            for t, e in zip(m.time, m.error[against])
        ]
    )
    expected = np.array(
        [
            [np.interp(g, t, s) if g <= t[-1] else np.nan for g in grid]
            for t, s in zip(m.time, m.sigma)
        ]
    )
    ax.plot(
        grid,
        np.nanquantile(at, 1.0 if few else 0.95, axis=0),
        color=style.BLACK,
        lw=2.0,
        label=f"largest of {count} outages" if few else "95 % of the outages",
    )
    ax.plot(
        grid,
        np.nanmedian(expected, axis=0) * np.sqrt(chi2.ppf(0.95, 2) / 2.0),
        color=style.VERMILION,
        lw=2.0,
        label="95 % as the filter expects",
    )
    ax.plot([], [], color=style.BLUE, lw=0.7, label=f"{name}, {count} outages")
    ax.legend()
    return ax


@style.styled
def outage_errors(studies, *, what="max", against=None, published=None, ax=None):
    """Errors of all models side by side: bars for few outages (2013 paper, Fig. 26), boxes over
    many.

    studies : one OutageStudy, or several of the same models, whose outages are numbered on
    published : mapping of model to the paper's errors of the same outages, drawn as dashes
    """
    studies = list(studies) if isinstance(studies, (list, tuple)) else [studies]
    against = against or ("reference" if "reference" in studies[0].against else "full_gnss")
    label = f"{'maximum' if what == 'max' else 'mean'} horizontal error, m"
    names = list(studies[0].models)
    values = {
        n: np.concatenate([s.errors(n, what=what, against=against) for s in studies]) for n in names
    }
    count = len(values[names[0]])
    if count > 12:
        ax = style.axes(ax, y=label)
        ax.boxplot(
            [values[n] for n in names],
            tick_labels=names,
            whis=(5, 95),
            showfliers=False,
            medianprops={"color": style.VERMILION},
        )
        ax.set_yscale("log")
        return ax
    ax = style.axes(ax, x="outage", y=label)
    place, width = np.arange(count), 0.8 / len(names)
    for i, n in enumerate(names):
        at = place + (i - 0.5 * (len(names) - 1)) * width
        ax.bar(at, values[n], width, color=_colour(studies[0], n), label=n)
        if published and n in published:
            ax.plot(
                at,
                published[n],
                ls="none",
                marker="_",
                ms=6,
                mew=2,
                color=style.BLACK,
                label="paper" if i == 0 else None,
            )
    ax.set_xticks(place, [str(i + 1) for i in place])
    ax.set_yscale("log")
    ax.legend(ncols=3)
    return ax


@style.styled
def outage_errors_2013(studies, *, against="full_gnss", axes=None):
    """Maximum and mean errors of the two simulated drives, the paper's values over them (2013
    paper, Fig. 26).
    """
    axes = style.grid(2, 1, size=(8.0, 6.0)) if axes is None else axes
    for what, ax in zip(("max", "mean"), np.ravel(axes), strict=True):
        outage_errors(
            studies, what=what, against=against, published=published.outage_errors_2013(what), ax=ax
        )
    return axes


@style.styled
def outage_distributions(study, *, axes=None):
    """Errors of many draws by outage and model, and where the printed error lies among them.

    study : what `benchmarks/outages_paper.py` stored: "max" and "mean" by model, each with
    "quantiles" (outage, 5), "paper" and "rank" (share of draws below it); bars are the 95 % range
    with its median, dashes the printed value, red where it lies outside
    """
    axes = style.grid(2, 1, size=(8.0, 6.6), sharex=True).ravel() if axes is None else axes
    for ax, what in zip(axes, ("max", "mean"), strict=True):
        models = study[what]
        for k, (name, found) in enumerate(models.items()):
            q = np.array(found["quantiles"])
            at = np.arange(len(q)) + 1 + 0.15 * (k - (len(models) - 1) / 2)
            colour = style.CYCLE[k]
            ax.vlines(at, q[:, 0], q[:, -1], color=colour, lw=3.5, alpha=0.45, label=name)
            ax.plot(at, q[:, 2], "o", color=colour, ms=3.5)
            rank = np.array(found["rank"])
            for out, mark in ((False, style.BLACK), (True, "#cc0000")):
                here = ((rank < 0.025) | (rank > 0.975)) == out
                half = 0.06
                ax.hlines(
                    np.array(found["paper"])[here], at[here] - half, at[here] + half, mark, lw=2.2
                )
        ax.set(yscale="log", ylabel=f"{'maximum' if what == 'max' else 'mean'} horizontal error, m")
    axes[-1].set(xlabel="outage", xticks=range(1, len(q) + 1))
    axes[0].hlines([], [], [], style.BLACK, lw=2.2, label="printed")
    axes[0].set_ylim(top=3.0 * axes[0].get_ylim()[1])
    axes[0].legend(ncols=6, loc="upper left", fontsize=8)
    return axes
