"""What the fixes of a drive say against themselves: velocities, heights, jumps, repeats, and
scatter against what is stated.
"""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.navigation import earth, fix_faults, fix_frames, fix_rounding, preparation

RATIO = 3.0  # of the fixes' scatter to what is stated
WAYS = ("north", "east", "down")
COARSE = 0.3  # m between one position that the file can hold and the next
JOLTED = 0.25  # m/s that cars add to a velocity's scatter from one fix to the next


def sentence(said: str) -> str:
    """With a capital letter."""
    return said[0].upper() + said[1:]


def velocities(drive: Drive) -> tuple[list[str], Drive]:
    """What is said of the fixes' velocities, and the drive without them where they are not those
    at which the positions move.
    """
    if drive.gnss_velocity is None or fix_frames.positions_swapped(drive):
        return [], drive
    said = fix_frames.unusable(drive) or fix_frames.other_unit(drive)
    if said is None:
        return _contradicted(drive)
    return [sentence(said)], drive.without_velocity()


def _contradicted(drive):
    """What is said of velocities that are not those of their positions, of some fix codes or of
    all, and the drive without them.
    """
    ratio = fix_frames.speed_ratio(drive)
    if ratio != 1.0:
        said = (
            f"The fixes' velocities are {ratio:.3g} times those at which their positions move: one "
            "of the two is in another unit or of another solution."
        )
        return [said], drive.without_velocity()
    apart = preparation.disagreement(drive)
    wrong = [code for code, size in apart.items() if size > preparation.VELOCITY_TRUST]
    if not wrong:
        return _scatter(drive), drive
    of = "" if len(apart) == 1 else f" of code {', '.join(f'{code:g}' for code in wrong)}"
    said = (
        f"The velocities of the fixes{of} are {max(apart[c] for c in wrong):.1f} m/s, in the "
        "median, from those at which their positions move: of another solution or vehicle, in "
        "another frame, or none; they are not used."
    )
    if len(wrong) == len(apart):
        return [said], drive.without_velocity()
    left = np.where(np.isin(drive.gnss_fix, wrong)[:, None], np.nan, drive.gnss_velocity)
    return [said], drive.with_(gnss_velocity=left)


def _scatter(drive):
    """Velocities that change from one to the next by more than they state."""
    velocity = np.asarray(drive.gnss_velocity)[:, :2]
    step = np.diff(np.asarray(drive.gnss_time))
    even = np.abs(step[1:] - step[:-1]) < 0.2 * np.median(step)
    jolt = np.diff(velocity, 2, axis=0)[even]
    jolt = jolt[np.isfinite(jolt).all(axis=1)]
    if len(jolt) < 50:
        return []
    scatter = 1.48 * float(np.median(np.abs(jolt))) / np.sqrt(6.0)
    sd = drive.gnss_velocity_sd
    stated = 0.0 if sd is None else float(np.nanmedian(np.asarray(sd)[:, :2]))
    if scatter < RATIO * np.hypot(stated, JOLTED):
        return []
    told = "" if sd is None else f" where {stated:.2g} m/s is stated"
    return [
        f"The velocities scatter by {scatter:.2g} m/s from one to the next{told}: `imu-lib gap` "
        "says by how much they are worse (gnss_noise)."
    ]


def heights(drive: Drive) -> list[str]:
    """Heights that do not move as the velocities say."""
    ratio = fix_frames.height_ratio(drive)
    if ratio == 1.0:
        return []
    unit = "; divide them by 3.281, they are in feet" if 2.9 < ratio < 3.7 else ""
    return [
        f"The heights move {ratio:.3g} times as far as the fixes' velocities say: one of the two "
        f"is in another unit or of another solution{unit}."
    ]


def jumps(drive: Drive) -> list[str]:
    """Positions that jump and stay there."""
    time, size = fix_faults.jumps(drive)
    if not time.size:
        return []
    k = int(np.argmax(np.linalg.norm(size, axis=1)))
    down, aside = size[k, 2], float(np.hypot(*size[k, :2]))
    what = f"heights by {-down:+.0f} m" if abs(down) > aside else f"positions by {aside:.0f} m"
    often = "once" if time.size == 1 else f"{time.size} times"
    return [
        f"The fixes jump {often} and stay there, their {what} at {time[k]:.1f} s, where the fixes "
        "about it do not move: another datum (geoid or "
        "ellipsoid), base station or solution from then on; bring them to one, or cut the drive "
        "there (--start, --stop)."
    ]


def held(drive: Drive, which: np.ndarray) -> list[str]:
    """Fixes (m,) that only repeat the one before."""
    if not which.any():
        return []
    first = float(np.asarray(drive.gnss_time)[which][0])
    return [
        f"{which.sum()} of {which.size} fixes repeat the position of the one before while the "
        f"drive goes on, the first at {first:.1f} s: the receiver "
        "holds its last solution; `outages` and `gap` do not use them."
    ]


def rounded(drive: Drive) -> list[str]:
    """Positions printed with too few digits."""
    steps = fix_rounding.steps(drive)
    coarse = [
        f"{name} by {step:.2g} m" for name, step in zip(WAYS, steps, strict=True) if step > COARSE
    ]
    if not coarse:
        return []
    return [
        f"The positions step {' and '.join(coarse)}: the file holds too few of their digits; write "
        "them with at least nine decimals of a radian or seven of a degree. `outages` and `gap` "
        "add what rounding costs to what is stated."
    ]


def exact(drive: Drive) -> list[str]:
    """Standard deviations that are no size of an error."""
    out = []
    usual = preparation.Gnss()
    for part, unit in (("position", "m"), ("velocity", "m/s")):
        sd = getattr(drive, f"gnss_{part}_sd")
        none = np.zeros(0, bool) if sd is None else np.any(np.asarray(sd) == 0.0, axis=1)
        if none.any():
            taken = ", ".join(f"{v:g}" for v in getattr(usual, f"{part}_sd"))
            out.append(
                f"{none.sum():,} of {none.size:,} fixes state that their {part} errs by nothing, "
                f"the first at {np.asarray(drive.gnss_time)[none][0]:.1f} s: no receiver does, and "
                f"{taken} {unit} (north, east, down) are taken there; leave the deviations empty "
                "where they are not known."
            )
    return out


def scatter(drive: Drive) -> list[str]:
    """Positions against their own velocities, over one interval between fixes."""
    if drive.gnss_velocity is None:
        return []
    time = np.asarray(drive.gnss_time)
    position, velocity = np.asarray(drive.gnss_position), np.asarray(drive.gnss_velocity)
    step = np.diff(time)
    good = (
        np.isfinite(position).all(axis=1)
        & np.isfinite(velocity).all(axis=1)
        & np.append(step < 1.5 * np.median(step), False)
    )
    k = np.flatnonzero(good[:-1] & good[1:])
    if k.size < 50:
        return []
    moved = earth.meters(position[k + 1], position[k])
    went = 0.5 * (velocity[k] + velocity[k + 1]) * step[k, None]
    out = []
    if drive.gnss_position_sd is None or not np.isfinite(drive.gnss_position_sd).any():
        return out
    scatter = 1.48 * np.median(np.abs(moved - went)[:, :2])
    sd = np.asarray(drive.gnss_position_sd)
    stated = np.sqrt(2.0) * np.nanmedian(sd[:, :2])
    extra = step.mean() * np.nanmedian(
        0.1 if drive.gnss_velocity_sd is None else np.asarray(drive.gnss_velocity_sd)[:, :2]
    )
    if scatter > RATIO * np.hypot(stated, extra):
        out.append(
            f"The positions scatter by {scatter / np.sqrt(2):.2g} m from one to the next where "
            f"{stated / np.sqrt(2):.2g} m is stated: "
            "their standard deviations are too small; `imu-lib gap` says by how much (gnss_noise)."
        )
    elif scatter < stated / (3.0 * RATIO):
        out.append(
            f"The positions scatter by {scatter / np.sqrt(2):.2g} m from one to the next where "
            f"{stated / np.sqrt(2):.2g} m is stated: "
            "their errors last (gnss_correlated) or the standard deviations are too large; "
            "`imu-lib gap` says which."
        )
    return out
