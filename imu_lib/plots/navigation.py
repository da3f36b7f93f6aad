"""Figures of drives, filters and outages."""

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from scipy.stats import chi2

from imu_lib import published
from imu_lib.navigation import consistency, earth

from . import style


def _colour(study, name):
    return style.CYCLE[list(study.models).index(name) % len(style.CYCLE)]


@style.styled
def outage_map(study, drive, *, model=None, first=1, ax=None):
    """The drive from above, its outages in colour and, dashed, where one model would have gone
    (2013 paper, Figs. 18, 20, 23); they are numbered from `first` on.
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
                str(first + i),
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
def outage_maps(studies, drives, *, model=None, axes=None):
    """`outage_map` of several drives side by side, their outages numbered on."""
    axes = style.grid(1, len(drives), size=(9.0, 4.2)) if axes is None else axes
    first = 1
    for study, drive, ax in zip(studies, drives, np.ravel(axes), strict=True):
        outage_map(study, drive, model=model, first=first, ax=ax)
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
    hold 95 % of them.

    For a horizontal error of unequal and correlated components, the 95 % radius lies between 1.73
    (one round cloud) and 1.96 (a line) times
    the horizontal standard deviation; the round one is drawn.
    """
    name = name or next(iter(study.models))
    against = against or ("reference" if "reference" in study.against else "full_gnss")
    m = study.models[name]
    ax = style.axes(ax, x="time since the last fix, s", y="horizontal error, m")
    longest = max(m.time, key=len)
    for time, error in zip(m.time, m.error[against]):
        ax.plot(time, error, color=style.BLUE, lw=0.7, alpha=0.35)
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
        np.nanquantile(at, 0.95, axis=0),
        color=style.BLACK,
        lw=2.0,
        label="95 % of the outages",
    )
    ax.plot(
        grid,
        np.nanmedian(expected, axis=0) * np.sqrt(chi2.ppf(0.95, 2) / 2.0),
        color=style.VERMILION,
        lw=2.0,
        label="95 % as the filter expects",
    )
    ax.plot([], [], color=style.BLUE, lw=0.7, label=f"{name}, {len(m.time)} outages")
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
def solution_errors(solution, drive, *, ax=None):
    """Errors of a solution against the truth of a simulated drive, with the filter's two-sigma
    bands: position, velocity, attitude.
    """
    time, error, p = consistency.errors(solution, drive)
    sd = np.sqrt(np.diagonal(p, axis1=1, axis2=2))
    axes = style.grid(3, 3, size=(9.0, 6.0), sharex=True)
    for k, (unit, scale) in enumerate((("m", 1.0), ("m/s", 1.0), ("deg", 180.0 / np.pi))):
        for j in range(3):
            a, i = axes[k, j], 3 * k + j
            style.band(a, time, -2.0 * scale * sd[:, i], 2.0 * scale * sd[:, i])
            a.plot(time, scale * error[:, i], lw=0.8)
            top = scale * max(
                6.0 * float(np.median(sd[:, i])),
                1.1 * float(np.quantile(np.abs(error[:, i]), 0.99)),
            )
            a.set_ylim(-top, top)  # the first seconds' bands would dwarf the rest
            a.set_title(
                f"{('position', 'velocity', 'attitude')[k]} {('north', 'east', 'down')[j]}, {unit}"
            )
    for a in axes[2]:
        a.set_xlabel("time, s")
    return axes[0, 0]


@style.styled
def nees_over_time(time, values, *, freedom=9, ax=None):
    """Mean NEES over runs with the 99.7 % band in which it lies where the filter is honest.

    time : (k,) s; values : ndarray, shape (runs, k)
    """
    ax = style.axes(ax, x="time, s", y=f"mean NEES of {len(values)} drives")
    band = consistency.band(values[:, 0], freedom)
    style.band(
        ax, time, np.full(len(time), band.low), np.full(len(time), band.high), label="99.7 % band"
    )
    ax.plot(time, np.mean(values, axis=0))
    ax.axhline(freedom, color=style.BLACK, lw=0.8)
    ax.legend()
    return ax


@style.styled
def free_inertial(error_time, errors, *, labels, ax=None):
    """Horizontal error of free inertial runs on a log-log scale: errors, sequence of (k,) m."""
    ax = style.axes(ax, x="time, s", y="horizontal error, m", log=True)
    for e, label in zip(errors, labels):
        ax.plot(error_time, e, label=label)
    ax.legend()
    return ax


@style.styled
def paired_intervals(rows, *, ax=None):
    """Ratios of errors with their 95 % intervals, one per line; left of 1 the first model is
    better.

    rows : sequence of `statistics.Paired`
    """
    ax = style.axes(
        ax,
        x="ratio of maximum errors (geometric mean, 95 % interval)",
        size=(7.0, 0.4 * len(rows) + 1.2),
    )
    for i, pair in enumerate(rows):
        colour = style.BLUE if pair.decided else style.GREY
        ax.plot([pair.low, pair.high], [i, i], color=colour, lw=2.0)
        ax.plot(pair.ratio, i, "o", color=colour)
    ax.axvline(1.0, color=style.BLACK, lw=0.8)
    ax.set_yticks(range(len(rows)), [f"{pair.better} over {pair.than}" for pair in rows])
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.invert_yaxis()
    return ax
