"""What of a drive can be searched: enough of it, in SI units, and the fixes of one solution."""

from __future__ import annotations

import numpy as np

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.navigation import fix_faults, fix_frames, fix_motion, unfit, windows
from imu_lib.navigation.fix_velocity import MOVING

SHORTEST = 60.0  # s
FEWEST = 40  # fixes
CONTRADICTED = 0.1  # share of velocities


def check(drive: Drive) -> None:
    """InputError where a drive has too little to be searched, or no filter can use it."""
    unfit.refuse(drive)
    inside = (drive.gnss_time >= drive.time[0]) & (drive.gnss_time <= drive.time[-1])
    fixes = int((np.isfinite(drive.gnss_position).all(axis=1) & inside).sum())
    if drive.duration < SHORTEST or fixes < FEWEST:
        raise InputError(
            f"{drive.called}: {drive.duration:.3g} s with {fixes} "
            f"fixes are too few for a search; it needs {SHORTEST:.0f} s and {FEWEST} fixes."
        )
    if not (windows.speeds(drive)[1] > MOVING).any():
        raise InputError(
            f"{drive.called} never moves faster than {MOVING:g} m/s: "
            "neither its heading nor what grows with motion shows; a search needs a drive that "
            "moves."
        )


def _of_one_code(drive: Drive, notes: list[str]) -> Drive:
    """The drive with the fixes of those codes whose velocities are the ones at which their
    positions move, where the others' are not: a file may hold two solutions in turn.
    """
    if drive.gnss_velocity is None or drive.gnss_fix is None:
        return drive
    codes = np.asarray(drive.gnss_fix)
    shares = {}
    for code in np.unique(codes[np.isfinite(codes)]):
        mine = codes == code
        if mine.sum() > max(FEWEST, 0.02 * codes.size):
            shares[code] = _contradicted(drive.with_fixes(mine))
    good = [c for c, share in shares.items() if share < 0.3 * CONTRADICTED]
    rest = [c for c, share in shares.items() if share > CONTRADICTED]
    kept = np.isin(codes, good)
    if not rest or kept.sum() < max(FEWEST, 0.3 * codes.size):
        return drive
    notes.append(
        f"Fixes of code {', '.join(f'{c:g}' for c in rest)} are another solution, whose velocities "
        "are not those at which its positions move: those of code "
        f"{', '.join(f'{c:g}' for c in good)} alone are used (--accept of `outages`)."
    )
    return drive.with_fixes(kept)


def _contradicted(drive: Drive) -> float:
    """Share of the velocities that are not those at which the positions move; a wild position
    moves as no velocity says, and is left out.
    """
    time, position = np.asarray(drive.gnss_time), np.asarray(drive.gnss_position, float)
    wild = fix_faults.far_off(time, position)
    return float(np.mean(fix_motion.contradicted(drive.with_fixes(~wild))))


def _stated(drive: Drive, notes: list[str]) -> Drive:
    """The drive without standard deviations that are nowhere above zero: nothing is stated
    there.
    """
    for part in ("position", "velocity"):
        sd = getattr(drive, f"gnss_{part}_sd")
        if sd is not None and not np.any(np.asarray(sd) > 0.0):
            notes.append(
                f"The stated standard deviations of the {part} are zero: usual ones are taken."
            )
            drive = drive.with_(**{f"gnss_{part}_sd": None})
    return drive


def one_solution(drive: Drive, notes: list[str]) -> Drive:
    """The drive with its positions alone where many of its velocities are not those at which the
    positions move.
    """
    drive = _stated(drive, notes)
    drive = _of_one_code(drive, notes)
    if drive.gnss_velocity is None:
        return drive
    if unit := fix_frames.other_unit(drive):
        notes.append(f"{unit[0].upper()}{unit[1:-1]}; until then positions alone are used.")
        return drive.without_velocity()
    share = _contradicted(drive)
    if share < CONTRADICTED:
        return drive
    notes.append(
        f"{100 * share:.0f} % of the velocities are not those at which the positions move: "
        "positions alone are used."
    )
    return drive.without_velocity()
