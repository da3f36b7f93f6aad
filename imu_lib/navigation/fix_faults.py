"""What the fixes say against themselves: positions far off between their neighbours, or that jump
for good, or that only repeat the last; velocities in another frame or unit than the positions.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter
from scipy.signal import detrend

from imu_lib import timing
from imu_lib.arrays import Array
from imu_lib.drive import Drive
from imu_lib.units import DEG

from . import earth

FAR_OFF = 12.0  # times the median distance of a fix from the middle of its neighbours
PASSES = 5
JUMP, STAYS, BESIDE = 10.0, 0.7, 5  # m; share of a jump that stays; fixes on either side
CREEPING = 1.0  # m/s: what repeats its position and creeps on the mean stands
REPEATED = 0.3  # share of the rows
#: Speeds over those in m/s, by unit.
UNITS = {"km/h": 3.6, "knots": 1.9438, "mph": 2.2369, "ft/s": 3.2808, "cm/s": 100.0, "mm/s": 1000.0}
ROLLING, OPPOSED = 1.0, -0.7  # m of heights that tell, and a correlation that no road has


def wild(drive: Drive) -> tuple[float, float] | None:
    """(share, standard deviation m) of positions that lie far off between their neighbours; None
    where there are hardly any, or so many that they are the receiver's usual ones.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1)
    apart, peak = _between(time[good], position[good])
    share = float(peak.mean()) if peak.size else 0.0
    if not 0.002 < share < 0.2:
        return None
    return share, float(np.sqrt(np.mean(apart[peak] ** 2) / 3.0))


def far_off(time: Array, position: Array) -> Array:
    """Which positions (m,) lie far off between their neighbours, those that were found so left
    out of them; (m, 3) rad, rad, m.
    """
    kept = np.arange(len(position))
    for _ in range(PASSES):  # of two wild ones side by side the farther one hides the other
        _, peak = _between(time[kept], position[kept])
        if not peak.any():
            break
        kept = np.delete(kept, 1 + np.flatnonzero(_close(time[kept]))[peak])
    out = np.ones(len(position), bool)
    out[kept] = False
    return out


def _close(time: Array) -> Array:
    """Which fixes but the first and last have both neighbours near in time."""
    return (time[2:] - time[:-2]) < 4.0 * np.median(np.diff(time))


def _between(time: Array, position: Array) -> tuple[Array, Array]:
    """(distance from the middle of its neighbours, m, whether it lies far off) of fixes that have
    them near in time; nothing where fixes are few.
    """
    if time.size < 50:
        return np.zeros(0), np.zeros(0, bool)
    ned = earth.meters(position, position[0])
    part = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], 1e-9)
    apart = ned[1:-1] - ned[:-2] - part[:, None] * (ned[2:] - ned[:-2])
    apart = np.linalg.norm(apart[_close(time)], axis=1)
    size = np.maximum(np.median(apart), 0.01)
    # a wild one moves the middle of its neighbours by half as much, and of two the farther counts
    return apart, (apart > FAR_OFF * size) & (apart >= maximum_filter1d(apart, 5))


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


def held(drive: Drive):
    """Which fixes (m,) only repeat the position of the one before while the drive goes on: of a
    receiver that gives its last solution until it has another.
    """
    position, time = np.asarray(drive.gnss_position, float), np.asarray(drive.gnss_time)
    out = np.zeros(len(position), bool)
    same = (position[1:] == position[:-1]).all(axis=1)
    if not same.any():
        return out
    standing = np.zeros_like(out)
    for first, last in zip(*timing.runs(same), strict=True):  # rows first to last are alike
        standing[first + 1 : last + 1] = True
        if last + 1 >= len(position):
            continue
        moved = float(earth.horizontal(position[last + 1 : last + 2], position[first])[0])
        if moved > CREEPING * (time[last + 1] - time[first]) and moved > 2.0:
            out[first + 1 : last + 1] = True
    # what repeats most of its rows on the way does so where it stands, too
    return out | standing if out.mean() > REPEATED else out


def jumps(drive: Drive):
    """Times (k,) s and sizes (k, 3) m, NED, of jumps of the positions that stay and that the fixes
    before and after, or their velocities, do not explain.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    good = np.isfinite(position).all(axis=1) & ~held(drive)
    velocity = None if drive.gnss_velocity is None else np.asarray(drive.gnss_velocity, float)
    if velocity is not None and np.isfinite(velocity[good]).all(axis=1).mean() > 0.9:
        good &= np.isfinite(velocity).all(axis=1)
        velocity = velocity[good]
    else:
        velocity = None
    time, position = time[good], position[good]
    none = np.zeros(0), np.zeros((0, 3))
    if time.size < 50:
        return none
    step = np.diff(time)
    left = earth.meters(position[1:], position[:-1])
    if velocity is not None:
        left = left - 0.5 * (velocity[1:] + velocity[:-1]) * step[:, None]
    else:
        left = left - median_filter(left / step[:, None], (7, 1)) * step[:, None]
    size = np.linalg.norm(left, axis=1)
    usual = np.median(size) + 1e-3
    large = (size > np.maximum(JUMP, FAR_OFF * usual)) & (step < 4.0 * np.median(step))
    found = []
    for k in np.flatnonzero(large):
        near = left[max(k - BESIDE, 0) : k + BESIDE + 1].sum(axis=0)
        if near @ left[k] > STAYS * size[k] ** 2:
            found.append(k)
    return (time[1:][found], left[found]) if found else none
