"""Figures of the gap workflow on a drive: the way, the innovations before and after."""

import numpy as np

from imu_lib.gap.drive.battery import in_track
from imu_lib.navigation import earth
from imu_lib.plots import style


@style.styled
def drive_gap_map(report, *, ax=None):
    """The way driven from above, coloured by the size of the innovations that are left; the
    withheld windows are dark.
    """
    ax = style.axes(ax, x="east, m", y="north, m", size=(6.0, 5.0))
    state = report.state
    path = state.problem.path
    ned = earth.meters(path["position"], path["position"][0])
    count = state.use.sum(axis=1)
    total = np.nansum(np.where(state.use, state.result.e, 0.0) ** 2, axis=1)
    time = state.problem.time
    good = count > 0
    size = total / np.maximum(count, 1)
    value = np.sqrt(np.interp(path["time"], time[good], size[good]))
    points = ax.scatter(ned[:, 1], ned[:, 0], c=np.clip(value, 0.0, 4.0), s=5, cmap="viridis")
    ax.figure.colorbar(points, ax=ax, label="size of the innovations left, standard deviations")
    for start, duration in state.withhold:
        inside = (path["time"] > start) & (path["time"] <= start + duration)
        ax.plot(ned[inside, 1], ned[inside, 0], color="black", lw=1.0)
    ax.set_aspect("equal", adjustable="datalim")
    return ax


@style.styled
def drive_gap_innovations(report, *, axes=None):
    """Whitened innovations in track, across and down, before and after; a right filter keeps 95 %
    of them within the dashed lines.
    """
    both = (
        (report.first.problem, report.first.result.e, style.BEFORE, "before"),
        (report.state.problem, report.state.result.e, style.AFTER, "after"),
    )
    rows = [0, 1] if np.isfinite(report.state.result.e[:, 3:]).any() else [0]
    axes = style.grid(len(rows), 3, size=(9.0, 2.6 * len(rows))) if axes is None else axes
    axes = np.reshape(axes, (len(rows), 3))
    for row in rows:
        for k, way in enumerate(("along", "across", "down")):
            ax = axes[row, k]
            for problem, e, colour, label in both:
                track = in_track(problem, e)[:, 3 * row + k]
                ax.plot(
                    problem.time, np.clip(track, -12, 12), ".", ms=1.5, color=colour, label=label
                )
            for level in (-1.96, 1.96):
                ax.axhline(level, ls="--", lw=0.7, color="black")
            ax.set_title(f"{('position', 'velocity')[row]}, {way}", fontsize=9)
            ax.set_xlabel("time, s")
            if k == 0:
                ax.set_ylabel("standard deviations")
    axes[0, 0].legend(fontsize=7, markerscale=5)
    return axes
