"""Is the reference of a drive fit to be scored against? Where it jumps, has holes or does not
reach, it is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from imu_lib.drive import Drive

from . import earth

LEAST = 2.0  # m: a smaller step is no jump
HARDEST = 8.0  # m/s^2: no car changes its velocity faster
HOLE = 2.0  # s without a reference: straight lines over it are off by a metre or two


@dataclass(frozen=True)
class Reference:
    """What is wrong with a reference: spans (k, 2) s in which it is not scored against; notes."""

    spans: np.ndarray
    notes: tuple

    def good(self, start, stop):
        """Whether nothing is wrong between two times."""
        return not ((self.spans[:, 0] <= stop) & (self.spans[:, 1] >= start)).any()


def look(drive: Drive) -> Reference | None:
    """What is wrong with the reference of a drive; None without one."""
    if not drive.has_reference:
        return None
    time, position = np.asarray(drive.reference_time), np.asarray(drive.reference_position)
    shown = np.isfinite(position).all(axis=1)
    time, position = time[shown], position[shown]
    velocity = drive.reference_velocity
    velocity = None if velocity is None else np.asarray(velocity)[shown]
    step = np.diff(time)
    hole = step > max(HOLE, 2.5 * float(np.median(step)))
    size = _jumps(time, position, velocity)
    jump = (size > np.maximum(LEAST, HARDEST * step**2)) & ~hole
    spans = [(-np.inf, time[0]), (time[-1], np.inf)]
    spans += [(time[i], time[i + 1]) for i in np.flatnonzero(hole | jump)]
    notes = []
    if jump.any():
        first = int(np.flatnonzero(jump)[0])
        notes.append(
            f"The reference jumps {int(jump.sum())} times by up to {size[jump].max():.0f} m, first "
            f"at {time[first]:.1f} s: outages there are not scored against it."
        )
        spans += _displaced(drive, time, position, np.flatnonzero(jump | hole), size[jump].max())
    if hole.any():
        notes.append(
            f"The reference has {int(hole.sum())} holes of up to {step[hole].max():.1f} s: "
            "outages over them are not scored against it."
        )
    return Reference(np.array(spans), tuple(notes))


def _jumps(time, position, velocity):
    """How far each step of the reference is from what its velocity, or the steps beside it, say,
    horizontally, m.
    """
    moved, step = earth.meters(position[1:], position[:-1])[:, :2], np.diff(time)[:, None]
    if velocity is not None and np.isfinite(velocity).all():
        said = 0.5 * (velocity[1:, :2] + velocity[:-1, :2])
    else:
        v = np.pad(moved / step, ((2, 2), (0, 0)), mode="edge")
        around = np.stack([v[k : k + len(moved)] for k in (0, 1, 3, 4)])
        said = np.median(around, axis=0)
    return np.linalg.norm(moved - said * step, axis=1)


def _displaced(drive, time, position, breaks, largest):
    """Spans between breaks in which the reference lies further from the fixes than elsewhere, by
    half the largest jump or more.
    """
    fixes = np.asarray(drive.gnss_time)
    here = np.column_stack([np.interp(fixes, time, c) for c in position.T])
    apart = earth.horizontal(np.asarray(drive.gnss_position), here)
    edges = np.concatenate([[time[0]], 0.5 * (time[breaks] + time[breaks + 1]), [time[-1]]])
    spans, distance = [], []
    for low, high in zip(edges[:-1], edges[1:]):
        inside = (fixes >= low) & (fixes <= high) & np.isfinite(apart)
        if inside.sum() >= 3:
            spans.append((float(low), float(high)))
            distance.append(float(np.median(apart[inside])))
    if len(spans) < 2:
        return []
    return [s for s, d in zip(spans, distance) if d - min(distance) > 0.5 * max(largest, 10.0)]
