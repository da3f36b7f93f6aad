"""Positions and velocities of the fixes in another frame or unit than each other, said with the
remedy.
"""

import numpy as np
from scipy.signal import detrend

from imu_lib.drive import Drive
from imu_lib.units import DEG

from . import earth

#: Speeds over those in m/s, by unit.
UNITS = {"km/h": 3.6, "knots": 1.9438, "mph": 2.2369, "ft/s": 3.2808, "cm/s": 100.0, "mm/s": 1000.0}
ROLLING, OPPOSED = 1.0, -0.7  # m of heights that tell, and a correlation that no road has


def _sunk(drive):
    """How far the positions have sunk and how far the velocities have gone down, m, (k,) each,
    without their trends; None where there is too little.
    """
    if drive.gnss_velocity is None:
        return None
    time = np.asarray(drive.gnss_time)
    height, down = np.asarray(drive.gnss_position)[:, 2], np.asarray(drive.gnss_velocity)[:, 2]
    good = np.isfinite(height) & np.isfinite(down)
    time, height, down = time[good], height[good], down[good]
    if time.size < 50:
        return None
    gone = np.append(0.0, np.cumsum(0.5 * (down[1:] + down[:-1]) * np.diff(time)))
    return detrend(-height), detrend(gone)


def upside_down(drive: Drive) -> bool:
    """Whether the fixes' heights rise where their velocities fall."""
    both = _sunk(drive)
    return both is not None and np.std(both[1]) > ROLLING and np.corrcoef(*both)[0, 1] < OPPOSED


def height_ratio(drive: Drive) -> float:
    """How many times as far the heights move as the velocities say; 1 where both agree, or too
    little is known.
    """
    both = _sunk(drive)
    if both is None or np.std(both[1]) < ROLLING or np.corrcoef(*both)[0, 1] < -OPPOSED:
        return 1.0
    sunk, gone = both
    ratio = float(sunk @ gone / (gone @ gone))
    return ratio if not 0.6 < ratio < 1.6 else 1.0


def _motion(drive, velocity=None):
    """Horizontal velocities (k, 2) at which positions move over about 2 s, and those that the
    fixes state (velocity : (m, 3) in their place), where they are quick.
    """
    time = np.asarray(drive.gnss_time)
    position = np.asarray(drive.gnss_position)
    velocity = np.asarray(drive.gnss_velocity if velocity is None else velocity)
    later = np.searchsorted(time, time + 2.0)
    k = np.flatnonzero(later < time.size)
    later = later[k]
    k, later = k[time[later] - time[k] < 4.0], later[time[later] - time[k] < 4.0]
    moved = earth.meters(position[later], position[k])[:, :2] / (time[later] - time[k])[:, None]
    went = 0.5 * (velocity[k] + velocity[later])[:, :2]
    fast = np.linalg.norm(went, axis=1) > 3.0
    return moved[fast], went[fast]


def _apart(moved, went):
    return float(np.median(np.linalg.norm(moved - went, axis=1)))


def _by_course(velocity, unit):
    """North, east, down of velocities that stand as speed, course and down."""
    speed, course = velocity[:, 0], velocity[:, 1] * unit
    return np.column_stack([speed * np.cos(course), speed * np.sin(course), velocity[:, 2]])


#: What velocities may be in the place of north, east, down, how they become that, and the remedy.
FRAMES = (
    (
        "are east, north, up",
        lambda v: v[:, [1, 0, 2]] * [1.0, 1.0, -1.0],
        "swap the first two columns of gnss_velocity and turn the third's sign",
    ),
    (
        "go west where the positions go east",
        lambda v: v * [1.0, -1.0, 1.0],
        "turn the sign of the longitudes (west of Greenwich they are negative), or of the second "
        "column of gnss_velocity",
    ),
    (
        "go south where the positions go north",
        lambda v: v * [-1.0, 1.0, 1.0],
        "turn the sign of the latitudes (south of the equator they are negative), or of the first "
        "column of gnss_velocity",
    ),
    (
        "are speed and course, in deg",
        lambda v: _by_course(v, DEG),
        "write speed times cosine and sine of the course into its first two columns",
    ),
    (
        "are speed and course, in rad",
        lambda v: _by_course(v, 1.0),
        "write speed times cosine and sine of the course into its first two columns",
    ),
)


def other_frame(drive: Drive) -> str | None:
    """Velocities that fit their own positions in another frame only, said with the remedy, or
    None.
    """
    if drive.gnss_velocity is None:
        return None
    moved, went = _motion(drive)
    if len(moved) < 50:
        return None
    straight, found = _apart(moved, went), []
    for what, turned, remedy in FRAMES:
        fits = _motion(drive, turned(np.asarray(drive.gnss_velocity, float)))
        if len(fits[0]) >= 50 and _apart(*fits) < 0.5 * straight:
            found.append((_apart(*fits), what, remedy))
    if straight < 2.0 or not found:
        return None
    _, what, remedy = min(found)
    return f"the fixes' velocities {what}; a drive holds north, east, down: {remedy}."


def positions_swapped(drive: Drive) -> bool:
    """Whether the fixes' velocities fit their positions with latitude and longitude exchanged
    only.
    """
    position = np.asarray(drive.gnss_position, float)
    if drive.gnss_velocity is None or np.nanmax(np.abs(position[:, 1])) > np.pi / 2:
        return False
    moved, went = _motion(drive)
    if len(moved) < 50:
        return False
    other, _ = _motion(drive.with_(gnss_position=position[:, [1, 0, 2]]))
    best = min(_apart(moved, went), _apart(moved, went[:, ::-1]))
    return _apart(other, went) < 0.5 * best and best > 1.0


def speed_ratio(drive: Drive) -> float:
    """Stated speeds over those at which the positions move; 1 where both agree within a fifth, or
    too little is known.
    """
    if drive.gnss_velocity is None:
        return 1.0
    moved, went = (np.linalg.norm(v, axis=1) for v in _motion(drive))
    quick = moved > 1.0
    if quick.sum() < 50:
        return 1.0
    ratio = float(np.median(went[quick] / moved[quick]))
    return ratio if not 0.8 < ratio < 1.25 else 1.0


def unit_of(ratio: float) -> str | None:
    """The unit whose speeds are so many times those in m/s, or None."""
    return next((u for u, factor in UNITS.items() if abs(ratio / factor - 1.0) < 0.06), None)


def other_unit(drive: Drive) -> str | None:
    """Velocities in another unit than m/s, said with the remedy, or None."""
    ratio = speed_ratio(drive)
    unit = unit_of(ratio)
    if unit is None:
        return None
    return (
        f"the fixes' velocities are {ratio:.3g} times those at which their positions move: they "
        f"are in {unit}; divide gnss_velocity by {UNITS[unit]:.4g}."
    )


def unusable(drive: Drive) -> str | None:
    """Positions or velocities in other axes than those of a drive, said with the remedy, or
    None.
    """
    return wrong_positions(drive) or wrong_velocities(drive)


def wrong_positions(drive: Drive) -> str | None:
    """Positions that are not latitude, longitude in rad, said with the remedy, or None."""
    if positions_swapped(drive):
        return (
            "the fixes' positions are longitude, latitude; a drive holds latitude, longitude: "
            "swap the first two columns of gnss_position."
        )
    if 0.95 < 0.6 * (ratio := speed_ratio(drive)) < 1.05:
        return (
            f"the fixes' positions move {1.0 / ratio:.2g} times as far as their velocities say, as "
            "where degrees and minutes (ddmm.mmmm) were read as degrees: divide the minutes by 60."
        )
    return None


def wrong_velocities(drive: Drive) -> str | None:
    """Velocities in other axes than those of the positions, said with the remedy, or None."""
    if said := other_frame(drive):
        return said
    if upside_down(drive):
        return (
            "the heights rise where the fixes' velocities fall: a drive holds north, east, down; "
            "turn the sign of the third column of gnss_velocity, or of the heights if they are "
            "depths."
        )
    return None
