"""A drive made ready for the filter: stretches without holes, increments, fixes put to epochs,
de-noised where asked.

Nothing is repaired in silence: what was bridged, left out or cut is said in `notes`.
"""

from dataclasses import dataclass, field, fields, replace

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.record import CHANNELS
from imu_lib.wavelet import denoise

from . import earth, fix_faults, fix_rounding, measurement, stretch

LONGEST_BRIDGE = 1.0  # s: up to here a hole in the IMU data is bridged by straight lines
# m/s: velocities further from the motion of their own positions than this, in the median, are not
# used
VELOCITY_TRUST = 1.0
SPAN = 10.0  # s over which that is asked
HOLE = 2.5  # s between fixes over which no motion is taken
SHORTEST_STRETCH = 5.0  # s: a stretch between holes shorter than this is left out


@dataclass(frozen=True)
class Fixes:
    """GNSS fixes of a drive: time (m,) at which each was taken, value (m, 6) position and NED
    velocity, variance (m, 6) m^2 and (m/s)^2, use (m,) bits of `measurement`, index (m,) row of the
    drive's `gnss_*`. A fix whose velocity is of another time than its position has two rows.
    """

    time: np.ndarray
    value: np.ndarray
    variance: np.ndarray
    use: np.ndarray
    index: np.ndarray

    def take(self, rows):
        """Some of the rows, in the order given."""
        return Fixes(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass(frozen=True)
class Speed:
    """Speed over ground of the wheels: time (k,) s, value (k,) m/s, sd m/s."""

    time: np.ndarray
    value: np.ndarray
    sd: float = 0.2


@dataclass(frozen=True)
class Gnss:
    """How fixes are taken.

    position_sd : m (north, east, down), where the drive gives none; velocity_sd : m/s, likewise
    position_floor, velocity_floor : least standard deviation believed, m and m/s
    latency : s, added to the fixes' time tags; velocity_latency : s, to those of the velocities
    (None: the same); correlation_time : s, of the fixes' errors: fixes that follow each other
    faster
        are given the variance that makes so many of them worth one
    position_ratio, velocity_ratio : true standard deviation over the stated one; position_extra,
    velocity_extra : m and m/s, standard deviation of what the receiver does not count, on each of
    north, east, down (see `fix_noise`); position_steps : m, that the file rounds positions to
    (None: as they show themselves, `fix_rounding`)
    gate : probability with which a true fix passes the innovation test, None for no test; patience
    : s of rejected fixes before the filter widens its covariance velocity : use the velocity where
    there is one; accept : fix codes to take (None: all)
    """

    position_sd: tuple = (2.5, 2.5, 5.0)
    velocity_sd: tuple = (0.1, 0.1, 0.2)
    position_floor: float = 0.01
    velocity_floor: float = 0.01
    latency: float = 0.0
    velocity_latency: float | None = None
    correlation_time: float = 0.0
    position_ratio: float = 1.0
    velocity_ratio: float = 1.0
    position_extra: float = 0.0
    velocity_extra: float = 0.0
    position_steps: tuple | None = None
    gate: float | None = 1.0 - 1e-6
    patience: float = 5.0
    velocity: bool = True
    accept: tuple | None = None


@dataclass(frozen=True)
class Prepared:
    """Stretches, fixes, rate (Hz) and notes of a drive."""

    stretches: tuple
    fixes: Fixes
    rate: float
    notes: tuple = field(default=())


def fixes_of(drive: Drive, gnss: Gnss) -> tuple[Fixes, list[str]]:
    """The usable fixes of a drive, in order of time, each once."""
    notes = []
    time = np.asarray(drive.gnss_time, float) + gnss.latency
    own = gnss.latency if gnss.velocity_latency is None else gnss.velocity_latency
    position = np.asarray(drive.gnss_position, float)
    velocity = (
        np.full_like(position, np.nan)
        if drive.gnss_velocity is None or not gnss.velocity
        else np.asarray(drive.gnss_velocity, float)
    )
    sd = np.column_stack([_deviations(drive, gnss, k, position) for k in ("position", "velocity")])
    has_position = np.isfinite(position).all(axis=1) & (np.abs(position[:, 0]) < np.pi / 2)
    has_velocity = np.isfinite(velocity).all(axis=1)
    held = fix_faults.held(drive)
    if held.any():
        has_position &= ~held
        has_velocity &= ~(held & np.append(False, (velocity[1:] == velocity[:-1]).all(axis=1)))
        notes.append(
            f"{held.sum()} of {time.size} fixes repeat the position of the one before while the "
            "drive goes on, and are not used."
        )
    keep = np.isfinite(time) & (has_position | has_velocity)
    if gnss.accept is not None and drive.gnss_fix is not None:
        keep &= np.isin(drive.gnss_fix, gnss.accept)
    order = np.argsort(time[keep], kind="stable")
    index = np.flatnonzero(keep)[order]
    index = index[np.concatenate([[True], np.diff(time[index]) > 1e-6])] if index.size else index
    lost = time.size - index.size - int((held & ~has_velocity).sum())
    if lost > 0:
        notes.append(
            f"{lost} of {time.size} fixes left out: without a number, repeated, or of a code not "
            "accepted."
        )
    if index.size < 2:
        raise InputError(
            f"{drive.name or 'the drive'} has {index.size} usable GNSS fixes; the filter needs at "
            "least two (look at gnss_position for NaN and at the accepted fix codes)"
        )
    use = has_position[index] * measurement.POSITION + has_velocity[index] * measurement.VELOCITY
    codes = np.zeros(index.size) if drive.gnss_fix is None else np.asarray(drive.gnss_fix)[index]
    for code in np.unique(codes[has_velocity[index]]):
        of = np.flatnonzero((codes == code) & (use == measurement.POSITION + measurement.VELOCITY))
        apart = _disagreement(
            time[index][of], position[index][of], velocity[index][of], own - gnss.latency
        )
        if apart > VELOCITY_TRUST:
            use[codes == code] &= ~measurement.VELOCITY
            notes.append(
                f"The velocities of fix code {code:g} disagree with their own positions by "
                f"{apart:.1f} m/s and are not used."
            )
    grid = fix_rounding.steps(drive) if gnss.position_steps is None else gnss.position_steps
    variance = sd[index] ** 2 + fix_rounding.variance(grid)
    if gnss.correlation_time > 0.0:
        variance = variance * max(
            1.0, 2.0 * gnss.correlation_time / float(np.median(np.diff(time[index])))
        )
    value = np.nan_to_num(np.column_stack([position, velocity])[index])
    fixes = Fixes(time[index], value, variance, use.astype(np.int64), index)
    return _apart(fixes, own - gnss.latency), notes


def _deviations(drive, gnss, part, like):
    """Standard deviations (m, 3) of the fixes' position or velocity: stated or usual, not below the
    floor, and what the receiver does not count.
    """
    given, usual = getattr(drive, f"gnss_{part}_sd"), np.asarray(getattr(gnss, f"{part}_sd"))
    ratio, floor, extra = (getattr(gnss, f"{part}_{k}") for k in ("ratio", "floor", "extra"))
    sd = np.full(like.shape, np.nan) if given is None else np.asarray(given, float) * ratio
    with np.errstate(invalid="ignore"):
        good = np.isfinite(sd) & (sd > 0.0)
        return np.hypot(np.where(good, np.maximum(sd, floor), usual * ratio), extra)


def _apart(fixes: Fixes, later):
    """Velocities `later` s than their positions stand in rows of their own."""
    both = fixes.use == measurement.POSITION + measurement.VELOCITY
    if later == 0.0 or not (fixes.use & measurement.VELOCITY).any():
        return fixes
    rows = np.concatenate([np.arange(both.size), np.flatnonzero(both)])
    second = np.arange(rows.size) >= both.size
    out = fixes.take(rows)
    use = np.where(
        second, measurement.VELOCITY, np.where(both[rows], measurement.POSITION, out.use)
    )
    time = out.time + np.where(use == measurement.VELOCITY, later, 0.0)
    return replace(out, time=time, use=use).take(np.argsort(time, kind="stable"))


def disagreement(drive: Drive) -> dict[float, float]:
    """Median distance, m/s, of a drive's velocities from the motion of their positions over SPAN s,
    by fix code (0 where the file has none); 0 where there is too little.
    """
    if drive.gnss_velocity is None:
        return {}
    good = np.isfinite(drive.gnss_position).all(axis=1) & np.isfinite(drive.gnss_velocity).all(1)
    codes = np.zeros(good.size) if drive.gnss_fix is None else np.asarray(drive.gnss_fix)
    given = (drive.gnss_time, drive.gnss_position, drive.gnss_velocity)
    return {
        float(code): _disagreement(*(np.asarray(v)[good & (codes == code)] for v in given))
        for code in np.unique(codes[good])
    }


def _disagreement(time, position, velocity, later=0.0):
    """Median distance, m/s, between received velocities, taken `later` s than the positions, and
    the motion of those positions over SPAN s, which is long enough for the noise of a position not
    to matter; 0 where there are too few.
    """
    if time.size < 20:
        return 0.0
    mean = 0.5 * (velocity[1:, :2] + velocity[:-1, :2]) * np.diff(time)[:, None]
    path = np.vstack([np.zeros(2), np.cumsum(mean, axis=0)])
    holes = np.concatenate([[0], np.cumsum(np.diff(time) > HOLE)])
    after = np.minimum(np.searchsorted(time, time + SPAN), time.size - 1)
    gap = time[after] - time
    good = (holes[after] == holes) & (gap > 0.5 * SPAN)
    if good.sum() < 20:
        return 0.0
    at = np.column_stack([np.interp(time - later, time, column) for column in path.T])
    said = (at[after[good]] - at[good]) / gap[good, None]
    moved = earth.meters(position[after[good]], position[good])[:, :2] / gap[good, None]
    return float(np.median(np.linalg.norm(moved - said, axis=1)))


def prepare(
    drive: Drive, *, levels=None, causal=False, gnss: Gnss = Gnss(), sampling="average"
) -> Prepared:
    """Make a drive ready.

    levels : mapping of channel to wavelet levels (missing: 0), or one number for all six
    causal : passed to `imu_lib.wavelet.denoise`; False uses the future, as the 2013 paper does
    sampling : "average" where a reading is the mean over the interval that it ends, "point" where
    it is the value at its time
    """
    if sampling not in ("average", "point"):
        raise ValueError(f"`sampling` must be 'average' or 'point', not {sampling!r}")
    time, rate = np.asarray(drive.time, float), drive.rate
    notes = []
    step = np.diff(time)
    edges = np.concatenate([[0], np.flatnonzero(step > LONGEST_BRIDGE) + 1, [time.size]])
    parts = [
        (a, b)
        for a, b in zip(edges[:-1], edges[1:])
        if b > a + 1 and time[b - 1] - time[a] >= SHORTEST_STRETCH
    ]
    if not parts:
        raise InputError(
            f"{drive.name or 'the drive'} has no stretch of {SHORTEST_STRETCH:g} s of IMU data "
            f"without a hole of {LONGEST_BRIDGE:g} s"
        )
    if edges.size > 2:
        holes = step[step > LONGEST_BRIDGE]
        notes.append(
            f"The IMU data have {holes.size} holes of {holes.min():.1f} to {holes.max():.1f} s: "
            "the filter starts anew after each, sensor states kept."
        )
    levels = (
        {c: levels for c in CHANNELS}
        if isinstance(levels, (int, np.integer))
        else dict(levels or {})
    )
    unknown = sorted(set(levels) - set(CHANNELS))
    if unknown:
        raise ValueError(f"`levels` names {unknown[0]!r}; channels are {', '.join(CHANNELS)}")
    stretches, bridged = [], 0
    for a, b in parts:
        readings = np.column_stack([drive.gyro[a:b], drive.accel[a:b]]).astype(float)
        t, readings, noise, count = stretch.bridged(time[a:b], readings, rate)
        bridged += count
        for i, channel in enumerate(CHANNELS):
            if levels.get(channel, 0):
                readings[:, i] = denoise(readings[:, i], levels[channel], causal=causal)
        stretches.append(stretch.of_readings(t, readings, noise, sampling))
    if bridged:
        notes.append(
            f"{bridged} missing IMU samples bridged by straight lines, with "
            f"{stretch.BRIDGE_NOISE:g} times the noise density."
        )
    fixes, more = fixes_of(drive, gnss)
    return Prepared(tuple(stretches), fixes, rate, tuple(notes + more))
